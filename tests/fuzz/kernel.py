"""Damaged STEP files through the CAD kernel, each in a process of its own, as the commands do it.

    python -m tests.fuzz.kernel [--inputs 2000] [--seed 0] [FILE.step …]

A crash of the kernel is no finding: commands say in one line that the kernel cannot read the file. Findings are
exceptions of other kinds than wpcal's own. Ends with 1 if there are any.
"""

import argparse
import os
import random
import resource
import signal
import sys
import tempfile
import traceback
from collections import Counter
from pathlib import Path

from cad.step.read import read_step
from tests.fuzz.findings import keep
from tests.fuzz.judge import MOST_SECONDS
from tests.fuzz.mutate import mutated
from tests.fuzz.target import FIXTURES
from wpcal.core.errors import InputError, KernelError

MOST_MEMORY_BYTES = 4 * 2**30
OUTCOMES = {0: "read", 2: "refused", 4: "the kernel fails in order", 70: "FAULT"}


def main() -> int:
    """Try damaged copies of STEP files and print how many ended how."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE.step")
    parser.add_argument("--inputs", type=int, default=2000)
    parser.add_argument("--seed", default="0")
    arguments = parser.parse_args()
    paths = arguments.files or [FIXTURES / name / f"{name}.step" for name in ("tee", "lap", "saddle", "frame")]
    seeds = [path.read_bytes() for path in paths]
    rng, found = random.Random(arguments.seed), Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        for _ in range(arguments.inputs):
            data = mutated(rng.choice(seeds), seeds, rng)
            outcome = read_in_child(data, Path(folder) / "part.step")
            found[outcome] += 1
            if outcome == OUTCOMES[70]:
                print(f"kept as {keep('kernel', data)}", flush=True)
    for outcome, count in found.most_common():
        print(f"{count:6} {outcome}")
    return 1 if found[OUTCOMES[70]] else 0


def read_in_child(data: bytes, path: Path) -> str:
    """Read a file in a copy of this process, in which the kernel is already loaded, and say how that ended."""
    path.write_bytes(data)
    child = os.fork()
    if child == 0:
        os._exit(_outcome(path))
    _, status = os.waitpid(child, 0)
    if not os.WIFSIGNALED(status):
        return OUTCOMES[os.waitstatus_to_exitcode(status)]
    name = signal.Signals(os.WTERMSIG(status)).name
    return f"more than {MOST_SECONDS:g} s in the kernel" if name == "SIGXCPU" else f"the kernel crashes ({name})"


def _outcome(path: Path) -> int:
    resource.setrlimit(resource.RLIMIT_CPU, (int(MOST_SECONDS), int(MOST_SECONDS) + 1))
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY_BYTES, MOST_MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    try:
        read_step(path)
    except InputError:
        return 2
    except KernelError:
        return 4
    except BaseException:  # what this searches for
        traceback.print_exc()
        return 70
    return 0


if __name__ == "__main__":
    sys.exit(main())
