"""Planes settle what FCL measures: never clear where it is not."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from wpcal.core.same_bits import poses
from wpcal.planning.cell.cell_clearance import beyond_a_face
from wpcal.planning.cell.hulls import fcl_objects, some_planes
from wpcal.planning.cell.shape import Shape

fcl = pytest.importorskip("fcl", reason="python-fcl is not installed")


def test_what_is_settled_is_what_fcl_measures():
    rng = np.random.default_rng(0)
    corners = rng.uniform(-1, 1, (40, 3)) * [150, 80, 40]
    part = rng.uniform(-1, 1, (30, 1, 3)) * [250, 250, 60] + rng.uniform(-30, 30, (30, 3, 3))
    shape = Shape("hull", [[0, 0, 0]], [[0, 0, 0]], [200.0], hull=corners)
    ((hull, _, _),) = fcl_objects(shape)
    mesh = fcl.BVHModel()
    mesh.beginModel(90, 30)
    mesh.addSubModel(np.ascontiguousarray(part.reshape(-1, 3)), np.arange(90).reshape(-1, 3))
    mesh.endModel()
    body = fcl.CollisionObject(mesh, fcl.Transform())
    T = poses(Rotation.random(300, random_state=1).as_matrix(), rng.uniform(-1, 1, (300, 3)) * [350, 350, 250])
    beyond = beyond_a_face(some_planes(shape), part.reshape(-1, 3), T)
    distance = []
    for place in T:
        hull.setTransform(fcl.Transform(place[:3, :3], place[:3, 3]))
        distance.append(max(fcl.distance(hull, body, fcl.DistanceRequest(), fcl.DistanceResult()), 0.0))
    assert (beyond <= np.array(distance) + 1e-3).all()
    assert (beyond > 0.0).sum() > 20
