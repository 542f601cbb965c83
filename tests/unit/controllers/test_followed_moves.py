"""Written programs, interpolated as the controllers do, keep to the true seam: known curves, not the points on them."""

import math
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation

from tests.moves_of_programs import READERS, followed
from wpcal.controllers.program import ControllerSettings, build_program
from wpcal.controllers.program.describe import describe
from wpcal.controllers.program.few_moves import fit_program
from wpcal.controllers.registry import controller_named
from wpcal.results.folder import FinishedCalibration
from wpcal.robot.moves import Line, PathTolerance
from wpcal.robot.torch.attitude import TorchSettings

CONFIGURATIONS = {"fanuc": "N U T, 0, 0, 0", "inform": "1,0,0,0,0,0,0,0"}
ROUNDED_MM, ROUNDED_DEG = 0.003, 0.003  # of the languages with three decimals
SLACK = 1.03  # between two checked points a move may be a little farther off than at both
FINE = 4001
UP = np.array([0.0, 0.0, 1.0])


def frames(p, x, z):
    """Seam frames from directions of travel and out of the joint."""
    x = x / np.linalg.norm(x, axis=1, keepdims=True)
    z = z - (z * x).sum(1, keepdims=True) * x
    z /= np.linalg.norm(z, axis=1, keepdims=True)
    return p, np.stack([x, np.cross(z, x), z], axis=2)


def straight(t):
    return frames(np.outer(t, [150, 0, 0]), np.tile([1.0, 0, 0], (len(t), 1)), np.tile([0, -1.0, 1.0], (len(t), 1)))


def pipe_on_plate(t):
    a = 2 * np.pi * t
    out = np.stack([np.cos(a), np.sin(a), 0 * a], axis=1)
    return frames(30 * out, np.cross(UP, out), out + UP)


def half_pipe(t):
    return pipe_on_plate(0.5 * t)


def saddle(t):
    """A pipe of radius 25 mm on a pipe of radius 60 mm that lies along x."""
    a, r, big = 2 * np.pi * t, 25.0, 60.0
    out = np.stack([np.cos(a), np.sin(a), 0 * a], axis=1)
    z = np.sqrt(big**2 - (r * np.sin(a)) ** 2)
    dz = -(r**2) * np.sin(a) * np.cos(a) / z
    below = np.stack([0 * a, r * np.sin(a), z], axis=1) / big
    return frames(
        np.stack([r * np.cos(a), r * np.sin(a), z], 1), np.stack([*(r * np.cross(UP, out).T[:2]), dz], 1), out + below
    )


def screw(t):
    a = 1.5 * np.pi * t
    out = np.stack([np.cos(a), np.sin(a), 0 * a], axis=1)
    return frames(80 * out + np.outer(a, [0, 0, 12.0]), 80 * np.cross(UP, out) + [0, 0, 12.0], out + UP / 2)


SHAPES = {
    "straight": (straight, 16, 1),
    "pipe": (pipe_on_plate, 43, 3),
    "half": (half_pipe, 22, 2),
    "saddle": (saddle, 39, 13),
    "screw": (screw, 60, None),
}  # points, and moves if the number is known
TORCHES = {"plain": TorchSettings(), "pushed": TorchSettings(math.radians(10), math.radians(15), 12.0)}


def few(shape, torch, make_seam, T):
    curve, points, _ = SHAPES[shape]
    p, R = curve(np.linspace(0, 1, points))
    seam = make_seam("W1", T.apply(p), T.R @ R, frame="base")
    finished = FinishedCalibration(T, (seam,), (None,), {"verdict": "PASS", "tolerance_mm": 0.5})
    controller = ControllerSettings(configurations=CONFIGURATIONS)
    return fit_program(build_program(finished, torch=TORCHES[torch], controller=controller), PathTolerance())


@pytest.mark.parametrize("torch", TORCHES)
@pytest.mark.parametrize("shape", SHAPES)
def test_the_controllers_keep_to_the_true_seam(shape, torch, make_seam, random_place):
    program = few(shape, torch, make_seam, random_place(5))
    curve, _, count = SHAPES[shape]
    true_p, true_R = curve(np.linspace(0, 1, FINE))
    held = TORCHES[torch]
    wire = np.array(
        [
            math.sin(held.travel_rad),
            math.cos(held.travel_rad) * math.sin(held.work_rad),
            -math.cos(held.travel_rad) * math.cos(held.work_rad),
        ]
    )
    true_wire = true_R @ wire
    if torch == "plain" and count is not None:
        assert len(program.paths[0].weld_moves) == count
    for name, read in READERS.items():
        files = {file: str(text) for file, text in controller_named(name).write(program).items()}
        weld = read(files)
        assert len(weld.steps) == len(program.paths[0].weld_moves), name
        p, turns = followed(weld, 60)
        told = turns.apply([0, 0, 1])
        tip = p + held.standoff_mm * told
        off, at = KDTree(true_p).query(tip)
        off_deg = np.degrees(np.arccos(np.clip((told * true_wire[at]).sum(1), -1, 1)))
        step = np.linalg.norm(np.diff(true_p, axis=0), axis=1).max()
        assert off.max() <= 0.05 * SLACK + ROUNDED_MM + step / 2, name
        assert off_deg.max() <= 0.5 * SLACK + ROUNDED_DEG, name
        back, _ = KDTree(tip).query(true_p)
        assert back.max() <= 0.05 + np.linalg.norm(np.diff(tip, axis=0), axis=1).max() / 2 + ROUNDED_MM, name
        np.testing.assert_allclose(tip[[0, -1]], true_p[[0, -1]], rtol=0, atol=2 * ROUNDED_MM)


def run_round_a_tube(a=80.0, b=50.0, lead=5.0, step=10.0):
    """Frames of a fillet round a square tube: the torch turns on 5 mm before and after each corner, at one rate."""
    corners = np.array([[a / 2, 0, 0], [a / 2, b, 0], [-a / 2, b, 0], [-a / 2, 0, 0]])
    places, turns = [], []
    ends = np.array([[0, 0, 0], *corners, [0, 0, 0]], dtype=float)
    for side, (start, end) in enumerate(pairwise(ends)):
        length = np.linalg.norm(end - start)
        own = {0.0, length, *np.arange(step, length, step)}
        own |= set(np.linspace(0, lead, 4)) if side else set()
        own |= set(length - np.linspace(0, lead, 4)) if side < 4 else set()
        for s in sorted(own):
            before, after = max(0.0, lead - s) / lead * (side > 0), max(0.0, s - length + lead) / lead * (side < 4)
            places.append(start + (end - start) * s / length)
            turns.append(90.0 * side + 45.0 * (after - before))
    keep = [0, *(row for row in range(1, len(places)) if np.linalg.norm(places[row] - places[row - 1]) > 1e-9)]
    about = Rotation.from_euler("z", np.array(turns)[keep, None], degrees=True).as_matrix()
    _, R = frames(np.zeros((1, 3)), np.array([[1.0, 0, 0]]), np.array([[0, -1.0, 1.0]]))
    return np.array(places)[keep], about @ R


def test_a_run_round_a_tube_turns_at_its_corners_and_stops_there(make_seam, random_place, golden):
    p, R = run_round_a_tube()
    T = random_place(5)
    finished = FinishedCalibration(T, (make_seam("W1", T.apply(p), T.R @ R, frame="base"),), (None,), {})
    controller = ControllerSettings(configurations=CONFIGURATIONS)
    program = fit_program(build_program(finished, controller=controller))
    path = program.paths[0]
    assert [type(move) for move in path.weld_moves] == [Line] * 13  # five sides, and twice four corners
    assert sum(path.stops(1.0)) == 5
    assert "stops at corners, where a zone would cut by more than 0.05 mm: 4" in describe(program)
    for name, read in READERS.items():
        weld = read({file: str(text) for file, text in controller_named(name).write(program).items()})
        q, turns = followed(weld, 200)
        at = np.argmin(np.linalg.norm(q[:, None] - p[None], axis=2), axis=0)
        np.testing.assert_allclose(q[at], p, rtol=0, atol=0.2)
        wire = turns[at].apply([0, 0, 1])
        off = np.degrees(np.arccos(np.clip(-(wire * R[:, :, 2]).sum(1), -1, 1)))
        assert off.max() <= 0.5 + 45 / 200, name  # the nearest of 200 places on a move
    golden(path)


def test_the_tool_turns_no_farther_about_the_wire_than_it_may(make_seam, random_place):
    curve, points, _ = SHAPES["pipe"]
    p, R = curve(np.linspace(0, 1, points))
    T = random_place(5)
    finished = FinishedCalibration(T, (make_seam("W1", T.apply(p), T.R @ R, frame="base"),), (None,), {})
    for most in (0.0, 20.0):
        torch = TorchSettings(spin_range_rad=math.radians(most))
        path = fit_program(build_program(finished, torch=torch)).paths[0]
        travel = Rotation.from_matrix(path.seam.frames.R @ np.diag([1.0, -1.0, -1.0]))
        _, now, frame, _ = path.stations()
        turn = (travel.inv() * Rotation.from_matrix(now[np.isin(frame, np.arange(points))])).as_rotvec(degrees=True)
        assert np.abs(turn[:, 2]).max() <= most + 0.6
