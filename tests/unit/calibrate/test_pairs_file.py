import numpy as np
import pytest

from wpcal.calibrate import calibrate, read_pairs
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
