"""What functions of points, rotations, joints and cells return for uneven arrays: each public one that takes them."""

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from tests.golden.test_values_of_steps import functions, needed
from tests.saddle import CELLS
from tests.saved_graphs import saved_seams
from wpcal.core.pairs import PointPairs
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell_file import read_cell
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.kinematics.arm_file import find_arm

ROOMS = (
    *("core", "optim", "calibrate/errors", "calibrate/observe", "calibrate/solve", "calibrate/trust", "study/drift"),
    *("robot/kinematics", "robot/moves", "robot/identify", "robot/torch", "planning/cell", "planning/plan"),
    *("planning/sequence", "planning/search", "weld", "touch", "touch/plan", "controllers/touchup", "taught/match"),
)
rng = np.random.default_rng(11)
P, TURNS = rng.uniform(-300.0, 500.0, (7, 3)), exp_rotation(rng.normal(size=(7, 3)))
Q = P @ TURNS[2].T + [700.0, -90.0, 410.0] + rng.normal(size=P.shape)
JOINTS, SPREAD = rng.uniform(-1.0, 1.0, (5, 6)), rng.normal(size=(7, 3, 3))
ARM, PART = find_arm("mh6"), RigidTransform(TURNS[1], P[1], "base", "part")
CELL, SEEN = read_cell(CELLS / "two-mh6.json"), ARM.forward(JOINTS + 0.001)
COVARIANCES, J = SPREAD @ SPREAD.swapaxes(1, 2) + 0.1 * np.eye(3), rng.normal(size=(7, 3, 6))
PAIRS = PointPairs(tuple("ABCDEFG"), P, Q, COVARIANCES)
USUAL = {
    "arm": ARM, "chain": ARM.chain, "joints": JOINTS, "theta": ARM.model_angles(JOINTS), "T": ARM.forward(JOINTS),
    "cell": CELL, "J": J, "covariances": COVARIANCES, "covariance": COVARIANCES[0],
    "weights": np.arange(1.0, 8.0) / 28.0, "values": P[:, 0], "points": P, "places": P, "t": Q[3], "sigma_mm": 0.3,
    "n": 5, "count": 4, "T_base_part": PART, "pairs": PAIRS, "angle": P[:, 0] / 100.0,
    "x": P[:, 0] / 500.0, "y": P[:, 1] / 500.0, "omega": P / 200.0, "length_mm": 400.0, "near": JOINTS[0] + 0.01,
    "errors": J[:, 0], "B": SPREAD[0], "v": P, "costs": P[:, 2], "T_base_flange": ARM.forward(JOINTS), "level": 0.95,
    "observations": PoseObservations(JOINTS, SEEN[:, :3, 3], SEEN[:, :3, :3]), "freedom": np.arange(3.0, 9.0),
    "coordinates": rng.normal(size=(5, 9)), "within": 300.0, "q_xyzw": P[:4] / 300.0, "pivot": P[3], "to_part_mm": 3.0,
    "shape": CELL.links[1], "seam": saved_seams("tee")[0], "towards": TURNS[0],
    "information": np.linalg.inv(COVARIANCES), "residuals": P - P[::-1], "speed_mm_s": 8.0, "model": P, "real": Q,
}  # fmt: skip
SHAPES: tuple[dict[str, Any], ...] = (
    {"p": P, "q": Q, "R": TURNS[2]},
    {"p": P, "q": JOINTS, "R": TURNS, "T": PART, "joints": JOINTS[0], "theta": ARM.model_angles(JOINTS)[0]},
    {"p": P[:5], "q": np.tile(JOINTS, 2), "joints": np.tile(JOINTS, 2), "R": TURNS[:5], "values": JOINTS},
    {"p": P[0], "q": JOINTS[0], "R": TURNS[:, None], "values": P, "weights": np.full((1, 7), 1.0 / 7)},
)


def asked(step: Callable[..., Any]) -> Any:
    """Return what a function makes of the first arrays that it takes."""
    for shapes in SHAPES:
        known = {**USUAL, **shapes}
        try:
            with np.errstate(all="ignore"):
                found = step(**{name: known[name] for name in needed(step)})
                return list(found) if isinstance(found, Iterator) else found
        except Exception as error:  # of another shape
            told = type(error).__name__
    return told


def steps(room: str) -> dict[str, Callable[..., Any]]:
    """Return the functions of a room that take what is known here, by their names."""
    found = {f"{each.__module__}.{each.__name__}": each for each in functions((room,))}
    return {name: each for name, each in found.items() if set() < needed(each) <= {*USUAL, *SHAPES[0]}}


@pytest.mark.parametrize("room", ROOMS)
def test_arrays(room: str, golden: Any) -> None:
    golden({name: asked(each) for name, each in steps(room).items()})
