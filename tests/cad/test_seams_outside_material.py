"""The kernel's own classifier finds no accepted frame inside a solid."""

from pathlib import Path

import numpy as np
import pytest
from OCP.Bnd import Bnd_Box
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_IN

from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import open_workpiece
from tests.few import few
from tests.samples.graphs import GRAPHS
from wpcal.brep.graph import BrepGraph
from wpcal.brep.surfaces import project_to_faces
from wpcal.core.arrays import FloatArray
from wpcal.seam import Seam, SeamOptions, SeamSource
from wpcal.seam.judge.leans import back_directions
from wpcal.seam.judge.stations import start_mm
from wpcal.seam.path.cut import spans_of

ON_FACE_MM = 1e-4  #: A point this near to a face is on it: the end of a stretch lies on the solid that it ends at.
MINI = ("g80", "g125", "g150", "g180", "g250", "hole3", "hole10", "lug", "pp_narrow", "pp_over", "pp_tangent")
PARTS = (
    *("house_walls.stp", "dm1-id-214.stp", "as1-oc-214.stp", "../blind/iron_Footer_Type_U_L70.step"),
    *(f"../blind/mini/{name}.step" for name in (*MINI, "t0", "t30", "t90", "cov3", "cov25")),
)
"""Small parts: each takes less than a second."""


EVERY_PART = (
    *PARTS,
    *("box_sides.STEP", "tail_section_asm.stp", "colored.step", "featuretype.STEP", "ANC101-ill.stp"),
    *("../blind/mini/em_re.step", "../blind/afpm_boom_vane.step", "../blind/wb_bench.step"),
)
BISECTS_DEG = 1.0
"""Between z and the bisector of the normals of both faces, normal to the travel: chords are coarse on small rounds."""


def accepted_points(seams: tuple[Seam, ...]) -> FloatArray:
    accepted = [seam for seam in seams if seam.accepted]
    rows = [s.frames.p + start_mm(s) * s.frames.R[:, :, 2] for s in accepted]
    rows += [
        s.frames.p + start_mm(s) * back_directions(s.frames.R, s.lean_rad) for s in accepted if s.lean_rad is not None
    ]
    return np.concatenate([np.zeros((0, 3)), *rows])


def count_inside(shapes: list[object], points: FloatArray) -> int:
    """Count points inside solids; a solid is asked only for points inside its box, so thousands take seconds."""
    inside = 0
    for shape in shapes:
        box = Bnd_Box()
        BRepBndLib.Add_s(shape, box, False)
        low, high = (np.array(corner.Coord()) for corner in (box.CornerMin(), box.CornerMax()))
        near = points[((points >= low) & (points <= high)).all(axis=1)]
        if len(near) == 0:
            continue
        classifier = BRepClass3d_SolidClassifier(shape)
        for p in near:
            classifier.Perform(gp_Pnt(*p.tolist()), ON_FACE_MM)
            inside += classifier.State() == TopAbs_IN
    return inside


@pytest.mark.parametrize(
    "name",
    few(
        ["crossed-tee", "gusseted-bracket", "boss-with-ribs", "pipe-through-plates", "closed-box", "frame", "saddle"], 1
    ),
)
def test_accepted_frames_of_own_parts(name: str) -> None:
    from tests.saved_graphs import saved_seams

    points = accepted_points(saved_seams(name))
    assert len(points)
    assert count_inside([shape for _, shape in GRAPHS[name]()], points) == 0


@pytest.mark.parametrize("name", few(PARTS, 2))
def test_accepted_frames_of_parts_made_by_others(name: str, shared_step: Path) -> None:
    workpiece = open_workpiece(shared_step / name)
    seams, workpiece = find_seams(workpiece, SeamOptions())
    assert count_inside(list(workpiece.solids), accepted_points(seams)) == 0


def bisector_errors(graph: BrepGraph, seam: Seam) -> FloatArray:
    """Angles between z and the bisector of the normals of wall and base at stations inside pieces, deg."""
    starts, ends = spans_of(graph, seam.pieces)
    errors = []
    for s, p, R in zip(seam.frames.s_mm, seam.frames.p, seam.frames.R, strict=True):
        row = int(np.searchsorted(ends, s))
        if row >= len(ends) or not starts[row] + 1.0 < s < ends[row] - 1.0:
            continue
        faces = np.array([seam.pieces.wall[row], seam.pieces.base[row]])
        n = project_to_faces(graph, faces, np.stack([p, p])).normal
        z = n.sum(axis=0) - (n.sum(axis=0) @ R[:, 0]) * R[:, 0]
        if np.linalg.norm(z) > 0.2:  # opposed normals have no bisector
            errors.append(np.degrees(np.arccos(np.clip(z @ R[:, 2] / np.linalg.norm(z), -1.0, 1.0))))
    return np.array(errors)


@pytest.mark.deep
@pytest.mark.parametrize("name", EVERY_PART)
def test_accepted_frames_of_every_part_are_outside_and_bisect(name: str, shared_step: Path) -> None:
    workpiece = open_workpiece(shared_step / name)
    seams, workpiece = find_seams(workpiece, SeamOptions())
    assert count_inside(list(workpiece.solids), accepted_points(seams)) == 0
    graph = workpiece.graph
    for seam in seams:
        if seam.accepted and seam.source in (SeamSource.CONTACT, SeamSource.CONCAVE):
            assert np.all(bisector_errors(graph, seam) <= BISECTS_DEG), seam.name
        if seam.accepted and seam.lean_rad is not None:
            assert not np.isnan(seam.lean_rad).any(), seam.name
