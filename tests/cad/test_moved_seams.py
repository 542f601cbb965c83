"""Laws of seams of bodies that moved, on plane, round and free-form faces; the kernel's own surfaces judge them."""

import tempfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from OCP.BRep import BRep_Tool
from OCP.GeomAPI import GeomAPI_ProjectPointOnSurf
from OCP.gp import gp_Pnt

from cad.kernel.topology import FACE, sub_shapes
from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import Workpiece, open_workpiece
from tests.few import few
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.tangent import exp_rotation
from wpcal.seam import Seam
from wpcal.seam.options import SeamOptions
from wpcal.seam.path.moved import MovedSeam, moved_seams

FIXTURES = Path(__file__).parents[2] / "fixtures"
PARTS = ("tee/tee.step", "saddle/saddle.step", "uprights/uprights.step", "pipe", "loft")
ROUND_OFF_MM = 1e-9
SETTLED_MM = 1e-7  #: Newton's method ends at steps of 1e-8 mm; the kernel's projection is as exact.


@dataclass(frozen=True, slots=True, eq=False)
class StiffMoves:
    """Bodies that turn by R and shift by t, shapes (b, 3, 3) and (b, 3), about the origin of `part`, mm."""

    R: FloatArray
    t: FloatArray

    def moves_at(self, body: IntArray, _p_part: FloatArray) -> tuple[FloatArray, FloatArray]:
        """As `BodyMoves.moves_at`; every face belongs to a body."""
        return self.R[body], self.t[body]


def on_a_plate(name: str, folder: Path) -> Path:
    """Write a plate with a pipe, or with a loft from an ellipse to a slimmer one, on it."""
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeEdge, BRepBuilderAPI_MakeWire
    from OCP.BRepOffsetAPI import BRepOffsetAPI_ThruSections
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeCylinder
    from OCP.gp import gp_Ax2, gp_Dir, gp_Elips
    from step_samples import add_part, box, new_document, write_document

    if name == "pipe":
        post = BRepPrimAPI_MakeCylinder(gp_Ax2(gp_Pnt(0, 0, 0), gp_Dir(0, 0, 1)), 20.0, 60.0).Shape()
    else:
        loft = BRepOffsetAPI_ThruSections(True)
        for z, major, minor in ((0.0, 40.0, 25.0), (30.0, 35.0, 15.0), (60.0, 30.0, 20.0)):
            ellipse = gp_Elips(gp_Ax2(gp_Pnt(0, 0, z), gp_Dir(0, 0, 1)), major, minor)
            loft.AddWire(BRepBuilderAPI_MakeWire(BRepBuilderAPI_MakeEdge(ellipse).Edge()).Wire())
        loft.Build()
        post = loft.Shape()
    document = new_document()
    add_part(document, box((-100.0, -80.0, -10.0), (200.0, 160.0, 10.0)), "plate")
    add_part(document, post, "post")
    return write_document(document, folder / f"{name}.step")


@cache
def seams_of(name: str) -> tuple[Workpiece, tuple[Seam, ...]]:
    with tempfile.TemporaryDirectory() as folder:
        path = FIXTURES / name if "/" in name else on_a_plate(name, Path(folder))
        seams, workpiece = find_seams(open_workpiece(path), SeamOptions())
        assert len(workpiece.solids) > 1  # read while the file is there
    return workpiece, seams


def moved(name: str, R: FloatArray, t: FloatArray) -> list[MovedSeam]:
    """Move each solid of a part by itself; R, t of shapes (b, 3, 3), (b, 3)."""
    workpiece, seams = seams_of(name)
    return moved_seams(workpiece.graph, seams, workpiece.graph.face_solid, StiffMoves(R, t))


def drawn(name: str, seed: int) -> tuple[FloatArray, FloatArray]:
    """Motions of 1 mm and 4 mrad."""
    b = len(seams_of(name)[0].graph.solid_names)
    rng = np.random.default_rng(seed)
    return exp_rotation(rng.normal(size=(b, 3)) * 0.004), rng.normal(size=(b, 3))


@pytest.mark.parametrize("name", few(PARTS, 3))
def test_bodies_that_move_alike_move_their_seams_as_one_piece(name: str) -> None:
    rng = np.random.default_rng(1)
    workpiece, seams = seams_of(name)
    b = len(workpiece.graph.solid_names)
    R, t = exp_rotation(rng.normal(size=3)), rng.normal(size=3) * 100.0
    for seam, found in zip(seams, moved(name, np.tile(R, (b, 1, 1)), np.tile(t, (b, 1))), strict=True):
        frames = found.seam.frames
        np.testing.assert_allclose(frames.p, seam.frames.p @ R.T + t, rtol=0, atol=ROUND_OFF_MM)
        np.testing.assert_allclose(frames.R, R @ seam.frames.R, rtol=0, atol=1e-9)
        np.testing.assert_allclose(frames.s_mm, seam.frames.s_mm, rtol=0, atol=1e-6)


@pytest.mark.parametrize("name", PARTS)
def test_every_point_lies_on_both_moved_surfaces(name: str) -> None:
    """The kernel projects each point, moved back with either body, on the whole surface of its face."""
    R, t = drawn(name, 2)
    workpiece, seams = seams_of(name)
    faces = [face for solid in workpiece.solids for face in sub_shapes(solid, FACE)]
    tried = 0
    for seam, found in zip(seams, moved(name, R, t), strict=True):
        if len(np.unique(seam.pieces.base)) != 1 or max(seam.gap_mm) > 1e-6:
            continue
        if len(np.unique(seam.pieces.wall)) != 1:
            continue
        for face in (int(seam.pieces.wall[0]), int(seam.pieces.base[0])):
            body = workpiece.graph.face_solid[face]
            back = (found.seam.frames.p - t[body]) @ R[body]
            surface = BRep_Tool.Surface_s(faces[face])
            off = [GeomAPI_ProjectPointOnSurf(gp_Pnt(*p), surface).LowerDistance() for p in back.tolist()]
            assert max(off) < SETTLED_MM, (seam.name, face)
            tried += 1
    assert tried


@pytest.mark.parametrize("name", PARTS)
def test_frames_stay_right_handed_and_follow_the_seam(name: str) -> None:
    R, t = drawn(name, 3)
    _, seams = seams_of(name)
    for seam, found in zip(seams, moved(name, R, t), strict=True):
        frames = found.seam.frames
        np.testing.assert_allclose(np.linalg.det(frames.R), 1.0, rtol=0, atol=1e-9)
        turned = np.einsum("nij,nij->n", frames.R, seam.frames.R)  # 3 where nothing turned
        assert (turned > 3.0 - 4.0 * 0.03**2).all()
        if np.linalg.norm(seam.frames.p[0] - seam.frames.p[-1]) < 1e-9:
            assert np.linalg.norm(frames.p[0] - frames.p[-1]) < SETTLED_MM
            np.testing.assert_allclose(frames.R[0], frames.R[-1], rtol=0, atol=1e-6)


def test_ends_follow_the_ends_of_the_plate(golden: Any) -> None:
    """A plate that slides along its seam by 1.3 mm takes the seam along."""
    name = "uprights/uprights.step"
    workpiece, seams = seams_of(name)
    b = len(workpiece.graph.solid_names)
    slide = workpiece.graph.solid_names.index("U1")
    t = np.zeros((b, 3))
    t[slide, 0] = 1.3
    found = [
        (seam, now)
        for seam, now in zip(seams, moved(name, np.tile(np.eye(3), (b, 1, 1)), t), strict=True)
        if (now.wall_body == slide).all()
    ]
    assert found
    for seam, now in found:
        np.testing.assert_allclose(
            now.seam.frames.p - seam.frames.p, [[1.3, 0.0, 0.0]] * len(seam.frames), rtol=0, atol=SETTLED_MM
        )
        assert now.seam.length_mm == pytest.approx(seam.length_mm, abs=1e-6)
    golden(found)
