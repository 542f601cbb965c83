"""Seams and calibration of assemblies against the kernel's raw reader on the same file, in the same run.

An assembly is a number of frames of square tubes with rounded corners, rails on posts. Every frame has 288 faces and
264 candidates, 84 of which are welded. Each command runs in a process of its own without the cache; times are processor
times of the process and its children, peak memory is that of the largest process.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

from rich.table import Table

from cad.kernel.primitives import square_tube
from cad.samples.parts import STEEL
from tests.benchmarks.bench_calibrate_part import write_taught
from tests.benchmarks.bench_extraction import read_raw, seconds

FRAMES = (10, 60, 120)  #: 2880, 17 280 and 34 560 faces.
PITCH = 800.0, 700.0  #: From frame to frame, mm: 50 mm are free between two, so a torch at one feels its neighbours.
SIDE, WALL, RADIUS = 50.0, 3.0, 6.0  #: Of the tubes, mm.
X, Y, HEIGHT = 700.0, 600.0, 525.0  #: Between the posts, and their height, mm.
TO_REACH, MOST_MB = 3.0, 1000


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


def main() -> Table:
    table = Table(title="Commands on assemblies, over the raw reader's time on the same file")
    asked = f"asked ≤ {TO_REACH:g}"
    for heading in ("faces", "raw s", f"seams, {asked}", "seams MB", f"calibrate, {asked}", f"MB, asked ≤ {MOST_MB}"):
        table.add_column(heading, justify="right")
    for count in FRAMES:
        table.add_row(*measured(count))
    return table


def measured(count: int) -> list[str]:
    """Write an assembly and measure the commands on it."""
    from cad.step.new_file import new_step_text
    from cad.workpiece.workpiece import open_workpiece

    with tempfile.TemporaryDirectory() as folder:
        part, taught = Path(folder) / "frames.step", Path(folder) / "taught.csv"
        part.write_bytes(new_step_text(list(frames(count)), "frames", pcurves=False))
        workpiece = open_workpiece(part)
        write_taught(tuple(f for f in workpiece.features if f.kind.is_point), taught)
        raw = min(seconds(lambda: read_raw(part))[0] for _ in range(2))
        seams_s, seams_mb = command("seams", part, "--json")
        all_s, all_mb = command("calibrate", part, taught, "-o", Path(folder) / "out", "--accept-unsure")
        cells = (raw, seams_s / raw, seams_mb, all_s / raw, all_mb)
        return [f"{workpiece.graph.face_count}", *(f"{cell:.0f}" if cell > 100 else f"{cell:.2f}" for cell in cells)]


def command(*arguments: object) -> tuple[float, float]:
    """Run a command without the cache; return its processor time, s, and the peak memory of its largest process, MB."""
    run = [sys.executable, "-m", "wpcal", *map(str, arguments)]
    quiet = {"stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}
    process = subprocess.Popen(run, env={**os.environ, "WPCAL_CACHE": "off"}, **quiet)
    _, status, usage = os.wait4(process.pid, 0)
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode not in (0, 1):
        raise RuntimeError(f"{arguments[0]} ended with {process.returncode}")
    return usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024
