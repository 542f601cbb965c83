"""How many threads the linear algebra of a process uses."""

from __future__ import annotations

import os

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)
"""Environment of a process that computes with one thread. The order of its sums is then fixed, so that machines with
different numbers of processors write the same bytes. Its matrices are too small to gain from more threads; on a busy
machine threads that wait for one another cost up to 30 times the processor time."""


def use_one_thread() -> None:
    """Let this process, and those that it starts, compute with one thread. NumPy must not have been imported yet."""
    os.environ.update(ONE_THREAD)
