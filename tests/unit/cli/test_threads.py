"""Commands compute with one thread, whatever the surroundings say: their results are the same on every machine."""

from __future__ import annotations

import os
import subprocess
import sys

SHOWN = """
import os, sys
from wpcal.cli import main
print("numpy" in sys.modules)
main.wpcal.main = lambda **_: print(os.environ["OPENBLAS_NUM_THREADS"], os.environ["OMP_NUM_THREADS"])
main.run([])
"""


def test_a_command_computes_with_one_thread() -> None:
    many = {"OPENBLAS_NUM_THREADS": "8", "OMP_NUM_THREADS": "8"}
    done = subprocess.run(
        [sys.executable, "-c", SHOWN], env={**os.environ, **many}, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["False", "1", "1"]
