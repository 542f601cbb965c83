"""Damaged STEP files through everything that a command does with a part: features, seams, calibration, its files.

    python -m tests.fuzz.chain [--inputs 1000] [--seconds 600] [--seed 0] [FILE.step …]

Files count that still read. Each runs in a copy of this process. Allowed are wpcal's own errors within 10 s of
processor time after the reading, and results without NaN in which `wpcal audit` finds no fault. Ends with 1 if
something else happened.
"""

import argparse
import faulthandler
import json
import math
import os
import random
import re
import resource
import signal
import sys
import tempfile
import time
import traceback
import warnings
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import IO, Any

import numpy as np

from cad.step.read import read_step
from cad.workpiece.calibrate import calibrate_files
from cad.workpiece.features import judge_workpiece
from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import Workpiece, open_workpiece
from tests.fuzz.findings import keep
from tests.fuzz.judge import MOST_SECONDS
from tests.fuzz.mutate_step import mutated_step
from tests.fuzz.target import FIXTURES
from tests.fuzz.targets import MOVED
from wpcal.controllers.audit import audit_path
from wpcal.core.errors import InputError, KernelError, WpcalError
from wpcal.seam import SeamOptions
from wpcal.taught.table import TaughtPoints

MOST_MEMORY_BYTES = 4 * 2**30
FEWEST_POINTS, MOST_POINTS = 4, 8
NOT_READ, READ = "not read", "read"
CRASH = "the kernel crashes"
TOLD = "told: "  #: Begins the lines that the chain writes; others are of the interpreter that ends.


def main() -> int:
    """Try damaged copies of STEP files until enough of them read, and print how many ended how."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*", type=Path, metavar="FILE.step")
    parser.add_argument("--inputs", type=int, default=1000, help="that read")
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--seed", default="0")
    arguments = parser.parse_args()
    paths = arguments.files or [FIXTURES / name / f"{name}.step" for name in ("tee", "lap", "saddle")]
    found, faults = run(paths, inputs=arguments.inputs, seconds=arguments.seconds, seed=arguments.seed)
    for outcome, count in found.most_common():
        print(f"{count:6} {outcome}")
    for fault, data in faults.items():
        print(f"{fault}: kept as {keep('chain', data)}")
    return 1 if faults else 0


def run(paths: Sequence[Path], *, inputs: int, seconds: float, seed: str) -> tuple[Counter[str], dict[str, bytes]]:
    """Return how many files ended how, and the smallest file with each fault."""
    rng, found, faults = random.Random(seed), Counter[str](), dict[str, bytes]()
    seeds = [path.read_bytes() for path in paths]
    end = time.monotonic() + seconds
    with tempfile.TemporaryDirectory(dir="/dev/shm" if Path("/dev/shm").is_dir() else None) as folder:
        work = Path(folder)
        for data in seeds:  # what is imported late is then there in every copy of this process
            (work / "part.step").write_bytes(data)
            chain_on(work / "part.step", work / "first", lambda _: None)
        while found[READ] < inputs and time.monotonic() < end:
            data = mutated_step(rng.choice(seeds), rng)
            outcomes = in_child(data, work)
            found.update(outcomes)
            fault = next((one for one in outcomes if one.startswith("FAULT")), "")
            if fault and (fault not in faults or len(data) < len(faults[fault])):
                faults[fault] = data
    return found, faults


def in_child(data: bytes, work: Path) -> list[str]:
    """Run the chain on one file in a copy of this process, and return what it did."""
    path, told = work / "part.step", work / "told.txt"
    path.write_bytes(data)
    told.write_bytes(b"")
    child = os.fork()
    if child == 0:
        try:
            with told.open("a", encoding="utf-8") as file:
                _limited_chain(path, work / "out", file)
        except BaseException:  # it must not go on as another pytest
            traceback.print_exc()
            os._exit(1)
        os._exit(0)
    _, status = os.waitpid(child, 0)
    lines = told.read_text(encoding="utf-8", errors="replace").splitlines()
    outcomes = [line.removeprefix(TOLD) for line in lines if line.startswith(TOLD)]
    if os.WIFSIGNALED(status) or os.waitstatus_to_exitcode(status):
        name = signal.Signals(os.WTERMSIG(status)).name if os.WIFSIGNALED(status) else "an exit"
        steps = [found for line in lines if (found := re.search(r'/(\w+\.py)", line \d+ in (\w+)', line))]
        place = " < ".join(f"{step[1]}:{step[2]}" for step in steps[:3])
        if READ not in outcomes:
            outcomes = [NOT_READ, f"{CRASH} or takes too long while it reads ({name})"]
        elif name in ("SIGXCPU", "SIGKILL"):
            outcomes.append(f"FAULT more than {MOST_SECONDS:g} s in {place}")
        else:
            outcomes.append(f"{CRASH} after the reading ({name} in {place})")
    return outcomes


def _limited_chain(path: Path, out: Path, told: IO[str]) -> None:
    def tell(outcome: str) -> None:
        told.write(f"{TOLD}{outcome}\n")
        told.flush()
        if outcome == READ:
            used = resource.getrusage(resource.RUSAGE_SELF)
            _limit_time(used.ru_utime + used.ru_stime + MOST_SECONDS)

    warnings.simplefilter("error")
    faulthandler.enable(told)
    faulthandler.register(signal.SIGXCPU, told, all_threads=False, chain=True)
    if (size := Path("/proc/self/statm")).exists():  # a worker of pytest that forked may be large
        own = int(size.read_text(encoding="ascii").split()[0]) * resource.getpagesize()
        resource.setrlimit(resource.RLIMIT_AS, (own + MOST_MEMORY_BYTES,) * 2)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    _limit_time(MOST_SECONDS)
    try:
        chain_on(path, out, tell)
    except KernelError as error:
        tell(f"the kernel fails in order: {' '.join(str(error).split('part.step')[-1].split()[:8])}")
    except WpcalError as error:
        tell(f"refused: {type(error).__name__}")
    except BaseException as error:  # what this searches for
        tell(f"FAULT {_place(error)}")


def _limit_time(seconds: float) -> None:
    _, most = resource.getrlimit(resource.RLIMIT_CPU)
    resource.setrlimit(resource.RLIMIT_CPU, (math.ceil(seconds), most))


def _place(error: BaseException) -> str:
    steps = [s for s in traceback.extract_tb(error.__traceback__) if "/wpcal/" in s.filename or "/cad/" in s.filename]
    places = [f"{Path(step.filename).name}:{step.name}:{step.lineno}" for step in steps[-1:-4:-1]]
    return f"{type(error).__name__} {' '.join(str(error).split())[:80]} in {' < '.join(places)}"


def chain_on(path: Path, out: Path, tell: Any) -> None:
    """Do with a file what the commands do, and check what comes out.

    `out`: For the results.
    `tell`: Gets one line per stage that is passed.
    """
    try:
        read_step(path)
    except (InputError, KernelError):
        tell(NOT_READ)
        return
    tell(READ)
    workpiece = open_workpiece(path)
    judged = judge_workpiece(workpiece)
    assert np.isfinite([item.feature.p_mm for item in judged]).all(), "a feature is nowhere"
    taught = taught_on(workpiece)
    if taught is None:
        seams, _ = find_seams(workpiece, SeamOptions())
        assert all(np.isfinite(seam.frames.p).all() for seam in seams), "a frame is nowhere"
        tell("seams are found; it has too few points to touch")
        return
    calibrate_files(workpiece, taught, out, overwrite=True)
    for name in ("calibration.json", "seams.json"):
        json.loads((out / name).read_text(encoding="utf-8"), parse_constant=_no_constant)
    assert "nan" not in (out / "seams.csv").read_text(encoding="utf-8").lower().split("\n", 1)[1], "seams.csv holds NaN"
    faults = [fault for file in audit_path(out).files for fault in file.faults]
    assert not faults, f"the audit of the results: {faults[0].message} {faults[0].field}"
    tell("it is calibrated")


def _no_constant(word: str) -> None:
    raise AssertionError(f"a result holds {word}")


def taught_on(workpiece: Workpiece) -> TaughtPoints | None:
    """Return touches of points of the part as it reads, moved; None if there are too few."""
    features = [feature for feature in workpiece.features if feature.kind.is_point]
    features = features[:: max(1, len(features) // MOST_POINTS)][:MOST_POINTS]
    if len(features) < FEWEST_POINTS:
        return None
    names = tuple(feature.name for feature in features)
    p_part = np.array([feature.p_mm for feature in features])
    n = len(names)
    return TaughtPoints(names, MOVED.apply(p_part), names, np.full((n, 3), np.nan), ("yes",) * n, "", tuple(range(n)))


if __name__ == "__main__":
    sys.exit(main())
