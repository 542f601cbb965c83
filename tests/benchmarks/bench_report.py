"""The page of a large part: triangles, `part.glb` and `report.html`, beside reading the part's STEP file.

Two parts: plates with holes, 20 faces each (equal plates compress well), and real parts copied and turned (they do
not). Both carry 500 seams of 16 frames at 10 000 faces. The page is asked for in 1 s and 2 MB there, after
tessellation.
"""

import copy
import json
import tempfile
import time
from pathlib import Path
from typing import Any

from OCP.STEPControl import STEPControl_StepModelType, STEPControl_Writer
from rich.table import Table

from cad.kernel.geometry import to_location
from cad.kernel.tessellate import tessellate
from cad.kernel.topology import FACE, compound, sub_shapes
from cad.samples.parts import box, cut, cylinder
from cad.step.read import read_step
from tests.benchmarks.timing import least_seconds
from wpcal.brep.mesh_glb import write_part_glb
from wpcal.core.transform import RigidTransform
from wpcal.pages.report import build_report

GOLDEN = Path(__file__).resolve().parents[2] / "fixtures" / "tee" / "golden"
PLATES = (50, 500, 1500)  #: 1000, 10 000 and 30 000 faces.
HOLES = 14
REPEATS = 3
SIDE_MM, PITCH_MM, ROW = 150.0, 180.0, 25
SHARED_STEP = Path(__file__).resolve().parents[3] / "shared" / "step"
MIX = {
    "nist_ctc_02_asme1_ap242-e2.stp": 5,
    "tail_section_asm.stp": 5,
    "nist_ctc_05_asme1_ap242-e1.stp": 8,
    "as1-oc-214.stp": 10,
    "ANC101-ill.stp": 7,
}
"""Machined, freeform, an assembly: how often each is copied."""
WEB = 1  #: Which seam of the tee is repeated: 16 frames.


def plates(count: int) -> list[Any]:
    """Plates side by side, each drilled in two rows."""
    drilled = []
    for i in range(count):
        x, y = i % ROW * PITCH_MM, i // ROW * PITCH_MM
        tools = [
            cylinder(5.0, 10.0, (x + 15.0 + 20.0 * (k % 7), y + 40.0 + 60.0 * (k // 7), 0.0), (0.0, 0.0, 1.0))
            for k in range(HOLES)
        ]
        drilled.append(cut(box(SIDE_MM, SIDE_MM, 10.0, (x, y, 0.0)), compound(tools)))
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
        writer.Transfer(compound(shapes), STEPControl_StepModelType.STEPControl_AsIs)
        writer.Write(str(path))
        start = time.perf_counter()
        read_step(path)
        return time.perf_counter() - start


def real_mix() -> list[tuple[str, Any, Any]]:
    """Real parts of others, copied to 10 072 faces, every copy turned another way; none where they are not here."""
    solids: list[tuple[str, Any, Any]] = []
    names = [name for name, count in MIX.items() if (SHARED_STEP / name).exists() for _ in range(count)]
    parts = {name: read_step(SHARED_STEP / name) for name in set(names)}
    for i, name in enumerate(names):
        place = [(i % 6) * 1500.0, (i // 6) * 1500.0, 0.0, 0.1 * i, 0.2, 0.3 * i]
        location = to_location(RigidTransform.from_six_tuple(place, target="base", source="part"))
        solids += [(f"{s.name} {i}", s.shape.Moved(location), s.color_rgb) for s in parts[name].solids]
    return solids


def row(solids: list[tuple[str, Any, Any]], seams_count: int) -> list[str]:
    """Faces, triangles and times of one part."""
    faces = sum(len(sub_shapes(shape, FACE)) for _, shape, _ in solids)
    start = time.perf_counter()
    mesh = tessellate(solids)
    meshing = time.perf_counter() - start
    glb = write_part_glb(mesh)
    writing = least_seconds(lambda: write_part_glb(mesh), REPEATS)
    calibration, seams = records(seams_count)
    page = build_report(calibration, seams, glb)
    paging = least_seconds(lambda: build_report(calibration, seams, glb), REPEATS)
    numbers = (f"{meshing:.2f}", f"{writing:.2f}", f"{paging:.2f}", f"{len(page) / 1e6:.2f}")
    return [str(faces), str(sum(len(s.triangles) for s in mesh.solids)), *numbers]


def main() -> Table:
    """Measure and return the table."""
    table = Table(title="report.html (asked at 10 000 faces, after tessellation: 1 s, 2 MB)")
    for heading in ("part", "read s", "faces", "triangles", "mesh s", "glb s", "page s", "page MB"):
        table.add_column(heading, justify="right")
    for count in PLATES:
        shapes = plates(count)
        solids = [(f"plate {i}", shape, None) for i, shape in enumerate(shapes)]
        table.add_row("plates", f"{read_seconds(shapes):.2f}", *row(solids, count))
    if mix := real_mix():
        table.add_row("real mix", "-", *row(mix, PLATES[1]))
    return table
