import numpy as np
import pytest

from wpcal.calibrate import Criterion, calibrate
from wpcal.core import FormatError
from wpcal.taught.pairs import read_pairs

HEADER = "name,model_x_mm,model_y_mm,model_z_mm,real_x_mm,real_y_mm,real_z_mm"
ROWS = ["a,0,0,0,1,0,0", "b,100,0,0,101,0,0", "c,0,100,0,1,100,0"]


def write(tmp_path, *lines):
    path = tmp_path / "pairs.csv"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def test_rows_become_pairs_of_part_and_base(tmp_path):
    pairs, check = read_pairs(write(tmp_path, HEADER, *ROWS))
    assert (pairs.names, pairs.source, pairs.target, check) == (("a", "b", "c"), "part", "base", None)
    assert np.array_equal(pairs.p_target[1], [101, 0, 0])


def test_the_use_column_splits_fitted_check_and_unused_rows(tmp_path):
    uses = [",yes", ",", ",YES", ",check", ",no"]
    rows = [row + use for row, use in zip([*ROWS, "d,5,5,5,6,5,5", "e,9,9,9,9,9,9"], uses, strict=True)]
    pairs, check = read_pairs(write(tmp_path, HEADER + ",use", *rows))
    assert (pairs.names, check.names) == (("a", "b", "c"), ("d",))


def test_fewer_than_three_rows_are_refused(tmp_path):
    with pytest.raises(FormatError, match="at least 3 points, got 2"):
        read_pairs(write(tmp_path, HEADER, *ROWS[:2]))


def test_a_missing_column_is_named(tmp_path):
    with pytest.raises(FormatError, match="missing column real_z_mm"):
        read_pairs(write(tmp_path, HEADER.removesuffix(",real_z_mm"), *(row[:-2] for row in ROWS)))


def test_the_robot_space_goes_into_the_record(tmp_path):
    rows = [row + ",identified" for row in ROWS]
    pairs, _ = read_pairs(write(tmp_path, HEADER + ",robot_space", *rows))
    assert calibrate(pairs).to_record()["robot_space"] == "identified"


def test_a_doubtful_point_weighs_less(tmp_path):
    rows = [*ROWS, "d,0,0,100,1,0,103"]
    equal, _ = read_pairs(write(tmp_path, HEADER + ",sigma_mm", *(f"{row},0.2" for row in rows)))
    sure, _ = read_pairs(write(tmp_path, HEADER + ",sigma_mm", *(f"{row},0.1" for row in ROWS), rows[3] + ",100"))
    fits = [calibrate(pairs, criterion=Criterion.WEIGHTED, tolerance_mm=5.0).residuals for pairs in (equal, sure)]
    plain = calibrate(equal, criterion=Criterion.LEAST_SQUARES, tolerance_mm=5.0).residuals
    np.testing.assert_allclose(fits[0].vectors_mm, plain.vectors_mm, rtol=0, atol=1e-9)
    np.testing.assert_allclose(fits[1].norms_mm, [0, 0, 0, 3], rtol=0, atol=1e-4)  # weights of one to a million


def test_a_sigma_that_is_none_is_refused(tmp_path):
    with pytest.raises(FormatError, match="line 3, column sigma_mm"):
        read_pairs(write(tmp_path, HEADER + ",sigma_mm", ROWS[0] + ",1", ROWS[1] + ",0", ROWS[2] + ",1"))


COVARIANCE = ",cov_xx_mm2,cov_xy_mm2,cov_xz_mm2,cov_yy_mm2,cov_yz_mm2,cov_zz_mm2"


def test_six_columns_are_the_covariance_of_a_row(tmp_path):
    pairs, _ = read_pairs(write(tmp_path, HEADER + COVARIANCE, *(row + ",0.4,0.1,0.2,0.5,0.3,0.6" for row in ROWS)))
    expected = [[0.4, 0.1, 0.2], [0.1, 0.5, 0.3], [0.2, 0.3, 0.6]]
    np.testing.assert_array_equal(pairs.covariances, [expected] * 3)


def test_sigma_and_the_same_covariance_weigh_alike(tmp_path):
    rows = [*ROWS, "d,0,0,100,1,0,103"]
    sigmas = (0.1, 0.2, 0.3, 0.4)
    by_sigma, _ = read_pairs(
        write(tmp_path, HEADER + ",sigma_mm", *(f"{r},{s}" for r, s in zip(rows, sigmas, strict=True)))
    )
    cells = [f"{r},{s**2},0,0,{s**2},0,{s**2}" for r, s in zip(rows, sigmas, strict=True)]
    by_matrix, _ = read_pairs(write(tmp_path, HEADER + COVARIANCE, *cells))
    first, second = (calibrate(p, criterion=Criterion.WEIGHTED, tolerance_mm=5.0) for p in (by_sigma, by_matrix))
    np.testing.assert_allclose(second.T_base_part.matrix, first.T_base_part.matrix, rtol=0, atol=1e-9)


@pytest.mark.parametrize(
    ("columns", "cells", "words"),
    [
        (COVARIANCE + ",sigma_mm", ",1,0,0,1,0,1,1", "line 1: give either the column sigma_mm or"),
        (COVARIANCE.replace("cov_yz_mm2", "cov_yz_mm"), ",1,0,0,1,0,1", "line 1: unknown column 'cov_yz_mm'; did you"),
        (COVARIANCE.removesuffix(",cov_zz_mm2"), ",1,0,0,1,0", "line 1: missing column cov_zz_mm2"),
        (COVARIANCE, ",1,2,0,1,0,1", "line 2: the covariance is not positive definite: its least eigenvalue is -1 mm"),
        (COVARIANCE, ",1,0,0,1,0,0", "line 2: the covariance is not positive definite"),
        (",sigma", ",1", "line 1: unknown column 'sigma'; did you mean sigma_mm"),
    ],
)
def test_errors_that_cannot_be_read_are_refused_with_their_line(tmp_path, columns, cells, words):
    with pytest.raises(FormatError, match=words):
        read_pairs(write(tmp_path, HEADER + columns, *(row + cells for row in ROWS)))
