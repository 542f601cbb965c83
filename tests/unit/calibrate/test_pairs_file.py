import numpy as np
import pytest

from wpcal.calibrate import Criterion, calibrate, read_pairs
from wpcal.core import FormatError

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
