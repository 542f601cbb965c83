"""The page of a large part: triangles, `part.glb` and `report.html`, beside reading the part's STEP file.

The part is plates with holes, 20 faces each, and a seam of 16 frames a plate. The page is asked for in 1 s and 2 MB at
10 000 faces, after tessellation.
"""

from __future__ import annotations

import copy
import json
import tempfile
import time
from pathlib import Path
from typing import Any

from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer
from rich.table import Table

from cad import kernel
from cad.read_step import read_step
from cad.samples import box, cut, cylinder
from cad.tessellate import tessellate
from tests.benchmarks.timing import least_seconds
from wpcal.report import build_report
from wpcal.viewer import write_part_glb

GOLDEN = Path(__file__).resolve().parents[2] / "fixtures" / "tee" / "golden"
PLATES = (50, 500, 1500)
"""1000, 10 000 and 30 000 faces."""
HOLES = 14
REPEATS = 3
SIDE_MM, PITCH_MM, ROW = 150.0, 180.0, 25
WEB = 1
"""Which seam of the tee is repeated: 16 frames."""


def plates(count: int) -> list[Any]:
    """Plates side by side, each drilled in two rows."""
    drilled = []
    for i in range(count):
        x, y = i % ROW * PITCH_MM, i // ROW * PITCH_MM
        tools = [
            cylinder(5.0, 10.0, (x + 15.0 + 20.0 * (k % 7), y + 40.0 + 60.0 * (k // 7), 0.0), (0.0, 0.0, 1.0))
            for k in range(HOLES)
        ]
        drilled.append(cut(box(SIDE_MM, SIDE_MM, 10.0, (x, y, 0.0)), kernel.compound(tools)))
    return drilled


def records(count: int) -> tuple[dict[str, Any], dict[str, Any]]:
    """The calibration of the tee with as many seams as there are plates."""
    calibration = json.loads((GOLDEN / "calibration.json").read_text(encoding="utf-8"))
    seams = json.loads((GOLDEN / "seams.json").read_text(encoding="utf-8"))
    seam = seams["seams"][WEB]
    seams["seams"] = [copy.deepcopy(seam) for _ in range(count)]
    for i, one in enumerate(seams["seams"]):
        one["name"] = f"W{i + 1}"
        for k, frame in enumerate(one["frames"]):  # numbers that do not repeat, or they would compress too well
            frame["p_mm"] = [v + 0.731 * i + 0.013 * k * (axis + 1) for axis, v in enumerate(frame["p_mm"])]
            frame["u95_mm"] += 1.37e-5 * i
    return calibration, seams


def read_seconds(shapes: list[Any]) -> float:
    """Time of reading the part from STEP."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "plates.step"
        writer = STEPControl_Writer()
        writer.Transfer(kernel.compound(shapes), STEPControl_StepModelType.STEPControl_AsIs)
        writer.Write(str(path))
        start = time.perf_counter()
        read_step(path)
        return time.perf_counter() - start


def main() -> Table:
    """Measure and return the table."""
    table = Table(title="report.html of plates with holes (asked at 10 000 faces: 1 s, 2 MB)")
    for heading in ("faces", "triangles", "read s", "tessellate s", "part.glb s", "page s", "page MB", "page / read"):
        table.add_column(heading, justify="right")
    for count in PLATES:
        shapes = plates(count)
        read = read_seconds(shapes)
        start = time.perf_counter()
        mesh = tessellate((f"plate {i}", shape, None) for i, shape in enumerate(shapes))
        meshing = time.perf_counter() - start
        glb = write_part_glb(mesh)
        writing = least_seconds(lambda mesh=mesh: write_part_glb(mesh), REPEATS)
        calibration, seams = records(count)
        page = build_report(calibration, seams, glb)
        paging = least_seconds(lambda c=calibration, s=seams, g=glb: build_report(c, s, g), REPEATS)
        numbers = (f"{read:.2f}", f"{meshing:.2f}", f"{writing:.2f}", f"{paging:.2f}", f"{len(page) / 1e6:.2f}")
        table.add_row(str(count * (6 + HOLES)), str(mesh.triangle_count), *numbers, f"{paging / read:.2f}")
    return table
