import json
from dataclasses import replace

import jsonschema
import numpy as np
import pytest

from tests.chain_error import chain_error
from tests.few import few
from wpcal.core.errors import ConvergenceError, InputError
from wpcal.core.records import to_json
from wpcal.core.schemas import schema_text
from wpcal.planning.cell.closed_chain import torch_on_seam
from wpcal.planning.search.nsga2 import Nsga2Options, PathEncoding, first_population
from wpcal.planning.search.objectives import MOTION, OBJECTIVES, POSITION, TORCH
from wpcal.planning.search.pareto import Preference, failed_record, pareto_record
from wpcal.planning.search.plan_seam import SWEEP, best_paths, judge_paths, plan_seam

SAME = 1e-9  #: Round-off of millimetres and angles that were added to nothing.
FEW = Nsga2Options(population=20, generations=3)


@pytest.fixture(scope="module")
def swept(searched):
    return searched.swept


@pytest.fixture(scope="module")
def with_genetic(thin):
    return plan_seam(thin, genetic=FEW)


def test_a_sweep_gives_one_path_for_each_set_of_weights(thin, swept, golden):
    assert len(swept) == len(SWEEP)
    values = np.array([thin.objectives(path.coordinates, path.joints) for path in swept])
    tight = [row for row, weights in enumerate(SWEEP) if weights[TORCH] > 1e-2]
    assert (np.diff(values[tight, OBJECTIVES.index(POSITION)]) > 0).all()
    assert (np.diff(values[tight, OBJECTIVES.index(MOTION)]) < 0).all()
    golden(swept)


def test_an_interrupted_search_keeps_what_it_has(thin, swept, monkeypatch):
    def stopped(*_):
        yield from swept[:4]
        raise KeyboardInterrupt

    monkeypatch.setattr("wpcal.planning.search.plan_seam.sweep_paths", stopped)
    result = plan_seam(thin)
    assert result.interrupted
    assert 1 <= len(result.front) <= 4


def test_an_interruption_before_any_plan_is_one(coarse):
    def stop(what, done, of):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        plan_seam(coarse, progress=stop)


@pytest.mark.deep
def test_the_genetic_front_is_kept_beside_the_deterministic_one(with_genetic):
    result = with_genetic
    assert result.ladder is not None
    assert result.hypervolume_of(result.front) >= result.hypervolume_of(result.ladder) > 0
    assert {plan.found_by for plan in result.front.plans} <= {"ladder", "nsga2"}


def test_a_front_dominates_a_volume_and_no_front_dominates_none(searched):
    result = searched.result
    assert result.hypervolume_of(result.front) == result.hypervolume_of(result.ladder) > 0
    assert result.hypervolume_of(result.genetic) == result.hypervolume_of(None) == 0.0
    assert {plan.found_by for plan in result.front.plans} == {"ladder"}


@pytest.mark.parametrize("name", few(["searched", "with_genetic"], 1))
def test_the_record_follows_its_schema_and_holds_the_plans(name, request, golden):
    result = request.getfixturevalue(name)
    result = getattr(result, "result", result)
    record = json.loads(to_json(pareto_record(result, Preference.SMOOTH)))
    validator = jsonschema.Draft202012Validator(json.loads(schema_text("wpcal/pareto/1")))
    validator.validate(record)
    chosen = record["plans"][record["chosen"] - 1]
    motions = [plan["objectives"]["motion_deg_per_mm"] for plan in record["plans"]]
    assert chosen["objectives"]["motion_deg_per_mm"] == min(motions)
    np.testing.assert_allclose(
        np.radians(chosen["robot2_deg"]), result.front.plans[record["chosen"] - 1].q[:, 6:], rtol=0, atol=1e-12
    )
    validator.validate(json.loads(to_json(failed_record(result.problem, "no feasible plan"))))
    golden(record)


@pytest.mark.deep
def test_the_same_genetic_search_gives_the_same_bytes(thin, with_genetic):
    again = plan_seam(thin, genetic=FEW)
    records = [to_json(pareto_record(one, Preference.BALANCED)) for one in (with_genetic, again)]
    assert records[0] == records[1]


def test_too_fast_a_torch_has_no_feasible_plan_and_says_why(thin, swept):
    with pytest.raises(ConvergenceError, match=r"no feasible plan: joint speeds fails most, on 15 of 15 paths"):
        judge_paths(replace(thin, speed_mm_s=5000.0), swept)


def test_the_genes_of_a_base_are_the_path_itself(thin, swept):
    paths = best_paths(thin, swept)
    code = PathEncoding.of_seeds(thin, paths)
    decoded = code.decode(code.of_bases())
    values = thin.objectives(decoded.coordinates, decoded.joints)
    for row, path in enumerate(paths):
        np.testing.assert_allclose(decoded.coordinates[row], path.coordinates, rtol=0, atol=SAME)
        assert tuple(decoded.branches[row]) == path.branches
        np.testing.assert_allclose(values[row], thin.objectives(path.coordinates, path.joints), rtol=0, atol=SAME)
    assert (decoded.violations <= 0).all()


def test_a_base_between_two_is_their_mean(thin, swept):
    code = PathEncoding.of_seeds(thin, swept[:3])
    genes = code.of_bases()[1:2]
    genes[0, -3] = 1.25
    expected = 0.75 * swept[1].coordinates + 0.25 * swept[2].coordinates
    np.testing.assert_allclose(code.decode(genes).coordinates[0], expected, rtol=0, atol=SAME)


def test_decoded_paths_close_the_chain_and_are_judged_like_any(thin):
    code = PathEncoding.of_seeds(thin, ())
    decoded = code.decode(code.random(300, np.random.default_rng(0)))
    reached = np.flatnonzero(decoded.violations[:, 0] <= 0)
    assert len(reached) >= 30
    for row in reached[:30]:
        path = decoded.path(int(row))
        state = np.concatenate([path.joints[:, :6], path.joints[:, 6:]], axis=1)
        off_mm, off_rad = chain_error(thin.cell, thin.path, state, torch_on_seam(path.coordinates))
        assert off_mm.max() <= 1e-6
        assert off_rad.max() <= 1e-9
        allowed = max(thin.excesses(path).values()) == 0.0
        assert allowed == (decoded.violations[row] <= 0).all()


def test_a_first_population_holds_the_seeds_as_they_are(thin, swept):
    code = PathEncoding.of_seeds(thin, best_paths(thin, swept)[:3])
    genes = first_population(code, 20, np.random.default_rng(0))
    np.testing.assert_array_equal(genes[:3], code.of_bases())
    assert genes.shape == (20, len(code.least))
    unseeded = PathEncoding.of_seeds(thin, ())
    random = first_population(unseeded, 20, np.random.default_rng(0))
    assert ((random >= unseeded.least) & (random <= unseeded.largest)).all()
    assert random[:, 3].std() > 1.0  # yaw, all around


@pytest.mark.parametrize("given", [{"population": 3}, {"generations": 0}, {"seed": -1}])
def test_the_least_population_generations_and_seed_are_taken(given):
    least = {name: value + 1 for name, value in given.items()}
    assert all(getattr(Nsga2Options(**least), name) == value for name, value in least.items())
    with pytest.raises(InputError):
        Nsga2Options(**given)
