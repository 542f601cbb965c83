"""Lines and arcs: as few as a search over all choices finds, and within the tolerance; places of a swept check."""

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation, Slerp

from wpcal.core.errors import GeometryError, InputError
from wpcal.core.tangent import exp_rotation
from wpcal.robot.moves import Arc, Line, PathTolerance, fit_moves, sweep
from wpcal.robot.moves.sweep import BODY_STEP_MM, STEP_MM, poses_between
from wpcal.robot.torch.file import shipped_torches

DOWN = np.diag([1.0, -1.0, -1.0])
ROUND_OFF_MM = 1e-6
SLACK = 1.02  # between two checked points of a path a move may be a little farther off than at both


def about_z(angle):
    return Rotation.from_rotvec(np.outer(angle, [0, 0, 1]))


def circle(radius_mm, tilt_rad, points=60, turn_rad=2 * np.pi):
    """A circle round z with the torch tilted from its axis and turned with the travel; directions of travel."""
    angle = np.linspace(0.0, turn_rad, points)
    p = radius_mm * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    tilted = Rotation.from_euler("x", tilt_rad).as_matrix() @ DOWN
    about = about_z(angle + np.pi / 2).as_matrix()
    return p, about @ tilted, about[:, :, 0]


def along(path, at):
    """Where a controller has the tool: another arithmetic than that of wpcal, move by move."""
    places, turns, row = [], [], 0
    for move in path.moves:
        slerp = Slerp([0, 1], Rotation.from_matrix(path.R[[row, move.to]]))
        if isinstance(move, Arc):
            a, b, c = path.p[row], path.p[move.via], path.p[move.to]
            normal = np.cross(b - a, c - a)
            # the centre is equally far from all three points, and in their plane
            rows = np.array([b - a, c - a, normal])
            centre = np.linalg.solve(rows, [(b @ b - a @ a) / 2, (c @ c - a @ a) / 2, normal @ a])
            sweep = 2 * np.pi - 2 * math.acos(np.dot(a - b, c - b) / np.linalg.norm(a - b) / np.linalg.norm(c - b))
            spin = Rotation.from_rotvec(np.outer(at * sweep, normal / np.linalg.norm(normal)))
            places.append(centre + spin.apply(a - centre))
        else:
            places.append(path.p[row] + at[:, None] * (path.p[move.to] - path.p[row]))
        turns.append(slerp(at).as_matrix())
        row = move.to
    return np.concatenate(places), np.concatenate(turns)


def test_a_closed_circle_is_two_arcs_if_the_torch_stays_upright_and_three_if_it_turns():
    p, R, headings = circle(30.0, 0.0)
    upright = fit_moves(p, np.tile(DOWN, (len(p), 1, 1)), headings=headings)
    assert [type(move) for move in upright.moves] == [Arc, Arc]
    p, R, headings = circle(30.0, math.radians(45))
    leaning = fit_moves(p, R, headings=headings)
    assert [type(move) for move in leaning.moves] == [Arc] * 3  # two would turn the tool by 180 degrees, or back
    assert max(upright.off_mm, leaning.off_mm) < 1e-3


@pytest.mark.parametrize("tilt_deg", [0.0, 30.0, 60.0])
@pytest.mark.parametrize("standoff_mm", [0.0, 15.0])
def test_the_tip_keeps_to_a_true_circle(tilt_deg, standoff_mm):
    p, R, headings = circle(40.0, math.radians(tilt_deg), points=25, turn_rad=4.0)
    path = fit_moves(p - standoff_mm * R[:, :, 2], R, headings=headings, standoff_mm=standoff_mm)
    q, turns = along(path, np.linspace(0, 1, 50))
    tip = q + standoff_mm * turns[:, :, 2]
    off = np.hypot(np.linalg.norm(tip[:, :2], axis=1) - 40.0, tip[:, 2])
    assert off.max() <= 0.05 * SLACK
    angle = np.unwrap(np.arctan2(tip[:, 1], tip[:, 0]))
    wire = about_z(angle).as_matrix() @ R[0][:, 2]
    assert np.degrees(np.arccos(np.clip((wire * turns[:, :, 2]).sum(1), -1, 1))).max() <= 0.5 * SLACK


def rectangle(a, b, step=10.0):
    corners = np.array([[0, 0, 0], [a, 0, 0], [a, b, 0], [0, b, 0], [0, 0, 0]], dtype=float)
    sides = [np.linspace(p, q, max(2, int(np.hypot(*(q - p)[:2]) // step)))[:-1] for p, q in pairwise(corners)]
    return np.concatenate([*sides, corners[-1:]])


def test_a_rectangle_is_four_lines_that_stop_at_the_corners():
    p = rectangle(80.0, 50.0)
    path = fit_moves(p, np.tile(DOWN, (len(p), 1, 1)))
    assert len(path.moves) == 4
    np.testing.assert_allclose(np.degrees(path.corner_rad), 90.0, rtol=0, atol=ROUND_OFF_MM)
    assert path.stops(1.0) == (True,) * 4  # a zone of 1 mm would cut the corner by 0.35 mm
    assert path.stops(0.1) == (False, False, False, True)


def random_path(seed, n, fast=0.0):
    """A path that bends and twists, and the torch with it; a fast one turns more in a step than in the one before."""
    rng = np.random.default_rng(seed)
    heading, p, R = np.eye(3)[0], [np.zeros(3)], [DOWN]
    bend, lean = rng.normal(0, 0.03, 3), rng.normal(0, 0.05, 3)
    for _ in range(n - 1):
        if rng.random() < 0.2:
            bend, lean = rng.normal(0, 0.05, 3), rng.normal(0, 0.05, 3)
        heading = Rotation.from_rotvec(bend).apply(heading)
        p.append(p[-1] + rng.uniform(1, 4) * heading)
        lean = Rotation.from_rotvec(fast * rng.normal(0, 0.1, 3)).apply(lean) * (1 + 0.3 * fast)
        R.append(Rotation.from_rotvec(lean).as_matrix() @ R[-1])
    return np.array(p), np.array(R)


def worst(p, R, first, last, path, tolerance):
    """Largest share of the tolerance at the given points between two of them, by the interpolation of this file."""
    q, turns = along(path, np.linspace(0, 1, 401))
    off = np.linalg.norm(q[:, None] - p[None, first : last + 1], axis=2)
    at = off.argmin(axis=0)
    cosine = np.clip(np.einsum("ij,ij->i", turns[at][:, :, 2], R[first : last + 1, :, 2]), -1, 1)
    return max(off.min(axis=0).max() / tolerance.mm, np.arccos(cosine).max() / tolerance.wire_rad)


@pytest.mark.parametrize("seed", range(2))
def test_no_choice_of_single_moves_needs_fewer(seed):
    """Every pair of points is fitted by itself; the least number of such moves is that of the whole path."""
    p, R = random_path(seed, 11)
    whole = fit_moves(p, R)
    is_one = np.zeros((11, 11), dtype=bool)
    for first in range(10):
        for last in range(first + 1, 11):
            part = fit_moves(p[first : last + 1], R[first : last + 1])
            is_one[first, last] = len(part.moves) == 1
            if is_one[first, last]:
                assert worst(p, R, first, last, part, PathTolerance()) <= SLACK or last == first + 1
    fewest = np.full(11, 99)
    fewest[0] = 0
    for last in range(1, 11):
        fewest[last] = min(fewest[first] + 1 for first in range(last) if is_one[first, last])
    assert len(whole.moves) == fewest[-1]


@settings(max_examples=24)
@given(seed=st.integers(0, 10_000), n=st.integers(2, 40), free=st.booleans(), fast=st.sampled_from([0.0, 1.0]))
def test_every_point_is_met_within_what_is_said(seed, n, free, fast):
    p, R = random_path(seed, n if not fast else 2 + n // 5, fast)
    path, allowed = fit_moves(p, R, spin_is_free=free), PathTolerance()
    assert np.all(np.subtract([path.off_mm, path.off_rad], [allowed.mm, allowed.wire_rad]) <= ROUND_OFF_MM)
    q, _ = path.poses_at(path.s_mm)
    np.testing.assert_allclose(q, path.p, rtol=0, atol=0.2)  # an arc's middle is met a little before or after
    assert worst(p, R, 0, n - 1, path, PathTolerance(path.off_mm + 0.02, path.off_rad + 2e-3)) <= 1.0
    np.testing.assert_allclose(path.p[[0, -1]], p[[0, -1]], rtol=0, atol=ROUND_OFF_MM)
    ends = R[[0, -1]] if not free else R[[0, -1], :, 2:]
    np.testing.assert_allclose(path.R[[0, -1]][:, :, -ends.shape[-1] :], ends, rtol=0, atol=1e-6)


@pytest.mark.parametrize("count", [30, 44])
def test_a_moved_path_gives_moved_moves(count, golden):
    p, R = random_path(3, count)
    turn, shift = Rotation.from_rotvec([0.3, -1.0, 0.5]), np.array([100.0, -50.0, 20.0])
    one, other = fit_moves(p, R), fit_moves(turn.apply(p) + shift, turn.as_matrix() @ R)
    assert one.moves == other.moves
    np.testing.assert_allclose(one.p @ turn.as_matrix().T + shift, other.p, rtol=0, atol=ROUND_OFF_MM)
    np.testing.assert_allclose(turn.as_matrix() @ one.R, other.R, rtol=0, atol=1e-9)
    at = one.poses_at(np.linspace(0.0, one.s_mm[-1], 9))
    golden([one, at, one.stops(3.0), one.turned_about(2, 0.3), poses_between(p, R, 7.0, 0.11, 2.1)])


def test_a_wider_tolerance_needs_no_more_moves():
    p, R = random_path(5, 40)
    counts = [len(fit_moves(p, R, tolerance=PathTolerance(mm, mm / 5)).moves) for mm in (0.02, 0.05, 0.2, 1.0)]
    assert counts == sorted(counts, reverse=True)
    assert counts[0] > counts[-1]


def test_a_step_that_turns_more_than_a_move_may_is_divided():
    p, _, headings = circle(5.0, 0.0, points=2, turn_rad=0.05)
    swing = np.stack([DOWN, Rotation.from_rotvec([0.0, np.radians(175), 0.0]).as_matrix() @ DOWN])
    assert fit_moves(p, swing, headings=headings).moves == (Line(1), Line(2))


def test_wrong_use_is_refused():
    with pytest.raises(GeometryError, match="at least 2 points"):
        fit_moves(np.zeros((1, 3)), DOWN[None])
    with pytest.raises(GeometryError, match="no line keeps to the path between point 1 and the next"):
        fit_moves(*random_path(1642, 3), tolerance=PathTolerance(wire_rad=1e-12), spin_is_free=False)
    for mm in (0.0, -1.0, math.nan, math.inf):
        with pytest.raises(InputError, match="path tolerance: expected a positive number"):
            PathTolerance(mm)


def test_a_share_of_a_tolerance_bounds_the_turn_about_the_wire_too():
    asked = PathTolerance(0.1, wire_rad=0.02)
    assert asked.narrowed(0.5) == PathTolerance(0.05, wire_rad=0.01, side_rad=0.01)
    assert asked.narrowed(1.0) == asked


def test_no_point_of_a_torch_moves_farther_than_a_step(golden):
    rng = np.random.default_rng(3)
    p = np.cumsum(rng.normal(scale=2.0, size=(9, 3)), axis=0)
    R = np.stack([exp_rotation(rng.normal(scale=0.4, size=3)) for _ in p])
    for torch in (shipped.shape for shipped in shipped_torches()):
        found = sweep([(p, R)], torch.reaching, axis=2)
        np.testing.assert_allclose(found.R[np.isin(found.at, range(9))], R, rtol=0, atol=1e-12)
        corners = [[x, y, -torch.wire_mm - z] for tube in torch.tubes for x, y, z in (tube.start, tube.end)]
        for points, step in (([[0, 0, 0], [0, 0, -torch.wire_mm]], STEP_MM), (corners, BODY_STEP_MM)):
            for point in np.array(points, dtype=float):
                moved = np.linalg.norm(np.diff(found.p + found.R @ point, axis=0), axis=1)
                assert moved.max() <= step + 1e-9
    golden(found)
