"""The search of a ladder of joint states against all ways through it, and the linear model of changes of a path."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from tests.saddle import changed, scan_coarsely
from wpcal.core.errors import ConvergenceError, GeometryError
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.clearance import capsule_clearance, require_bases_apart
from wpcal.planning.cell.closed_chain import COORDINATES, SPIN, YAW, joints_along
from wpcal.planning.cell.shape import Shape
from wpcal.planning.cell.workplace import LEAST_REGULARITY, candidate_places, weld_zone
from wpcal.planning.plan.banded import damped_step
from wpcal.planning.search.ladder import Ladder, _around, build_ladder, shortest_path
from wpcal.planning.search.objectives import MOTION, OBJECTIVE_NAMES, OBJECTIVES, POSITION, TORCH, deviations
from wpcal.planning.search.problem import CandidatePath
from wpcal.planning.search.reachable_states import ReachablePlace, find_reachable_places
from wpcal.planning.search.refine import linearise, refine_path

WEIGHTS = {POSITION: 1e-3, TORCH: 0.1, MOTION: 1.0}


@pytest.fixture
def refused(problem, monkeypatch):
    """The problem, scanned coarsely: what cannot be planned is refused sooner."""
    scan_coarsely(monkeypatch)
    return problem


@pytest.fixture(scope="module")
def ladder(problem):
    return build_ladder(problem, find_reachable_places(problem, 1)[0])


def test_a_ladder_holds_only_allowed_states_with_every_turn_of_the_last_axis(problem, ladder):
    low, high = problem.cell.limits
    for attitude, joints in zip(ladder.attitude, ladder.joints, strict=True):
        assert len(attitude) == len(joints) > 0
        assert ((joints >= low) & (joints <= high)).all()
        assert capsule_clearance(problem.cell, joints).is_clear.all()
        assert problem.regularity(joints).min() >= LEAST_REGULARITY
        assert joints[:, 11].max() - joints[:, 11].min() > 2 * np.pi


def test_the_way_through_a_ladder_is_the_cheapest_of_all(problem, ladder):
    rng = np.random.default_rng(0)
    rungs = ladder.rungs[[0, 8, 16, 23]]
    few = [rng.permutation(len(ladder.joints[i]))[:5] for i in (0, 8, 16, 23)]
    small = Ladder(
        ladder.reachable,
        rungs,
        ladder.coordinates,
        tuple(ladder.attitude[i][rows] for i, rows in zip((0, 8, 16, 23), few, strict=True)),
        tuple(ladder.joints[i][rows] for i, rows in zip((0, 8, 16, 23), few, strict=True)),
    )
    s, K = problem.path.s_mm[rungs], problem.cell.joint_weights

    def cost(way):
        joints = np.degrees([small.joints[i][k] for i, k in enumerate(way)])
        off = np.degrees(
            deviations(small.coordinates[[small.attitude[i][k] for i, k in enumerate(way)]], problem.targets)
        )
        steps = (np.diff(joints, axis=0) ** 2 @ K / np.diff(s)).sum() / (K.sum() * (s[-1] - s[0]))
        return steps + (off**2 @ [1e-3, 1e-3, 0.1, 0.1]).sum() / len(s)

    best = min(itertools.product(range(5), repeat=4), key=cost)
    path = shortest_path(problem, small, WEIGHTS)
    np.testing.assert_allclose(path.coordinates[0], small.coordinates[small.attitude[0][best[0]]], rtol=0, atol=1e-12)
    np.testing.assert_allclose(path.joints[0], small.joints[0][best[0]], rtol=0, atol=1e-9)


def test_around_a_rung_are_the_points_up_to_the_rungs_beside_it():
    assert [_around(np.array([2, 5, 9]), rung) for rung in (2, 5, 9)] == [(2, 5), (3, 9), (6, 10)]


def test_a_ladder_with_an_empty_rung_has_no_way(problem):
    ladder = build_ladder(problem, ReachablePlace(candidate_places(problem.cell)[0], (5, 5), 0))
    assert min(len(joints) for joints in ladder.joints) == 0
    assert shortest_path(problem, ladder, WEIGHTS) is None


def test_places_are_in_the_zone(cell):
    low, high = weld_zone(cell)
    places = candidate_places(cell)
    assert ((places > low) & (places < high)).all()
    assert low[2] > 0


def far_apart(problem, metres):
    away = RigidTransform(problem.cell.T_world_base2.R, [1000.0 * metres, 0.0, 0.0], "world", "base2")
    return replace(problem, cell=changed(problem.cell, T_world_base2=away, bench=()))


def test_a_seam_out_of_reach_says_which_point_which_arm_and_by_how_much(refused):
    with pytest.raises(
        GeometryError, match=r"seam W1, point 1 \(s = 0.0 mm\): out of reach of robot [12] .* by \d+ mm"
    ):
        find_reachable_places(far_apart(refused, 8), 1)


def test_the_shortage_grows_with_the_distance(refused):
    def short(metres):
        with pytest.raises(GeometryError) as caught:
            find_reachable_places(far_apart(refused, metres), 1)
        return float(str(caught.value).split(" by ")[1].split(" mm")[0])

    assert short(10) > short(8) > 0


def test_bases_too_close_are_refused_whatever_the_joints(cell):
    near = RigidTransform(cell.T_world_base2.R, [250.0, 0.0, 0.0], "world", "base2")
    require_bases_apart(cell)
    with pytest.raises(
        GeometryError, match=r"stand too close .bases 250 mm apart.: robot 1 pedestal and robot 2 pedestal"
    ):
        require_bases_apart(changed(cell, T_world_base2=near, bench=()))


def test_a_start_in_collision_names_the_bodies(refused):
    block = Shape("block", [[0.0, 0.0, 60.0]], [[0.0, 0.0, 300.0]], [60.0])
    blocked = replace(refused, cell=replace(refused.cell, part=(*refused.cell.part, block)))
    with pytest.raises(
        GeometryError, match=r"start of the seam is in collision; .* robot 2 block miss .* by \d+\.\d mm"
    ):
        find_reachable_places(blocked, 1)


def test_no_room_anywhere_names_what_fails_most(refused):
    arm2 = refused.cell.arm2
    narrow = replace(arm2.joints[1], min_rad=-0.01, max_rad=0.0)
    arm2 = replace(arm2, joints=(arm2.joints[0], narrow, *arm2.joints[2:]))
    with pytest.raises(ConvergenceError, match="no feasible plan: joint limits and singular poses fail most"):
        find_reachable_places(replace(refused, cell=changed(refused.cell, arm2=arm2)), 1)


PULLS = {POSITION: 1e-3, TORCH: 1e-3, MOTION: 1.0}
SUM_ATOL = 1e-12  #: Round-off of sums of some hundred squares near one.
GRADIENT_RTOL = 1e-4
"""Of the largest part: clearances have one-sided difference quotients, everything else exact derivatives."""


@pytest.fixture(scope="module")
def start(thin):
    coordinates = np.zeros((len(thin.path), COORDINATES))
    coordinates[:, :3] = (-50.0, 50.0, 700.0)
    coordinates[:, YAW], coordinates[:, SPIN] = 1.4, 0.7
    joints = joints_along(thin.cell, thin.path, coordinates, (0, 1), np.zeros(12))
    return CandidatePath(coordinates, (0, 1), joints)


def test_the_sum_is_that_of_the_weighted_objectives(thin, start):
    model = linearise(thin, start, PULLS)
    values = thin.objectives(start.coordinates, start.joints)
    beyond = (np.maximum(model.beyond, 0.0) ** 2).sum()
    weighted = sum(PULLS.get(row, 0.0) * value**2 for row, value in zip(OBJECTIVES, values, strict=True))
    assert model.cost == pytest.approx(weighted + beyond, rel=0, abs=SUM_ATOL)


def test_the_gradient_is_that_of_the_sum(thin, start, golden):
    rng = np.random.default_rng(0)
    rough = start.coordinates + rng.normal(0.0, 0.01, start.coordinates.shape)
    joints = joints_along(thin.cell, thin.path, rough, start.branches, start.joints[0])
    path = CandidatePath(rough, start.branches, joints)
    model = linearise(thin, path, PULLS)
    direction = rng.normal(0.0, 1.0, rough.shape)
    sums = []
    for way in (1e-7, -1e-7):
        moved = rough + way * direction
        joints = joints_along(thin.cell, thin.path, moved, start.branches, path.joints[0])
        sums.append(linearise(thin, CandidatePath(moved, start.branches, joints), PULLS).cost)
    expected = 2.0 * (model.gradient(model.beyond > 0) * direction).sum()
    assert (sums[0] - sums[1]) / 2e-7 == pytest.approx(expected, rel=GRADIENT_RTOL)
    golden(model)


def test_the_blocks_are_those_of_the_normal_matrix(thin, start):
    model = linearise(thin, start, PULLS)
    active = model.beyond > 0
    step, other = np.random.default_rng(1).normal(0.0, 1.0, (2, *start.coordinates.shape))
    diagonal, coupling = model.normal(active)
    product = np.einsum("nij,nj->ni", diagonal, other)
    product[:-1] += np.einsum("nij,nj->ni", coupling, other[1:])
    product[1:] += np.einsum("nji,nj->ni", coupling, other[:-1])
    moves = [model.scale * np.diff(np.einsum("nmi,ni->nm", model.dq, x), axis=0) for x in (step, other)]
    limits = [active * np.einsum("nmi,ni->nm", model.dbeyond, x) for x in (step, other)]
    deviations = [x @ model.ddeviation.T for x in (step, other)]
    expected = sum(float((a * b).sum()) for a, b in (moves, limits, deviations))
    assert (step * product).sum() == pytest.approx(expected, rel=1e-10)


def test_a_step_reaches_the_least_of_the_model(thin, start):
    model = linearise(thin, start, PULLS)
    step = damped_step(model, 1e-6)
    least = model.predicted_cost(step)
    rng = np.random.default_rng(2)
    assert least < model.cost
    assert all(model.predicted_cost(step + rng.normal(0.0, 1e-3, step.shape)) > least for _ in range(20))


def test_refining_never_makes_the_sum_larger_and_trades_as_the_weights_say(thin, start, golden):
    smooth, exact = (refine_path(thin, start, {POSITION: w, TORCH: w, MOTION: 1.0}) for w in (1e-5, 1e-1))
    for weight, path in ((1e-5, smooth), (1e-1, exact)):
        weights = {POSITION: weight, TORCH: weight, MOTION: 1.0}
        assert linearise(thin, path, weights).cost < linearise(thin, start, weights).cost
        assert max(thin.excesses(path).values()) == 0.0
    values = {name: (a, b) for name, a, b in zip(OBJECTIVE_NAMES, *map(objectives(thin), (smooth, exact)), strict=True)}
    assert values["position_deg"][0] > 10 * values["position_deg"][1]
    assert values["motion_deg_per_mm"][0] < 0.8 * values["motion_deg_per_mm"][1]
    golden(exact)


def objectives(problem):
    return lambda path: problem.objectives(path.coordinates, path.joints)
