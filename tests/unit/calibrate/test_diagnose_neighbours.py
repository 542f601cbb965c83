"""A row that was touched on the neighbour of its feature, and wrong points among the check points."""

import numpy as np
import pytest

from tests.few import few
from wpcal.calibrate import Solver, TeachingError
from wpcal.calibrate import calibrate as calibrate_points
from wpcal.core import PointPairs
from wpcal.core.tangent import exp_rotation

pytestmark = pytest.mark.many

CORNERS = {
    f"V{i}": np.array(p, dtype=np.float64)
    for i, p in enumerate([(x, y, z) for x in (0, 200) for y in (0, 120) for z in (0, 12)])
}
TOPS = {"H1": np.array([50.0, 60, 12]), "C1": np.array([50.0, 60, 12]), "V20": np.array([100.0, 60, 90])}
FEATURES = CORNERS | TOPS
R = exp_rotation([0.3, -1.2, 0.4])
NOISE_MM = 0.2


def calibrate(pairs, **options):
    return calibrate_points(pairs, solver=Solver.EXACT, **options)


def touched(rows, seed=0):
    """Touch features; ``{"V3": "V2"}``: the row V3 was touched on V2."""
    real = np.array([FEATURES[feature] for feature in rows.values()])
    real = real + NOISE_MM * np.random.default_rng(seed).normal(size=real.shape)
    return PointPairs(tuple(rows), np.array([FEATURES[name] for name in rows]), real @ R.T + [1000, -200, 300])


def same(*names):
    return {name: name for name in names}


@pytest.mark.parametrize("sigma", few([None, NOISE_MM], 1), ids=["sigma from residuals", "sigma stated"])
@pytest.mark.parametrize("others", [("V1", "V7", "V20"), ("V1", "V5", "V7", "V20")], ids=["4 points", "5 points"])
def test_the_neighbour_of_a_feature_is_named(others, sigma):
    for seed in range(20):
        pairs = touched({"V3": "V2"} | same(*others), seed)
        result = calibrate(pairs, features=FEATURES, teaching=TeachingError(sigma_mm=sigma))
        issue = result.issues[0]
        assert (issue.code, issue.ids) == ("neighbour-feature", ("V3", "V2"))
        assert issue.message.startswith("V2 instead of V3 leaves 0.")
        assert result.suspect.sentence == issue.message


def test_the_feature_of_the_same_kind_is_proposed_where_two_share_a_place():
    pairs = touched({"V3": "H1"} | same("V1", "V5", "V7", "V20"))
    assert calibrate(pairs, features=FEATURES).issues[0].ids == ("V3", "H1")


def test_a_point_beside_every_feature_is_mis_taught_and_given_to_none():
    pairs = touched(same("V1", "V3", "V5", "V7", "V20"))
    off = pairs.p_target.copy()
    off[1] += R @ [3.0, 4.0, 2.0]
    result = calibrate(PointPairs(pairs.names, pairs.p_source, off), features=FEATURES)
    assert result.suspect.names == ("V3",)
    assert not result.suspect.exchanges


def test_a_wrong_fitted_point_is_named_and_not_the_check_point_that_is_right():
    pairs = touched(same("V1", "V3", "V5", "V7", "V20", "H1"))
    off = pairs.p_target.copy()
    off[1] += R @ [0, 3.0, 1.0]
    wrong = PointPairs(pairs.names, pairs.p_source, off)
    fitted, check = wrong.select([0, 1, 2, 3]), wrong.select([4, 5])
    result = calibrate(fitted, check=check)
    assert result.suspect.names == ("V3",)
    assert result.suspect.probability > 0.95
    assert result.distrusted.names == ("V3",)
    assert result.distrusted.without_them.largest_mm < 3 * NOISE_MM


def test_a_wrong_check_point_is_named_and_the_fit_keeps_all_its_points():
    pairs = touched(same("V1", "V3", "V5", "V7", "V20", "H1"))
    off = pairs.p_target.copy()
    off[5] += R @ [0, 4.0, 1.0]
    wrong = PointPairs(pairs.names, pairs.p_source, off)
    result = calibrate(wrong.select([0, 1, 2, 3, 4]), check=wrong.select([5]))
    assert result.suspect.names == ("H1",)
    assert result.distrusted is None
