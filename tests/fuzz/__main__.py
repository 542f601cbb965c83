"""`make fuzz`: many wrong inputs for every reader; what it finds is kept in `tests/fuzz/findings` and tested in CI.

    python -m tests.fuzz [--seconds 600] [--inputs 100000] [--seed 0] [--atheris] [READER …]

Ends with 1 if it found something. Without ``--atheris`` no coverage is measured: inputs that a reader accepts are
changed further. This tries more inputs in the same time, and finds what numbers, separators and repeats can do. With
``--atheris`` (extra `fuzz`) inputs that reach new lines are changed further.
"""

import argparse
import random
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

from tests.fuzz.findings import FINDINGS, keep
from tests.fuzz.judge import judge
from tests.fuzz.mutate import mutated
from tests.fuzz.target import Target
from tests.fuzz.targets import targets

MOST_MEMORY_BYTES = 3 * 2**30  #: Address space of the whole run: Python, NumPy, SciPy and one input take 1 GB of it.
ROOM = 1.5  #: Size of a kept input relative to the largest seed.
KEPT = 400  #: Accepted inputs that are changed further, in place of knowing which lines of the code they reach.


@dataclass(slots=True)
class Tally:
    """What was found for one reader."""

    inputs: int = 0
    accepted: int = 0
    slowest_s: float = 0.0
    faults: dict[str, bytes] = field(default_factory=dict)


def run(target: Target, *, seconds: float, inputs: int, seed: str, folder: Path) -> Tally:
    """Try inputs until their number or the time is reached."""
    rng, tally, pool = random.Random(seed), Tally(), list(target.seeds)
    largest = ROOM * max(map(len, pool)) + 1000  # larger ones would grow without end, and take the time of many
    end = time.monotonic() + seconds
    for data in target.seeds:
        judged = judge(target, data, folder)
        if judged.fault or not judged.was_read:
            tally.faults[f"a seed is refused: {judged.fault}"] = data
    while tally.inputs < inputs and time.monotonic() < end:
        data = mutated(rng.choice(pool), target.seeds, rng)
        judged = judge(target, data, folder)
        tally.inputs += 1
        tally.slowest_s = max(tally.slowest_s, judged.seconds)
        if judged.fault:
            kept = tally.faults.get(judged.fault)
            tally.faults[judged.fault] = data if kept is None or len(data) < len(kept) else kept
        elif judged.was_read:
            tally.accepted += 1
            if len(data) > largest:
                continue
            if len(pool) < KEPT:
                pool.append(data)
            elif rng.random() < 0.05:
                pool[rng.randrange(len(target.seeds), KEPT)] = data
    return tally


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("readers", nargs="*", metavar="READER", help=f"of {', '.join(targets())}")
    parser.add_argument("--seconds", type=float, default=600.0, help="for all readers together")
    parser.add_argument("--inputs", type=int, default=100_000, help="most inputs for one reader")
    parser.add_argument("--seed", default="0")
    parser.add_argument("--atheris", action="store_true", help="let atheris choose what is changed")
    arguments = parser.parse_args()
    names = arguments.readers or list(targets())
    if arguments.atheris:
        return with_atheris(names, seconds=arguments.seconds / len(names), inputs=arguments.inputs)
    resource.setrlimit(resource.RLIMIT_AS, (MOST_MEMORY_BYTES, MOST_MEMORY_BYTES))
    found = 0
    print(f"{'reader':24} {'inputs':>8} {'accepted':>8} {'slowest s':>9} {'faults':>6}")
    with tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None) as folder:
        for name in names:
            tally = run(
                targets()[name],
                seconds=arguments.seconds / len(names),
                inputs=arguments.inputs,
                seed=f"{arguments.seed} {name}",
                folder=Path(folder),
            )
            print(f"{name:24} {tally.inputs:8} {tally.accepted:8} {tally.slowest_s:9.2f} {len(tally.faults):6}")
            for fault, data in tally.faults.items():
                print(f"    {fault}: kept as {keep(name, data)}", flush=True)
            found += len(tally.faults)
    print(f"most memory {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1000:.0f} MB")
    return 1 if found else 0


def with_atheris(names: list[str], *, seconds: float, inputs: int) -> int:
    """Run atheris for each reader in a process of its own, which it ends itself."""
    before = set(FINDINGS.glob("*/*"))
    for name in names:
        print(name, flush=True)
        command = [sys.executable, "-m", "tests.fuzz.with_atheris", name, str(int(seconds)), str(inputs)]
        subprocess.run(command, check=True)
    return 1 if set(FINDINGS.glob("*/*")) - before else 0


if __name__ == "__main__":
    sys.exit(main())
