"""The paper's own numbers: Table 1 and what follows from it."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wpcal.calibrate import Criterion, Solver, anneal_pairs, calibrate, solve_minimax
from wpcal.core import RigidTransform
from wpcal.optim import AnnealingSchedule
from wpcal.taught.pairs import read_pairs

TABLE1 = Path(__file__).parents[3] / "fixtures" / "yin2003" / "table1.csv"
OPTIMUM_MM = 0.2198230047896
PAPER_MM = 0.221581
REACHED_MM = 1e-9  # asked of the polished answer
ONE_CHAIN_MM = 0.006  # spread of a single chain's end over seeds; the paper's value is one draw, too
PRINTED = 1e-5  # digits of the six-tuple in the issue that asked for it


@pytest.fixture(scope="module")
def pairs():
    return read_pairs(TABLE1)[0]


@pytest.mark.parametrize("solver", list(Solver))
def test_the_certified_optimum_of_table_1(pairs, solver):
    result = calibrate(pairs, solver=solver, criterion=Criterion.MINIMAX)
    assert result.objective_mm == pytest.approx(OPTIMUM_MM, rel=0, abs=REACHED_MM)
    assert result.gap_mm <= REACHED_MM
    assert result.certified
    assert np.ptp(result.residuals.norms_mm) <= REACHED_MM
    six = list(result.T_base_nominal.six_tuple.to_record().values())
    expected = [0.041180, -43.904, -6.65186, -0.00425409, -0.0104627, 0.0215545]
    assert np.allclose(six, expected, rtol=0, atol=[PRINTED, 1e-3, PRINTED, 1e-7, 1e-7, 1e-7])


def test_the_multipliers_are_the_weights_of_the_proof(pairs):
    weights = solve_minimax(pairs).weights
    assert np.allclose(weights, [0.1112, 0.1884, 0.3509, 0.3495], rtol=0, atol=1e-4)


def test_the_annealer_alone_from_the_full_box(pairs):
    excess = [anneal_pairs(pairs, seed=seed)[1].cost - OPTIMUM_MM for seed in range(20)]
    assert max(excess) <= 0.005
    assert min(excess) >= -REACHED_MM


def test_the_annealer_finds_a_part_that_lies_upside_down(pairs):
    over = RigidTransform.from_six_tuple([900, -40, 300, np.pi, 0.1, 2.0], target="base", source="part")
    turned = type(pairs)(pairs.names, pairs.p_source, over.apply(pairs.p_target))
    assert anneal_pairs(turned, seed=3)[1].cost - OPTIMUM_MM <= 0.005


@pytest.mark.deep
def test_the_published_schedule_ends_where_the_paper_did(pairs):
    T, report = anneal_pairs(pairs, schedule=AnnealingSchedule.yin2003(), seed=0)
    assert OPTIMUM_MM <= report.cost <= PAPER_MM + ONE_CHAIN_MM
    assert (np.diff(report.trace.best_cost) <= 0).all()
    largest = np.linalg.norm(pairs.p_target - T.apply(pairs.p_source), axis=1).max()
    assert largest == pytest.approx(report.cost, rel=0, abs=REACHED_MM)


def test_the_report_names_the_schedule(pairs):
    published = replace(AnnealingSchedule.yin2003(), least_moves=1, most_moves=5, least_temperatures=1)
    short = replace(published, most_temperatures=2)  # its search is not tested here
    own = AnnealingSchedule(most_temperatures=2, least_temperatures=1)
    found = [
        calibrate(pairs, schedule=schedule, criterion=Criterion.MINIMAX).solver.schedule
        for schedule in (None, short, own)
    ]
    assert found == ["default", "yin2003", "custom"]


def test_the_nominal_place_changes_the_correction_and_not_the_part(pairs):
    nominal = RigidTransform.from_six_tuple([100, 200, 300, 0.1, -0.2, 0.3], target="nominal", source="part")
    plain, placed = calibrate(pairs), calibrate(pairs, T_nominal_part=nominal)
    assert placed.T_base_part.is_close(plain.T_base_part, atol_mm=REACHED_MM, atol_rad=REACHED_MM)
    again = placed.T_base_nominal @ nominal
    assert again.is_close(placed.T_base_part, atol_mm=REACHED_MM, atol_rad=REACHED_MM)
    assert plain.T_base_nominal.is_close(
        RigidTransform(plain.T_base_part.R, plain.T_base_part.t_mm, "base", "nominal"), atol_mm=0, atol_rad=REACHED_MM
    )
