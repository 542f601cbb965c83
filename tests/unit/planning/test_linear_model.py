import numpy as np
import pytest

from wpcal.planning.cell.closed_chain import COORDINATES, SPIN, YAW, joints_along
from wpcal.planning.plan.banded import damped_step
from wpcal.planning.search.objectives import MOTION, OBJECTIVE_NAMES, OBJECTIVES, POSITION, TORCH
from wpcal.planning.search.problem import CandidatePath
from wpcal.planning.search.refine import linearise, refine_path

WEIGHTS = {POSITION: 1e-3, TORCH: 1e-3, MOTION: 1.0}
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
    model = linearise(thin, start, WEIGHTS)
    values = thin.objectives(start.coordinates, start.joints)
    beyond = (np.maximum(model.beyond, 0.0) ** 2).sum()
    weighted = sum(WEIGHTS.get(row, 0.0) * value**2 for row, value in zip(OBJECTIVES, values, strict=True))
    assert model.cost == pytest.approx(weighted + beyond, rel=0, abs=SUM_ATOL)


def test_the_gradient_is_that_of_the_sum(thin, start):
    rng = np.random.default_rng(0)
    rough = start.coordinates + rng.normal(0.0, 0.01, start.coordinates.shape)
    joints = joints_along(thin.cell, thin.path, rough, start.branches, start.joints[0])
    path = CandidatePath(rough, start.branches, joints)
    model = linearise(thin, path, WEIGHTS)
    direction = rng.normal(0.0, 1.0, rough.shape)
    sums = []
    for way in (1e-7, -1e-7):
        moved = rough + way * direction
        joints = joints_along(thin.cell, thin.path, moved, start.branches, path.joints[0])
        sums.append(linearise(thin, CandidatePath(moved, start.branches, joints), WEIGHTS).cost)
    expected = 2.0 * (model.gradient(model.beyond > 0) * direction).sum()
    assert (sums[0] - sums[1]) / 2e-7 == pytest.approx(expected, rel=GRADIENT_RTOL)


def test_the_blocks_are_those_of_the_normal_matrix(thin, start):
    model = linearise(thin, start, WEIGHTS)
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
    model = linearise(thin, start, WEIGHTS)
    step = damped_step(model, 1e-6)
    least = model.predicted_cost(step)
    rng = np.random.default_rng(2)
    assert least < model.cost
    assert all(model.predicted_cost(step + rng.normal(0.0, 1e-3, step.shape)) > least for _ in range(20))


def test_refining_never_makes_the_sum_larger_and_trades_as_the_weights_say(thin, start):
    smooth, exact = (refine_path(thin, start, {POSITION: w, TORCH: w, MOTION: 1.0}) for w in (1e-5, 1e-1))
    for weight, path in ((1e-5, smooth), (1e-1, exact)):
        weights = {POSITION: weight, TORCH: weight, MOTION: 1.0}
        assert linearise(thin, path, weights).cost < linearise(thin, start, weights).cost
        assert max(thin.excesses(path).values()) == 0.0
    values = {name: (a, b) for name, a, b in zip(OBJECTIVE_NAMES, *map(objectives(thin), (smooth, exact)), strict=True)}
    assert values["position_deg"][0] > 10 * values["position_deg"][1]
    assert values["motion_deg_per_mm"][0] < 0.8 * values["motion_deg_per_mm"][1]


def objectives(problem):
    return lambda path: problem.objectives(path.coordinates, path.joints)
