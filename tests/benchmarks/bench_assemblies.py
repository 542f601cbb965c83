"""Seams and calibration of assemblies over a raw read of the same file: `python -m tests.benchmarks assemblies`.

An assembly is a number of frames of square tubes with rounded corners, rails on posts. Every frame has 288 faces and
264 candidates, 84 of which are welded; no two of the 300 bodies of the stands are alike. The raw read (`raw_read.py`)
and each command are processes of their own, without the cache, and take turns; the least of the rounds counts. Times
are of a process and its children, memory of the largest one. The ratio asked for is that of processor times.
"""

import argparse
import tempfile
from collections.abc import Iterator, Sequence
from functools import reduce
from pathlib import Path

from rich.table import Table

from cad.kernel.primitives import box, square_tube
from cad.samples.parts import STEEL
from cad.step.new_file import new_step_text
from cad.workpiece.workpiece import open_workpiece
from tests.benchmarks.bench_calibrate_part import write_taught
from tests.benchmarks.timing import ProcessUse, run_python

FRAMES = (10, 60, 120)  #: 2880, 17 280 and 34 560 faces.
STANDS = 150  #: 300 bodies.
PITCH = 800.0, 700.0  #: From frame to frame, mm: 50 mm are free between two, so a torch at one feels its neighbours.
SIDE, WALL, RADIUS = 50.0, 3.0, 6.0  #: Of the tubes, mm.
X, Y, HEIGHT = 700.0, 600.0, 525.0  #: Between the posts, and their height, mm.
ASKED = {"seams": ("≤ 3", "≤ 800"), "calibrate": ("≤ 4", "≤ 1000")}  #: Ratio and memory; of stands at most 5.
RAW_READ = Path(__file__).parent / "raw_read.py"
NO_CACHE = {"WPCAL_CACHE": "off"}


def frames(count: int) -> Iterator[tuple[str, object, object]]:
    """Yield the members of frames that stand side by side, twelve in a row."""
    for i in range(count):
        yield from _frame(i, (i % 12) * PITCH[0], (i // 12) * PITCH[1])


def _frame(i: int, ox: float, oy: float) -> Iterator[tuple[str, object, object]]:
    def tube(length: float, corner: tuple[float, float, float], axis: str) -> object:
        return square_tube(SIDE, length, corner, axis, wall=WALL, corner_radius=RADIUS)

    corners = [(a, b, x, y) for a, x in (("l", 0.0), ("r", X)) for b, y in (("f", 0.0), ("b", Y))]
    for a, b, x, y in corners:
        yield f"post {i}{a}{b}", tube(HEIGHT, (ox + x, oy + y, 0.0), "z"), STEEL
    for k, z in enumerate((50.0, 225.0, 400.0)):
        for b, y in (("f", 0.0), ("b", Y)):
            yield f"railx {i}{b}{k}", tube(X - SIDE, (ox + SIDE, oy + y, z), "x"), STEEL
        for a, x in (("l", 0.0), ("r", X)):
            yield f"raily {i}{a}{k}", tube(Y - SIDE, (ox + x, oy + SIDE, z), "y"), STEEL


def stands(count: int) -> Iterator[tuple[str, object, object]]:
    """Yield plates with a tube on each; no two have one size."""
    for i in range(count):
        x, y, thick = (i % 12) * 300.0, (i // 12) * 300.0, 6.0 + 0.02 * i
        tube = square_tube(40.0, 150.0 + 1.3 * i, (x + 20.0, y + 20.0, thick), "z", wall=3.0, corner_radius=5.0)
        yield f"plate {i}", box(90.0 + 0.7 * i, 100.0 + 0.5 * i, thick, (x, y, 0.0)), STEEL
        yield f"tube {i}", tube, STEEL


def main(arguments: Sequence[str] = ()) -> Table:
    asked = parser().parse_args(arguments)
    table = Table(title=f"Commands on assemblies, over the kernel's raw read with its import; best of {asked.best}")
    for heading in ("faces", "command", "CPU s", "ratio", "asked", "wall s", "ratio", "MB", "asked"):
        table.add_column(heading, justify="left" if heading == "command" else "right")
    with tempfile.TemporaryDirectory() as folder:
        parts = asked.part or [written(frames(count), Path(folder)) for count in asked.frames or FRAMES]
        parts += [] if asked.part or asked.frames else [written(stands(STANDS), Path(folder))]
        for part in parts:
            for row in rows(part, Path(folder), asked.best):
                table.add_row(*row)
    return table


def parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m tests.benchmarks assemblies", description=__doc__.splitlines()[0])
    parser.add_argument("--frames", type=int, action="append", help="how many frames; default 10, 60 and 120")
    parser.add_argument("--part", type=Path, action="append", help="a STEP file, instead of frames")
    parser.add_argument("--best", type=int, default=3, metavar="N", help="the least of N runs counts; default 3")
    return parser


def written(members: Iterator[tuple[str, object, object]], folder: Path) -> Path:
    """Write an assembly."""
    part = folder / f"{len(list(folder.glob('*.step')))}.step"
    part.write_bytes(new_step_text(list(members), "assembly", pcurves=False))
    return part


def rows(part: Path, folder: Path, best: int) -> Iterator[list[str]]:
    """Measure the raw read and the commands on a part, one after the other in each round; yield their rows."""
    taught, out = folder / "taught.csv", folder / "out"
    workpiece = open_workpiece(part)
    write_taught(tuple(f for f in workpiece.features if f.kind.is_point), taught)
    lines = {
        "raw read": (RAW_READ, part),
        "seams": ("-m", "wpcal", "seams", part, "--json"),
        "calibrate": ("-m", "wpcal", "calibrate", part, taught, "-o", out, "--accept-unsure", "--force"),
    }
    rounds = [[run_python(*line, ends=(0, 1), environment=NO_CACHE) for line in lines.values()] for _ in range(best)]
    raw, *_ = uses = [reduce(ProcessUse.least, runs) for runs in zip(*rounds, strict=True)]
    for name, use in zip(lines, uses, strict=True):
        ratio, most_mb = ASKED.get(name, ("", ""))
        processor = f"{use.processor_s:.2f}", f"{use.processor_s / raw.processor_s:.2f}"
        wall = f"{use.wall_s:.2f}", f"{use.wall_s / raw.wall_s:.2f}"
        yield [f"{workpiece.graph.face_count}", name, *processor, ratio, *wall, f"{use.peak_mb:.0f}", most_mb]
