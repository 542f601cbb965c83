"""How often a wrong point is named, against a textbook test, and how often a good one is."""

from types import SimpleNamespace

import numpy as np
import pytest
from scipy.special import chdtrc, fdtrc

from tests.few import few
from wpcal.calibrate import TeachingError, fit_least_squares
from wpcal.calibrate.errors.robot_field import RobotField
from wpcal.calibrate.trust.diagnose import diagnose_pairs
from wpcal.calibrate.trust.left_out import Sets, weigh_sets
from wpcal.calibrate.trust.neighbours import FeaturePlaces
from wpcal.calibrate.trust.robust import contradicted_points
from wpcal.core import PointPairs

pytestmark = pytest.mark.many

SIGMA_MM = 0.15
ALONE = RobotField.none()
ALARM = 0.01
SLACK = 0.05  # three standard deviations of the difference of two shares on the same 150 sets
CORNERS = np.array([[x, y, z] for x in (0, 200.0) for y in (0, 120.0) for z in (0, 10.0)])
WEB = np.array([[x, y, z] for x in (20.0, 180.0) for y in (50.0, 62.0) for z in (10.0, 90.0)])
PART = np.vstack([CORNERS, WEB])
SIGMAS = pytest.mark.parametrize("sigma", few([None, SIGMA_MM], 1), ids=["sigma from residuals", "sigma stated"])


def spread_rows(rng, n):
    while True:
        rows = rng.choice(len(PART), n, replace=False)
        if np.linalg.svd(PART[rows] - PART[rows].mean(axis=0), compute_uv=False)[1] > 20.0:
            return rows


def touched(rng, n, wrong=0, size=0.0):
    """Touch n corners, some of them off by `size` standard deviations; the pairs and the wrong rows."""
    p = PART[spread_rows(rng, n)]
    q = p + SIGMA_MM * rng.normal(size=p.shape)
    bad = tuple(sorted(rng.choice(n, wrong, replace=False).tolist()))
    for row in bad:
        along = rng.normal(size=3)
        q[row] += size * SIGMA_MM * along / np.linalg.norm(along)
    return PointPairs(tuple(f"P{i}" for i in range(n)), p, q), bad


def textbook(pairs, sigma):
    """Name the row with the largest deletion F or χ², at the same false alarms."""
    n = len(pairs)

    def squares(rows):
        some = pairs.select(rows)
        return float(np.sum((some.p_target - fit_least_squares(some).apply(some.p_source)) ** 2))

    total = squares(np.arange(n))
    rest = np.array([squares(np.delete(np.arange(n), i)) for i in range(n)])
    drop = np.maximum(total - rest, 0.0)
    chance = chdtrc(3, drop / sigma**2) if sigma else fdtrc(3, 3 * n - 9, drop / 3 / (rest / (3 * n - 9)))
    worst = int(np.argmin(chance))
    return (worst,) if chance[worst] * n < ALARM else ()


@SIGMAS
@pytest.mark.parametrize(("n", "size"), few([(4, 10.0), (6, 10.0), (5, 10.0), (10, 10.0), (6, 5.0), (10, 5.0)], 2))
def test_a_wrong_point_is_named_as_often_as_by_a_textbook_test(n, size, sigma):
    rng = np.random.default_rng(n)
    mine = book = 0
    for _ in range(150):
        pairs, bad = touched(rng, n, 1, size)
        mine += contradicted_points(pairs, sigma_mm=sigma).named == bad
        book += textbook(pairs, sigma) == bad
    assert mine >= book - SLACK * 150


@SIGMAS
def test_good_points_are_named_in_at_most_one_file_of_a_hundred(sigma):
    rng = np.random.default_rng(0)
    sizes = (4, 5, 6, 8)
    alarms = sum(
        contradicted_points(touched(rng, n)[0], sigma_mm=sigma).at_least > 0 for n in sizes for _ in range(500)
    )
    assert alarms <= ALARM * 2000 + 2.0 * np.sqrt(ALARM * 2000)  # the sampling error of 2000 sets


@SIGMAS
def test_good_points_are_not_given_to_other_features(sigma):
    rng = np.random.default_rng(1)
    places = FeaturePlaces.of({f"V{i}": p for i, p in enumerate(PART)})
    found = [
        diagnose_pairs(
            touched(rng, 4 + k % 4)[0], places=places, teaching=TeachingError(sigma_mm=sigma, robot=ALONE)
        ).suspect
        for k in range(200)
    ]
    assert not any(suspect is not None and suspect.exchanges for suspect in found)


@pytest.mark.parametrize(("n", "sigma"), [(6, SIGMA_MM), (8, SIGMA_MM), (8, None)])
def test_two_wrong_points_are_named_as_a_pair_and_no_good_one_instead(n, sigma):
    rng = np.random.default_rng(2)
    pair = other = 0
    for _ in range(60):
        pairs, bad = touched(rng, n, 2, 20.0)
        named = contradicted_points(pairs, sigma_mm=sigma).named
        pair += named == bad
        other += not set(named) <= set(bad)
    assert pair >= 54
    assert other <= 1


def test_two_of_five_are_said_to_be_two_or_more_and_none_is_named():
    """Three points would remain: they agree with too many errors to show which two are wrong."""
    p = PART[[0, 3, 5, 6, 15]]
    q = p + SIGMA_MM * np.random.default_rng(3).normal(size=p.shape)
    q[0] += [0, 4.0, 3.0]
    q[3] += [3.0, 0, -4.0]
    found = diagnose_pairs(PointPairs(tuple("abcde"), p, q), teaching=TeachingError(sigma_mm=SIGMA_MM, robot=ALONE))
    assert [issue.code for issue in found.issues] == ["blunder-not-named"]
    assert found.suspect.names == ()
    assert "cannot tell which" in found.suspect.sentence


def test_a_wrong_point_is_named_beside_an_error_that_is_stated_too_small():
    pairs, bad = touched(np.random.default_rng(4), 8, 1, 40.0)
    found = diagnose_pairs(pairs, teaching=TeachingError(sigma_mm=SIGMA_MM / 2.5, robot=ALONE))
    assert found.suspect.names == tuple(pairs.names[i] for i in bad)


@pytest.mark.parametrize("scaled", [True, False])
def test_sets_are_weighed_by_their_likelihoods_and_the_numbers_that_they_take(scaled):
    """The Bayesian information criterion; a set that is hardly probable is not told, and has its share."""
    rows = SimpleNamespace(scaled=scaled, freedom=14, floor=lambda left: 0.1 * left)
    sums, gone = np.array([9.0, 30.0, 8.0, 7.5]), np.array([1, 1, 2, 3])
    left = rows.freedom - gone
    share = (np.exp(-sums / 2) if scaled else (sums + 0.1 * left) ** (-left / 2)) * 20.0 ** (-gone / 2)
    found = weigh_sets(rows, Sets(np.arange(4)[:, None], sums, gone, np.ones(4, dtype=bool)))
    told = np.argsort(-share)[:3]
    assert found.sets == tuple((row,) for row in told)
    np.testing.assert_allclose(found.probabilities, share[told] / share.sum(), rtol=1e-12)
