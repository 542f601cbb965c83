"""Laws of frames along a seam: they turn no faster than asked, they do not flip, opposed faces leave a free side."""

from typing import Any

import numpy as np
import pytest

from tests.few import few
from tests.saved_graphs import saved_graph
from wpcal.brep import BrepGraph
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray
from wpcal.core.rotations import rotation_from_zyx
from wpcal.seam import JointType, SeamOptions, SeamSource, StepOptions, WeldType, detect_seams
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.path.build import build_seams
from wpcal.seam.path.turning import face_free_space, rotation_angles
from wpcal.seam.seam import SeamPieces

ROUND_OFF_RAD = 1e-9  #: Of the arcsine of a chord of two rotation matrices.
LENGTH_MM = 1e-9  #: Lengths are integrals over the same pieces, cut finer.


@pytest.mark.parametrize("turn_deg", few([5.0, 1.0, 20.0], 1))
@pytest.mark.parametrize("name", ["saddle", "small-rod", "tee"])
def test_frames_turn_no_faster_than_asked(name: str, turn_deg: float) -> None:
    loose = detect_seams(saved_graph(name), SeamOptions(steps=StepOptions(turn_rad=np.pi)))
    limited = detect_seams(saved_graph(name), SeamOptions(steps=StepOptions(turn_rad=np.radians(turn_deg))))
    for wide, seam in zip(loose, limited, strict=True):
        R = seam.frames.R
        assert np.degrees(rotation_angles(R[:-1], R[1:])).max() <= turn_deg + ROUND_OFF_RAD
        assert (np.einsum("ni,ni->n", R[1:, :, 2], R[:-1, :, 2]) > 0).all()
        # the points there were before stay, and the arc length counts on
        rows = [int(np.argmin(np.abs(seam.frames.s_mm - s))) for s in wide.frames.s_mm]
        np.testing.assert_allclose(seam.frames.s_mm[rows], wide.frames.s_mm, rtol=0, atol=LENGTH_MM)
        np.testing.assert_allclose(seam.frames.p[rows], wide.frames.p, rtol=0, atol=LENGTH_MM)
        steps = np.linalg.norm(np.diff(seam.frames.p, axis=0), axis=1)
        assert (steps <= np.diff(seam.frames.s_mm) + LENGTH_MM).all()


def test_a_small_rod_gets_the_points_that_its_turn_asks_for() -> None:
    (seam,) = detect_seams(saved_graph("small-rod"), SeamOptions(steps=StepOptions(1.0, 0.0, 100.0, np.radians(10.0))))
    assert len(seam.frames) - 1 >= 36
    assert len(seam.frames) - 1 <= 72  # halving oversteps by a factor of two at most


def test_the_angle_of_a_rotation_is_exact_for_small_ones() -> None:
    angles = np.array([0.0, 1e-12, 1e-6, 0.1, 3.0])
    R = rotation_from_zyx(angles, 0.0, 0.0)
    found = rotation_angles(np.broadcast_to(np.eye(3), R.shape), R)
    np.testing.assert_allclose(found, angles, rtol=1e-9, atol=1e-15)


def faces_with_normal(graph: BrepGraph, solid: int, normal: FloatArray) -> int:
    faces = np.flatnonzero(graph.face_solid == solid)
    n = project_to_faces(graph, faces, np.zeros((len(faces), 3))).normal
    return int(faces[np.argmax(n @ normal)])


def crack(upside_down: bool) -> tuple[BrepGraph, TrimmedFaces, Any]:
    """Two plates end to end; a seam along the edge of their faces that meet, on top or below."""
    graph = saved_graph("crack")
    wall, base = (faces_with_normal(graph, s, np.array([x, 0.0, 0.0])) for s, x in ((0, 1.0), (1, -1.0)))
    z = 0.0 if upside_down else 8.0
    p = graph.vertex_p[graph.edge_vertices]
    of_left = np.flatnonzero((graph.edge_solid == 0) & (np.abs(p[:, :, 0]).max(axis=1) < 1e-9))
    (edge,) = [e for e in of_left if np.allclose(p[e, :, 2], z, rtol=0, atol=1e-9)]
    pieces = SeamPieces(
        np.array([edge]), *graph.edge_range[[edge]].T, np.array([wall]), np.array([base]), np.zeros((1, 3))
    )
    joined = JoinedPieces(pieces, (JointType.BUTT,), (WeldType.GROOVE,))
    (seam,) = build_seams(graph, joined, SeamOptions(), SeamSource.CONTACT)
    return graph, TrimmedFaces.of(graph), seam


@pytest.mark.parametrize("upside_down", [False, True])
def test_opposed_faces_leave_the_free_side(upside_down: bool) -> None:
    graph, trimmed, seam = crack(upside_down)
    assert seam.frames.angle_rad.min() == pytest.approx(np.pi, rel=0, abs=1e-7)  # the arc cosine ends flat
    turned = face_free_space(graph, trimmed, seam)
    wanted = np.array([0.0, 0.0, -1.0 if upside_down else 1.0])
    np.testing.assert_allclose(turned.frames.R[:, :, 2], np.broadcast_to(wanted, (len(turned.frames), 3)), atol=1e-12)
    R = turned.frames.R
    np.testing.assert_allclose(np.linalg.det(R), 1.0, rtol=0, atol=1e-12)
    np.testing.assert_array_equal(R[:, :, 0], seam.frames.R[:, :, 0])
    assert turned.reasons[-1].startswith(f"the faces are opposed at {len(R)} of {len(R)} points")


def test_a_seam_with_a_bisector_is_left_alone() -> None:
    graph = saved_graph("saddle")
    trimmed = TrimmedFaces.of(graph)
    seams = detect_seams(graph)
    assert all(face_free_space(graph, trimmed, seam) is seam for seam in seams)
