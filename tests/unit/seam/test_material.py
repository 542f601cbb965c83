"""What is inside material: points of solids with known volumes, and poses of a torch at known places."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.saved_graphs import saved_graph
from tests.unit.conftest import box_mesh
from wpcal.brep.material import ExactMaterial, TriangleMaterial, find_solids_around
from wpcal.brep.mesh import PartMesh, SolidMesh
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray
from wpcal.core.rotations import rotation_from_zyx
from wpcal.robot.torch.shape import TorchShape
from wpcal.seam import detect_seams
from wpcal.seam.judge.material import TorchPart, find_poses_in_material

HALF_MM = np.array([40.0, 30.0, 20.0])  #: Half the sides of the saved graph ``sharp-box``, which is around the origin.
ROUND_OFF_MM = 1e-9
MISCOUNTED = 1e-3
"""Share of rays that may count wrong: those between a curved edge and its polyline, which are up to 0.01 mm apart."""
UP = np.array([[0.0, 0.0, 1.0]])
LEANING = np.array([[0.6, 0.0, 0.8]])


def exact(name: str) -> ExactMaterial:
    graph = saved_graph(name)
    return ExactMaterial(graph, TrimmedFaces.of(graph))


def box_of_triangles(name: str, half: FloatArray, R: FloatArray) -> SolidMesh:
    box = box_mesh(name, -np.asarray(half), np.asarray(half))
    return replace(box, points=box.points @ R.T)


def test_points_in_a_box_are_those_within_its_slabs() -> None:
    R, points = rotation_from_zyx(0.4, -0.7, 1.1), np.random.default_rng(3).uniform(-60, 60, (4000, 3))
    triangles = TriangleMaterial.of(PartMesh((box_of_triangles("box", HALF_MM, R),), 0.1, 0.1))
    for material, at in ((triangles, points @ R.T), (exact("sharp-box"), points)):
        found, solid = find_solids_around(material, at)
        assert set(solid.tolist()) == {0}
        np.testing.assert_array_equal(found, np.flatnonzero((np.abs(points) < HALF_MM).all(axis=1)))


def test_a_wire_in_the_plane_of_a_face_beside_it_is_free_whatever_the_round_off() -> None:
    """From the rim of a box, at the end of a seam that ends with the box: it leans over the rim."""
    for R in Rotation.random(100, rng=7).as_matrix():
        material = TriangleMaterial.of(PartMesh((box_of_triangles("box", HALF_MM, R),), 0.1, 0.1))
        tips, back = HALF_MM * [[0.0, -1.0, 1.0]] @ R.T, LEANING @ R.T
        assert material.tube_solids(tips, back, np.ones(1), np.full(1, 4.0), 1e-3).tolist() == [-1]


@pytest.mark.parametrize(("radii_mm", "reach_mm"), [((2.0, 8.0), 6.0909), ((8.0, 2.0), 8.0)])
def test_a_cone_meets_a_box_as_far_as_it_is_wide_beside_it(radii_mm: tuple[float, float], reach_mm: float) -> None:
    """From 15 mm before the edge of the box to 7 mm behind it: at the edge, 2 mm have become 2 + 6 * 15 / 22."""
    beside = np.array([0.9, 1.1]) * reach_mm
    tips = np.stack([HALF_MM[0] + beside, np.full(2, HALF_MM[1] - 20.0), np.zeros(2)], axis=1)
    along = np.tile([0.0, 1.0, 0.0], (2, 1))
    triangles = TriangleMaterial.of(PartMesh((box_of_triangles("box", HALF_MM, np.eye(3)),), 0.1, 0.1))
    for material in (exact("sharp-box"), triangles):  # an edge of the triangles is along the axis
        found = material.tube_solids(tips, along, np.full(2, 5.0), np.full(2, 27.0), radii_mm)
        assert found.tolist() == [0, -1]


@pytest.mark.parametrize(
    ("name", "volume_mm3"),
    [
        ("small-rod", math.pi * 3**2 * 30 + 60 * 60 * 10),
        ("rod-through", math.pi * 30**2 * 100 + 200 * 200 * 10 - math.pi * 30**2 * 10),
        ("saddle", None),
    ],
)
def test_the_share_of_points_inside_is_the_volume(name: str, volume_mm3: float | None) -> None:
    material = exact(name)
    low, high = material.trimmed.face_box[0].min(axis=0), material.trimmed.face_box[1].max(axis=0)
    points = np.random.default_rng(11).uniform(low, high, (20_000, 3))
    found, _ = find_solids_around(material, points)
    if volume_mm3 is not None:
        share = volume_mm3 / float(np.prod(high - low))
        sigma = math.sqrt(share * (1 - share) / len(points))
        assert abs(len(found) / len(points) - share) < 4 * sigma
    R = rotation_from_zyx(0.3, 0.2, -0.9)
    more = ExactMaterial(material.graph, material.trimmed).hits(points, np.tile(R[:, 0], (len(points), 1)), 1e9)
    turns = np.bincount(more.ray * len(material.names) + more.solid, more.way, len(points) * len(material.names))
    assert ((turns != 0) & (turns != 1)).sum() <= MISCOUNTED * len(points)


def test_each_part_of_a_torch_is_felt_where_it_is(golden: Any) -> None:
    material = exact("sharp-box")  # its top is at z = 20
    p = np.array([[0.0, 0, 10], [0, 0, -22.0], [49.9, 0, -45], [55.1, 0, -45], [0, 0, 20]])
    found = find_poses_in_material(material, p, np.repeat(UP, len(p), axis=0))
    assert found.row.tolist() == [0, 1, 2]
    assert found.part == (TorchPart.TIP, TorchPart.WIRE, TorchPart.NOZZLE)
    assert set(found.solid) == set(material.names)
    golden(found)


def test_a_nozzle_that_starts_inside_a_thick_solid_is_felt() -> None:
    walls = [box_of_triangles("thick", np.array([500.0, 500.0, 500.0]), np.eye(3))]
    material = TriangleMaterial.of(PartMesh(tuple(walls), 0.1, 0.1))
    found = find_poses_in_material(material, np.array([[508.0, 0.0, -400.0]]), UP, TorchShape(length_mm=100.0))
    assert found.part == (TorchPart.NOZZLE,)


def test_poses_at_a_free_seam_are_not_in_material() -> None:
    material = exact("tee")
    for seam in detect_seams(material.graph):
        assert seam.reachable
        assert len(find_poses_in_material(material, seam.frames.p, seam.frames.R[:, :, 2])) == 0
