"""Planes and balls settle what FCL measures: never clear where it is not, never met where it is clear."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from wpcal.planning.cell.distance_field import DistanceField, HullCover
from wpcal.planning.cell.hulls import convex_hull_object
from wpcal.planning.cell.shape import Shape

fcl = pytest.importorskip("fcl", reason="python-fcl is not installed")
NEEDED_MM = 5.0


def test_what_is_settled_is_what_fcl_measures():
    rng = np.random.default_rng(0)
    corners = rng.uniform(-1, 1, (40, 3)) * [150, 80, 40]
    part = rng.uniform(-1, 1, (30, 1, 3)) * [250, 250, 60] + rng.uniform(-30, 30, (30, 3, 3))
    hull = convex_hull_object(Shape("hull", [[0, 0, 0]], [[0, 0, 0]], [200.0], hull=corners))
    mesh = fcl.BVHModel()
    mesh.beginModel(90, 30)
    mesh.addSubModel(np.ascontiguousarray(part.reshape(-1, 3)), np.arange(90).reshape(-1, 3))
    mesh.endModel()
    body = fcl.CollisionObject(mesh, fcl.Transform())
    T = np.tile(np.eye(4), (300, 1, 1))
    T[:, :3, :3] = Rotation.random(300, random_state=1).as_matrix()
    T[:, :3, 3] = rng.uniform(-1, 1, (300, 3)) * [350, 350, 250]
    cover = HullCover.of_hull(corners)
    margin, meets = cover.settled(DistanceField.of_triangles(part), T, NEEDED_MM)
    beyond = cover.beyond_a_face(part.reshape(-1, 3), T)
    distance = []
    for place in T:
        hull.setTransform(fcl.Transform(place[:3, :3], place[:3, 3]))
        distance.append(max(fcl.distance(hull, body, fcl.DistanceRequest(), fcl.DistanceResult()), 0.0))
    exact = np.array(distance)
    assert (margin <= exact - NEEDED_MM + 1e-3)[~meets].all()
    assert (beyond <= exact + 1e-3).all()
    assert (exact[meets] == 0.0).all()
    assert meets.sum() > 20
    assert (margin > 0.0).sum() > 20
