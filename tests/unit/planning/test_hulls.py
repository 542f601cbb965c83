"""Distances of hulls: against a nonnegative least squares of the corners, all pairs one by one, capsules, and FCL."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.saddle import changed
from wpcal.core.errors import GeometryError
from wpcal.core.same_bits import poses
from wpcal.planning.cell.bodies import body_pairs
from wpcal.planning.cell.cell import TOOL
from wpcal.planning.cell.cell_clearance import beyond_a_face
from wpcal.planning.cell.clearance import capsule_clearance, pair_margins
from wpcal.planning.cell.hulls import FCL_MM, HullMeasure, fcl_objects, hull_clearance, some_planes
from wpcal.planning.cell.shape import Shape
from wpcal.robot.kinematics.urdf_bodies import capsule_around

fcl = pytest.importorskip("fcl", reason="python-fcl is not installed")
HULL_MM = 2 * FCL_MM  #: FCL's distance is reported this much too small at most: the allowance and its own error.
ROUND_OFF_MM = 1e-9


def random_state(n, seed=0):
    rng = np.random.default_rng(seed)
    return np.concatenate([rng.uniform(-1.5, 1.5, (n, 6)), rng.uniform(-1.5, 1.5, (n, 6))], axis=1)


def rounded_off(shape, rng, n=40):
    """A shape with a hull of n random points inside its capsules; few points fill little of them."""
    k = rng.integers(0, len(shape.p), n)
    s, aside = rng.uniform(0, 1, (n, 1)), rng.normal(size=(n, 3))
    aside /= np.linalg.norm(aside, axis=1, keepdims=True)
    points = shape.p[k] + s * (shape.q - shape.p)[k] + 0.99 * shape.radius_mm[k, None] * aside
    return replace(shape, hull=points)


def with_hulls(cell, corners):
    rng = np.random.default_rng(5)

    def off(shapes):
        return tuple(rounded_off(s, rng, corners) for s in shapes)

    links = off(cell.links)
    carried = off(cell.carrier.links)
    more = {name: off(getattr(cell, name)) for name in ("torch", "part", "bench")}
    return changed(cell, links=links, links2=carried, **more)


@pytest.fixture(scope="module")
def hulled(cell):
    return with_hulls(cell, 40)


def test_of_a_state_that_collides_one_pair_is_named_and_by_its_own_distance(hulled):
    frames = hulled.frames(random_state(300))
    measure = HullMeasure.of_pairs(body_pairs(hulled))
    bounds = pair_margins(measure.bounded, frames)
    measure.raise_bounds(bounds, frames)
    margin, _ = measure.least_margins(frames)
    np.testing.assert_array_equal((bounds <= 0.0).sum(axis=0), margin <= 0.0)
    assert 20 < np.sum(margin <= 0.0) < 280


def test_bodies_without_hulls_are_measured_by_their_capsules(cell):
    bare = replace(cell, bench=tuple(replace(shape, hull=()) for shape in cell.bench))
    state = random_state(100)
    by_hulls, by_capsules = hull_clearance(bare, state), capsule_clearance(bare, state)
    np.testing.assert_array_equal(by_hulls.margin_mm, by_capsules.margin_mm)
    np.testing.assert_array_equal(by_hulls.pair, by_capsules.pair)


def test_a_capsule_against_a_box(cell):
    table = Shape(
        "box", [[0, 0, 0]], [[0, 0, 0]], [1], hull=[[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)]
    )
    ball = Shape("ball", [[0, 0, 0]], [[0, 0, 0]], [10])
    bare = changed(cell, links=(), links2=(), torch=(ball,), part=(), bench=(table,))
    state = random_state(30)
    centre = bare.frames(state)[TOOL].p.T
    outside = np.linalg.norm(centre - np.clip(centre, 0, 1), axis=1) - 10
    found = hull_clearance(bare, state).distance_mm
    np.testing.assert_allclose(found, np.maximum(outside, 0), rtol=0, atol=HULL_MM)


def test_overlapping_hulls_are_not_clear(hulled):
    meeting = np.concatenate([np.zeros((1, 6)), np.zeros((1, 6))], axis=1)
    found = hull_clearance(hulled, meeting)
    assert not found.is_clear[0]
    assert found.distance_mm[0] == 0.0


@pytest.mark.parametrize("seed", range(8))
def test_the_capsule_around_points_holds_them(seed):
    rng = np.random.default_rng(seed)
    points = rng.normal(size=(30, 3)) * rng.uniform(1, 300, 3) + rng.uniform(-500, 500, 3)
    p, q, radius = capsule_around(points)
    u = q - p
    t = np.clip((points - p) @ u / max(u @ u, 1e-30), 0, 1)
    assert np.linalg.norm(points - p - t[:, None] * u, axis=1).max() <= radius + ROUND_OFF_MM


def test_round_off_does_not_turn_the_capsule_of_a_round_body():
    ring = np.exp(2j * np.pi * np.arange(7) / 7) * 20.0
    x = [(z.real, z.imag, h) for z in ring for h in (0, 80)] @ Rotation.random(random_state=0).as_matrix()
    p = [capsule_around(x + 1e-13 * np.random.default_rng(seed).normal(size=x.shape))[0] for seed in range(6)]
    assert np.ptp(p, axis=0).max() < 1e-4


def test_flat_hulls_are_refused(cell):
    flat = replace(cell.bench[0], hull=[[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0]])
    with pytest.raises(GeometryError, match="table: the corners of its hull are in one plane"):
        hull_clearance(replace(cell, bench=(flat,)), random_state(1))


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
