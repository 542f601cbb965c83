"""Moves through the air in a cluttered cell: what is refused, and the bound of motions that proves them."""

import copy
import dataclasses
import json
from unittest.mock import Mock

import numpy as np
import pytest

from tests.one_robot_cells import TEE, fixed_cell, positioner_record, random_axes, with_positioner, write_cell
from wpcal.core.errors import GeometryError
from wpcal.planning.cell.cell import WORLD
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.cell_file import read_one_robot
from wpcal.planning.cell.shape import Shape
from wpcal.planning.sequence import roadmap
from wpcal.planning.sequence.air_path import AirPlanner
from wpcal.planning.sequence.motion_check import MotionChecker, _parted, motion_per_axis
from wpcal.planning.sequence.sequence_input import read_sequence_input

pytest.importorskip("fcl", reason="python-fcl is not installed")

PILLARS = ((600.0, 400.0), (700.0, -450.0), (250.0, 650.0), (-450.0, 350.0), (-300.0, -600.0), (150.0, -750.0))
HALF = np.array([80.0, 80.0, 350.0])


@pytest.fixture(scope="module")
def cluttered():
    given = read_sequence_input(TEE, fixed_cell())
    pillars = []
    for row, (x, y) in enumerate(PILLARS):
        corners = np.array(np.meshgrid(*((-h, h) for h in HALF))).reshape(3, -1).T + np.array([x, y, HALF[2]])
        ends = np.array([[x, y, 0.0]]), np.array([[x, y, 2 * HALF[2]]])
        pillars.append(Shape(f"pillar {row}", *ends, [120.0], hull=corners))
    cell = dataclasses.replace(given.placed(fixed_cell()), bench=tuple(pillars))
    return cell, MotionChecker(cell, CellClearance(cell, given.part))


def test_an_end_in_collision_is_one_line(cluttered):
    cell, checker = cluttered
    q = random_axes(cell, 200, seed=1)
    bad = q[~checker.clearance.margins(q).is_clear][0]
    with pytest.raises(GeometryError, match=r"the end of a move is in collision: .* miss their safety distance by"):
        AirPlanner(cell, checker).path(cell.home, bad)


def test_a_place_that_is_shut_in_is_searched_once():
    free = lambda a, b, **_: 1.0 * ((a[:, 0] > 0.0) == (b[:, 0] > 0.0))  # noqa: E731 - a wall at 0 of the first joint
    q = np.array([[0.5, *[0.0] * 5], [0.6, *[0.0] * 5]])
    found = roadmap.Roadmap(fixed_cell(), Mock(per_axis=np.full(6, 1000.0), free_shares=free), 0)
    found._grow = grown = Mock(wraps=found._grow)
    ways = found.way(q[0], -q[0]), found.way(q[1], -q[1])
    assert (*ways, grown.call_count) == (None, None, roadmap.MOST_ROUNDS + roadmap.FEW_ROUNDS)
    assert (found.is_shut_in(-q[1], q[0]), found.is_shut_in(q[1], q[0])) == (True, False)


def test_axes_have_one_name_each(tmp_path):
    record = with_positioner()
    path = write_cell(tmp_path, record)
    arm = copy.deepcopy(positioner_record())
    arm["joints"][0]["name"] = fixed_cell().arm.joints[0].name
    (tmp_path / "positioner.json").write_text(json.dumps(arm), encoding="utf-8")
    names = read_one_robot(path).axis_names
    assert len(set(names)) == len(names)
    assert names[6].startswith("positioner_")


@pytest.fixture(scope="module")
def ends(cluttered):
    """Pairs of random states that a way leads between; in this cell some states are shut in by the pillars."""
    cell, checker = cluttered
    q = random_axes(cell, 60, seed=6)
    return q[checker.clearance.margins(q).is_clear][:16].reshape(8, 2, -1)[[1, 0, 3, 4, 7]]


def test_moves_between_random_states_are_found_and_proved(cluttered, ends, golden):
    cell, checker = cluttered
    planner = AirPlanner(cell, checker)
    found = [planner.path(a, b) for a, b in ends]
    again = AirPlanner(cell, checker).path(*ends[0])
    assert np.array_equal(found[0].q, again.q)  # seeded: the same move again
    assert {len(path.q) > 2 for path in found} == {False, True}
    for path, pair in zip(found, ends, strict=True):
        assert np.array_equal(path.q[[0, -1]], pair)
        assert path.check.is_free
        low, high = cell.limits
        assert ((path.q >= low) & (path.q <= high)).all()
    golden(found)


def test_a_way_that_is_not_found_is_one_line(cluttered, ends, monkeypatch):
    cell, checker = cluttered
    monkeypatch.setattr("wpcal.planning.sequence.roadmap.MOST_ROUNDS", 0)
    with pytest.raises(GeometryError, match="no free way was found"):
        AirPlanner(cell, checker).path(*ends[4])


def test_a_share_of_a_move_ends_before_the_first_collision(cluttered):
    cell, checker = cluttered
    q = random_axes(cell, 80, seed=7)
    a, b = q[:40], q[40:]
    share = checker.free_shares(a, b, whole=False)
    whole = checker.free_shares(a, b, whole=True)
    assert ((whole == 1.0) == (share == 1.0)).all()
    for row in range(len(a)):
        assert (whole[row] == 1.0) == checker.is_free(a[row], b[row])
        if 0.0 < share[row] < 1.0:
            assert checker.is_free(a[row], a[row] + share[row] * (b[row] - a[row]))


def test_bodies_of_two_carriers_approach_each_other_by_no_more_than_their_bound(tmp_path):
    cell = read_one_robot(write_cell(tmp_path, with_positioner()))
    given = read_sequence_input(TEE, cell)
    clearance = CellClearance(given.placed(cell), given.part)
    rng = np.random.default_rng(4)
    points = {row: [] for row in range(len(clearance.cell.frames(cell.home[None])))}
    for body in clearance.pairs.bodies:
        points[body.carrier] += [*body.shape.p, *body.shape.q, *body.shape.hull]
    points[clearance.cell.part_row] += [*given.part.corners.reshape(-1, 3)[:40]]
    points[WORLD] += [*rng.uniform(-1000.0, 1000.0, (20, 3))]
    q = random_axes(clearance.cell, 200, seed=3)
    for axes in (list(range(len(cell.home))), *([axis] for axis in range(len(cell.home)))):
        step = np.zeros_like(q)
        step[:, axes] = rng.uniform(-0.05, 0.05, (len(q), len(axes)))
        bound = np.abs(step) @ motion_per_axis(clearance.cell, clearance).T
        before, after = (clearance.cell.frames(some) for some in (q, q + step))
        for row, pair in enumerate(clearance.carriers.tolist()):
            own = [np.array(points[carrier])[rng.integers(0, len(points[carrier]), 8)] for carrier in pair]
            apart = []
            for frames in (before, after):
                one, other = (np.stack([frames[k].point(p) for p in some]) for k, some in zip(pair, own, strict=True))
                apart.append(np.linalg.norm(one - other, axis=1))
            assert (np.abs(apart[1] - apart[0]) <= bound[:, row] + 1e-9).all(), pair


def test_the_parts_of_steps_follow_each_other():
    (one, other, share), ends = _parted(np.arange(3), np.arange(1, 4), np.array([1, 4, 2]), 4)
    at = np.append(np.arange(4.0), one + share * (other - one))
    found = sorted(zip(*(at[rows].tolist() for rows in ends), strict=True))
    assert found == [(1.0, 1.25), (1.25, 1.5), (1.5, 1.75), (1.75, 2.0), (2.0, 2.5), (2.5, 3.0)]
