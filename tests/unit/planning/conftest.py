"""One plan that needs no search: robot 2 turns the branch pipe about its own axis, robot 1 follows the saddle."""

import numpy as np
import pytest
from scipy.optimize import lsq_linear

from tests.saddle import CELLS, COARSE, THINNED, saddle_problem, shared_search
from wpcal.core.records import read_json
from wpcal.core.rotations import rotation_from_zyx
from wpcal.planning.cell.bodies import body_pairs
from wpcal.planning.plan.plan import Plan
from wpcal.robot.kinematics.inverse import follow_path
from wpcal.seam.path.position import weld_rotation, weld_slope
from wpcal.seam.record import SEAMS_SCHEMA, seams_from_record

HOLDING = np.radians([19.0, 21.0, 36.0, 15.0, -77.0, 0.0])
"""Robot 2 holds the branch pipe where robot 1 reaches all around it; joint T then turns it."""
SPIN = np.radians(-118.0)  #: Of the torch about its wire: its body is then away from both arms.
NEAR = np.radians([0.0, 0.0, 0.0, 0.0, -45.0, 0.0])  #: Robot 1 bends like this.


@pytest.fixture(scope="session")
def problem():
    return saddle_problem()


@pytest.fixture(scope="session")
def cell(problem):
    return problem.cell


@pytest.fixture(scope="session")
def path(problem):
    return problem.path


@pytest.fixture(scope="session")
def thin():
    return saddle_problem(THINNED)


@pytest.fixture(scope="session")
def coarse():
    """A problem with few points: a search of its own takes a second."""
    return saddle_problem(COARSE)


@pytest.fixture(scope="session")
def searched():
    """The one search of the thinned saddle: all paths of its sweep, and the plans that came of them."""
    return shared_search()


@pytest.fixture(scope="session")
def simple_plan(cell):
    path = CELLS / "saddle-seams.json"
    frames = seams_from_record(read_json(path, schema=SEAMS_SCHEMA), path=str(path))[0].frames
    joints2 = np.repeat(HOLDING[None], len(frames), axis=0)
    joints2[:, 5] += np.unwrap(-np.arctan2(frames.p[:, 1], frames.p[:, 0]))
    joints2[:, 5] -= joints2[:, 5].mean()
    T = cell.held_places(joints2)
    R = T[:, :3, :3] @ frames.R
    p = np.einsum("nij,nj->ni", T[:, :3, :3], frames.p) + T[:, :3, 3]
    tool = np.zeros((len(frames), 4, 4))
    tool[:, :3, :3] = R @ np.diag([1.0, -1.0, -1.0]) @ rotation_from_zyx(0.0, 0.0, SPIN)
    tool[:, :3, 3], tool[:, 3, 3] = p, 1.0
    flange = cell.T_world_base.inverse().matrix @ tool @ cell.T_flange_tool.inverse().matrix
    state = np.concatenate([follow_path(cell.arm, flange, NEAR), joints2], axis=1)
    zeros = np.zeros(len(frames))
    slope, rotation = weld_slope(R[..., 0]), weld_rotation(R[..., 0], R[..., 2])
    return Plan("W1", frames.s_mm, state, slope, rotation, zeros, zeros, {"position_deg": 1.0}, {"f1_1": 0.5})


def link_matrices(arm, T_world_base, joints):
    """Frames of base, links and flange by products of plain matrices."""
    theta, d, a, alpha, _ = arm.chain.table
    frames = [T_world_base.matrix]
    T = T_world_base.matrix @ arm.chain.T_base_dh0.matrix
    for i, angle in enumerate(arm.model_angles(joints) + theta):
        Rz, Rx = rotation_from_zyx(0, 0, angle), rotation_from_zyx(alpha[i], 0, 0)
        step = np.eye(4)
        step[:3, :3], step[:3, 3] = Rz @ Rx, Rz @ [a[i], 0, 0] + [0, 0, d[i]]
        T = T @ step
        frames.append(T)
    return [*frames[:-1], frames[-1] @ arm.chain.T_dhn_flange.matrix]


def _pieces(shape, hulls):
    """Axes, spans and what is to be taken off: a box has three spans, a capsule one and its radius."""
    if hulls and len(shape.hull):
        low, high = shape.hull.min(axis=0), shape.hull.max(axis=0)
        assert len(shape.hull) == 8, "only boxes have a hull here"
        return [(low, np.diag(high - low), 0.0)]
    return [(p, (q - p)[:, None], r) for p, q, r in zip(shape.p, shape.q, shape.radius_mm, strict=True)]


def margins_by_least_squares(cell, joints1, joints2, *, hulls=False):
    """Least distance minus safety distance of every pair, one pair of pieces at a time by bounded least squares.

    With `hulls` a body with a hull is that box, otherwise its capsules.
    """
    frames = [
        *link_matrices(cell.arm, cell.T_world_base, joints1),
        cell.tool_places(joints1[None])[0],
        np.eye(4),
        *link_matrices(cell.arm2, cell.T_world_base2, joints2),
        cell.held_places(joints2[None])[0],
    ]
    pairs = body_pairs(cell)
    margins = []
    for i, j, safety in zip(pairs.first, pairs.second, pairs.safety_mm, strict=True):
        a, b = pairs.bodies[i], pairs.bodies[j]
        T, U = frames[a.carrier], frames[b.carrier]
        found = []
        for p, spans, r in _pieces(a.shape, hulls):
            for k, others, s in _pieces(b.shape, hulls):
                A = np.hstack([T[:3, :3] @ spans, -U[:3, :3] @ others])
                rest = U[:3, :3] @ k + U[:3, 3] - T[:3, :3] @ p - T[:3, 3]
                answer = lsq_linear(A, rest, bounds=(0, 1), method="bvls", tol=1e-14)
                found.append(np.sqrt(2 * answer.cost) - r - s)
        margins.append(min(found) - safety)
    return np.array(margins), pairs


@pytest.fixture(scope="session")
def slow_margins():
    return margins_by_least_squares
