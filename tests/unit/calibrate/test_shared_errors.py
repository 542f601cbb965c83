"""Alarms of touches whose stick-out is stated: it explains what all touches share, and no single wrong touch."""

import numpy as np
import pytest

from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.plane_touches import Planes
from wpcal.calibrate.solve.touches import Pose
from wpcal.calibrate.trust.contradiction import find_contradicted, squares_of
from wpcal.calibrate.trust.tool_offset import PosedRows, find_tool_offset
from wpcal.core.robot_space import RobotSpace

STICK_MM, OWN_MM, TRIALS = 0.5, 0.1, 40
NORMALS = np.repeat(np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0]]), 3, axis=0)
WIRE = -np.cos(0.6) * NORMALS + np.sin(0.6) * np.roll(NORMALS, 1, axis=1)
SIDE = np.cross(WIRE, [0.3, 0.5, 0.8]) / np.linalg.norm(np.cross(WIRE, [0.3, 0.5, 0.8]), axis=1)[:, None]
FRAMES = np.stack([SIDE, np.cross(WIRE, SIDE), WIRE], axis=2)
NAMES = tuple(f"T{k}" for k in range(len(NORMALS)))


def touched(rng: np.random.Generator, blunder_mm: float = 0.0) -> Touches:
    """Touch three walls and a floor with a wire whose stick-out is wrong; the first touch may be a blunder."""
    p = np.where(NORMALS != 0.0, 300.0 * (NORMALS > 0.0), rng.uniform(0.0, 300.0, NORMALS.shape))
    q = p + WIRE * rng.normal(0.0, STICK_MM) + rng.normal(0.0, OWN_MM, p.shape)
    q[0] += blunder_mm * NORMALS[0]
    shared = STICK_MM * WIRE[:, :, None]
    covariances = OWN_MM**2 * np.eye(3) + shared @ shared.swapaxes(1, 2)
    planes = Planes(p, NORMALS)
    rows = np.arange(len(p))
    return Touches(NAMES, q, np.zeros(len(p)), planes, NAMES, covariances, RobotSpace.NOMINAL, rows, shared=shared)


def at_rest(touches: Touches) -> Pose:
    return Pose.of(touches, np.eye(3), np.zeros(3))


def test_a_stick_out_within_its_stated_error_is_no_wrong_tool() -> None:
    rng, alarms = np.random.default_rng(0), {False: 0, True: 0}
    for _ in range(TRIALS):
        touches = touched(rng)
        pose, information, J = squares_of(touches, at_rest(touches), None)
        fixed = (FRAMES.swapaxes(1, 2) @ touches.shared).mean(axis=0)
        for is_stated in alarms:
            stated = is_stated * fixed @ fixed.T
            rows = PosedRows(pose.at.d, J, pose.at.A @ FRAMES, information, len(NAMES), True, stated)
            alarms[is_stated] += find_tool_offset(rows) is not None
    assert alarms[True] <= 1 < alarms[False]


@pytest.mark.parametrize(("blunder_mm", "least", "most"), [(0.0, 0, 2), (1.0, 32, TRIALS)])
def test_a_wrong_touch_is_named_beside_an_error_that_all_share(blunder_mm: float, least: int, most: int) -> None:
    rng = np.random.default_rng(1)
    trials = (touched(rng, blunder_mm) for _ in range(TRIALS))
    found = [find_contradicted(touches, at_rest(touches), None) for touches in trials]
    assert least <= sum(each is not None and each.names == ("T0",) for each in found) <= most
    assert sum(each is not None and "T0" not in each.names for each in found) <= 3
