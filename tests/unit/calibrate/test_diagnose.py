import numpy as np
import pytest

from wpcal.calibrate import Criterion, PointProblem, TeachingError, calibrate
from wpcal.calibrate.errors.robot_field import RobotField
from wpcal.calibrate.trust.diagnose import diagnose_pairs
from wpcal.core import GeometryError, PointPairs, UnitError
from wpcal.core.tangent import exp_rotation

PLATE = np.array([[0, 0, 0], [400, 0, 0], [400, 300, 0], [0, 300.0, 0]])
BODY = np.array([[0, 0, 0], [600, 0, 20], [580, 400, 0], [10, 390, 60], [300, 200, 300], [100, 350, 210.0]])
NAMES = tuple("abcdefgh")
R = exp_rotation([0.3, -1.2, 0.4])
NOISE_MM = 0.2
ALONE = RobotField.none()


def pairs_of(model, real, seed=0, noise_mm=NOISE_MM):
    real = np.asarray(real) + np.random.default_rng(seed).normal(size=np.shape(real)) * noise_mm
    return PointPairs(NAMES[: len(model)], model, real @ R.T + [1000, -200, 300])


def robust(pairs, sigma_mm=None):
    return PointProblem(pairs, TeachingError(sigma_mm=sigma_mm)).fit(Criterion.ROBUST)


def codes(pairs, **options):
    return [issue.code for issue in diagnose_pairs(pairs, **options).issues]


def only(pairs, code, **options):
    found = [issue for issue in diagnose_pairs(pairs, **options).issues if issue.code == code]
    assert len(found) == 1
    return found[0]


@pytest.mark.parametrize("sigma", [None, NOISE_MM], ids=["sigma from residuals", "sigma stated"])
def test_good_points_are_left_in_peace(sigma):
    quiet = sum(
        not codes(pairs_of(BODY, BODY, seed), teaching=TeachingError(sigma_mm=sigma, robot=ALONE))
        for seed in range(100)
    )
    assert quiet >= 95  # three tests of 1 % each


@pytest.mark.parametrize("which", range(6))
def test_a_mis_taught_point_is_named(which):
    off = BODY.copy()
    off[which] += [0, 0, 8.0]
    assert only(pairs_of(BODY, off), "blunder", teaching=TeachingError(sigma_mm=NOISE_MM, robot=ALONE)).ids == (
        NAMES[which],
    )


def test_a_blunder_does_not_move_the_robust_fit():
    off = BODY.copy()
    off[1] += [3.0, 20.0, 0]
    good, bad = pairs_of(BODY, BODY), pairs_of(BODY, off)
    assert robust(bad).rows.tolist() == [0, 2, 3, 4, 5]
    left_out = robust(good.select([0, 2, 3, 4, 5])).T
    assert robust(bad).T.is_close(left_out, atol_mm=1e-9, atol_rad=1e-12)


def test_swapped_names_are_named():
    issue = only(pairs_of(BODY, BODY[[0, 4, 2, 3, 1, 5]]), "swapped-names")
    assert issue.ids == ("b", "e")


def test_swapped_corners_of_a_rectangle_cannot_be_told_apart():
    issue = only(pairs_of(PLATE, PLATE[[1, 0, 2, 3]]), "swapped-names")
    assert "too symmetric" in issue.message
    assert set(issue.ids) == {"a", "b", "c", "d"}


def test_a_mirrored_set_is_named_and_a_flat_one_is_said_to_hide():
    assert "mirror image" in only(pairs_of(BODY, BODY * [1, -1, 1]), "mirrored").message
    assert codes(pairs_of(PLATE, PLATE * [1, -1, 1])) == ["four-coplanar", "coplanar-mirror"]


@pytest.mark.parametrize(
    ("factor", "words"), [(1e-3, "taught.*metres"), (1e3, "model.*metres"), (1 / 25.4, "taught.*inches")]
)
def test_a_unit_slip_is_refused_and_named(factor, words):
    with pytest.raises(UnitError, match=words):
        calibrate(pairs_of(BODY, BODY * factor, noise_mm=0.0))


@pytest.mark.parametrize("place", [[0.0, 0.0, 0.0], [100.0, -20.0, 7.0]])
@pytest.mark.parametrize("side", ["model", "taught"])
def test_points_at_one_place_are_called_so_wherever_it_is(place, side):
    one, spread = np.tile(place, (4, 1)), PLATE + place
    pairs = PointPairs(NAMES[:4], *((one, spread) if side == "model" else (spread, one)))
    with pytest.raises(GeometryError, match=f"the {side} points coincide"):
        calibrate(pairs)


def test_one_corner_off_the_plane_leaves_a_quarter_at_all_four_and_no_name():
    off = PLATE.copy()
    off[2, 2] += 2.0
    pairs = pairs_of(PLATE, off, noise_mm=0.0)
    result = calibrate(pairs)
    assert np.allclose(result.residuals.norms_mm, 0.5, rtol=0, atol=0.001)
    found = [issue.code for issue in result.issues]
    assert "four-coplanar" in found
    assert "blunder" not in found
    assert len(robust(pairs, sigma_mm=0.1).rows) == len(pairs)
    assert "cannot tell which" in calibrate(pairs, teaching=TeachingError(sigma_mm=0.1)).judgement.sentence
