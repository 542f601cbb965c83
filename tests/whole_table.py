"""Complete programs of parts with arms, judged by other kinematics and real meshes."""

import csv
import json
from pathlib import Path
from typing import NamedTuple

import numpy as np

from tests.cluttered_cells import FIXTURES, TOOL, urdf
from tests.running import run_here
from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.core.arrays import FloatArray

STEP = Path(__file__).parents[2] / "shared" / "step"  #: STEP files of assemblies, beside the checkout.
ARMS = {"irb1600_6_12": "rapid", "ma2010": "inform", "kr5_arc": "krl", "m10ia": "fanuc"}
"""Arms with the language of their maker."""
ASSEMBLIES = {
    "box_sides": ("box_sides.STEP", (850.0, -100.0, 250.0), "box_base"),
    "tail_section": ("tail_section_asm.stp", (600.0, -440.0, 420.0), None),
}
"""File, place of the part in the base of the robot (mm), and the solid that is touched (None: any)."""
COUPLED = {"m10ia": (("joint_3", "joint_2"),)}
"""Joints whose shown angles do not hold the motion of another one: the URDF files have the true angles."""
TAUGHT = 4  #: Corners that are touched.


class Row(NamedTuple):
    """What came of one part with one arm; lengths in mm."""

    part: str
    arm: str
    welded_mm: float
    accepted_mm: float
    untold: tuple[str, ...]
    no_program: tuple[str, ...]
    faults: tuple[str, ...]


def result_of(part: str, folder: Path) -> Path:
    """Return the folder of a calibration: of the fixtures, or of an assembly that is touched where it should be."""
    if part not in ASSEMBLIES:
        return FIXTURES / part / "golden"
    out = folder / part
    if not out.is_dir():
        name, place, solid = ASSEMBLIES[part]
        taught = folder / f"{part}.csv"
        found = json.loads(run_here("features", STEP / name, "--json").stdout)["features"]
        corners = [row for row in found if row["kind"] == "vertex" and solid in (None, row["solid"])]
        points = np.array([row["p_mm"] for row in corners])
        chosen = [int(np.argmin(points.sum(axis=1)))]
        while len(chosen) < TAUGHT:  # each as far from the others as possible
            apart = np.linalg.norm(points[:, None] - points[chosen], axis=2).min(axis=1)
            chosen.append(int(np.argmax(apart)))
        with taught.open("w", encoding="utf-8", newline="") as file:
            rows = csv.writer(file)
            rows.writerow(["name", "x_mm", "y_mm", "z_mm"])
            rows.writerows([corners[k]["name"], *(points[k] + place).round(4).tolist()] for k in chosen)
        done = run_here("calibrate", STEP / name, taught, "-o", out)
        assert done.returncode in (0, 1), done.stderr
    return out


def triangles_of(result: Path) -> FloatArray:
    """Return the triangles of the part of a calibration in its own frame, shape (m, 3, 3), mm."""
    return TriangleMaterial.of(read_part_glb((result / "part.glb").read_bytes(), path="part.glb")).corners


def texts_of(folder: Path) -> dict[str, str]:
    """Return the files of a program with plain ends of lines."""
    return {path.name: path.read_text(encoding="utf-8") for path in sorted(folder.iterdir())}


def judged(part: str, arm: str, folder: Path, results: Path) -> Row:
    """Make the cell and plan as a user does, and judge what was written."""
    from tests.plan_faults import chord, plan_faults  # needs FCL and trimesh, as what follows
    from tests.plan_text import READERS, text_faults, way_of
    from tests.real_cells import RealCell, of_record

    cell, out, result = folder / "cell.json", folder / "plan", result_of(part, results)
    tool = ",".join(map(str, TOOL))
    coupled = [text for pair in COUPLED.get(arm, ()) for text in ("--coupled", ":".join(pair))]
    assert run_here("cell", "new", "--torch-robot", urdf(arm), "--tool", tool, *coupled, "-o", cell).returncode == 0
    done = run_here("plan", cell, result, "-o", out, "-f", ARMS.get(arm, "rapid"))
    assert done.returncode in (0, 1), done.stderr
    plan = json.loads((out / "plan.json").read_text(encoding="utf-8"))
    seams = json.loads((result / "seams.json").read_text(encoding="utf-8"))["seams"]
    faults = plan_faults(
        out, cell, {"robot": urdf(arm)}, result / "seams.json", triangles_of(result), COUPLED.get(arm, ())
    )
    language = ARMS.get(arm, "")
    if language in READERS and language not in plan["no_program"]:
        real = RealCell(cell, {"robot": urdf(arm)}, None, of_record(plan["T_carrier_part"]))
        bent = [chord(np.array([frame["p_mm"] for frame in seam["frames"]])) for seam in seams if seam["accepted"]]
        way = way_of(plan, real)
        faults += text_faults(language, texts_of(out / language), way, chord_mm=max(bent, default=0.0))
    welded = sum(abs(piece["to_mm"] - piece["from_mm"]) for piece in plan["seams"])
    accepted = sum(seam["length_mm"] for seam in seams if seam["accepted"])
    untold = tuple(f"{gap['seam']}: no reason" for gap in plan["unwelded"] if not gap["why"])
    return Row(part, arm, welded, accepted, untold, tuple(plan["no_program"].values()), tuple(faults))
