"""Features and seams of large parts against the kernel's raw reader on the same file, in the same run.

The raw reader is the kernel's own `STEPControl_Reader`, parsing and transfer. The part is
`tests.samples.steel_structure`, whose seams are known in closed form; it is written without edges as curves in surface
parameters, as most CAD systems do. Each size runs in a process of its own, whose peak memory after the first run is
stated. Times are processor times, the least of `REPEATS` runs.
"""

import json
import math
import resource
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

BAYS = (41, 82, 164)
"""About 7 500, 15 000 and 30 000 faces: the exponent of the time over the faces is fitted through them."""
REPEATS = 2  #: The least of so many runs counts: other work on the machine only ever adds.
TO_REACH = 1.5  #: Features and seams, over the raw reader's time.
MOST_MB = 1000
ALL = ("read_step", "to_brep", "features", "seams")


def main() -> Table:
    table = Table(title="Features and seams of a structure, over the raw reader's time on the same file")
    for heading in ("faces", "MB", "raw s", *ALL, f"features and seams, asked ≤ {TO_REACH}", "all", "peak MB"):
        table.add_column(heading, justify="right")
    runs = [measured(bays) for bays in BAYS]
    for run in runs:
        raw, parts = run["raw"], [run[name] for name in ALL]
        ratios = [f"{s / raw:.2f}" for s in (*parts, sum(parts[1:]), sum(parts))]
        table.add_row(f"{run['faces']}", f"{run['file_mb']:.0f}", f"{raw:.2f}", *ratios, f"{run['peak_mb']:.0f}")
    faces = np.log([run["faces"] for run in runs])
    slopes = [np.polyfit(faces, np.log([run[name] for run in runs]), 1)[0] for name in ("raw", *ALL)]
    table.add_row("exponent", "", *(f"{slope:.2f}" for slope in slopes), "", "", f"asked ≤ {MOST_MB}")
    return table


def measured(bays: int) -> dict[str, float]:
    """Write a structure and measure its reading in a fresh process."""
    from cad.step.new_file import new_step_text
    from tests.samples.steel_structure import steel_structure

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "structure.step"
        path.write_bytes(new_step_text(steel_structure(bays), "structure", pcurves=False))
        command = [sys.executable, "-m", "tests.benchmarks.bench_extraction", str(path), str(bays)]
        run: dict[str, float] = json.loads(subprocess.run(command, check=True, stdout=subprocess.PIPE).stdout)
    return run


def measure(path: Path, bays: int) -> dict[str, float]:
    """Read, find features and seams; then read again with the raw reader."""
    from tests.samples.steel_structure import seam_counts

    rounds = [extraction(path)]
    peak_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    rounds += [extraction(path) for _ in range(REPEATS - 1)]
    raw = min(seconds(lambda: read_raw(path))[0] for _ in range(REPEATS))
    _, faces, seams = rounds[0]
    reached = [seam for seam in seams if seam.accepted]
    count, length = seam_counts(bays)
    if len(reached) != count or not math.isclose(sum(s.length_mm for s in reached), length, rel_tol=1e-9):
        raise RuntimeError(f"{len(reached)} seams of a structure that has {count}")
    least = {name: min(times[name] for times, *_ in rounds) for name in ALL}
    return {**least, "raw": raw, "faces": faces, "peak_mb": peak_mb, "file_mb": path.stat().st_size / 1e6}


def extraction(path: Path) -> tuple[dict[str, float], int, Any]:
    """Return the seconds of every step, the number of faces, and the seams."""
    from cad.workpiece.seams import find_seams
    from cad.workpiece.step_file import StepFile
    from cad.workpiece.workpiece import Workpiece
    from wpcal.seam import SeamOptions

    times = {}
    file = StepFile.open(path)
    times["read_step"], _ = seconds(lambda: file.step)
    times["to_brep"], content = seconds(lambda: file.content)
    times["features"], _ = seconds(lambda: file.features)
    graph = content.graph
    workpiece = Workpiece(graph, content.issues, file)
    times["seams"], (seams, _) = seconds(lambda: find_seams(workpiece, SeamOptions()))
    return times, graph.face_count, seams


def seconds(work: Callable[[], Any]) -> tuple[float, Any]:
    """Return the processor time of some work, and its result."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def read_raw(path: Path) -> Any:
    """Parse and transfer with the kernel's plain reader, and return it."""
    from OCP.STEPControl import STEPControl_Reader

    reader = STEPControl_Reader()
    reader.ReadFile(str(path))
    reader.TransferRoots()
    return reader


if __name__ == "__main__":
    sys.stdout.write(json.dumps(measure(Path(sys.argv[1]), int(sys.argv[2]))))
