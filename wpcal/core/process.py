"""What a process asks of the system: threads of its linear algebra, and memory while it makes large results."""

from __future__ import annotations

import ctypes
import gc
import os
import sys

ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "VECLIB_MAXIMUM_THREADS"), "1"
)
"""Environment of a process that computes with one thread. The order of its sums is then fixed, so that machines with
different numbers of processors write the same bytes. Its matrices are too small to gain from more threads; on a busy
machine threads that wait for one another cost up to 30 times the processor time."""
NEW_OBJECTS = 100_000
"""Python's own 700 made it look a thousand times while the records of a large part were made: three quarters of that
time, and nothing was found."""
OLDER_ROUNDS = 50  #: Older objects are looked at after this many rounds of the younger ones.


def use_one_thread() -> None:
    """Let this process, and those that it starts, compute with one thread. NumPy must not have been imported yet."""
    os.environ.update(ONE_THREAD)


def collect_rarely() -> None:
    """Look for such objects after `NEW_OBJECTS` new ones: for processes that make large results and then end."""
    gc.set_threshold(NEW_OBJECTS, OLDER_ROUNDS, OLDER_ROUNDS)


def give_memory_back() -> None:
    """Give free pages back to the system where its C library can (glibc): new arrays take other pages."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim is not None:  # musl has none
        trim(0)
