"""Tables of taught points and of point pairs: read, refused with place and reason."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from wpcal.calibrate import Criterion, calibrate
from wpcal.core.arrays import frozen
from wpcal.core.errors import FormatError, FrameError, InputError
from wpcal.core.robot_space import RobotSpace
from wpcal.taught.features import FeatureKind, ReferenceFeature
from wpcal.taught.pairs import read_pairs
from wpcal.taught.table import TaughtPoints, pair_points, read_taught, taught_csv

CORNERS = np.array([[0, 0, 0], [10, 0, 0], [0, 20, 0], [0, 0, 30]], dtype=float)
FEATURES = tuple(
    ReferenceFeature(f"V{i}", FeatureKind.VERTEX, frozen(p), None, None, "S1") for i, p in enumerate(CORNERS, 1)
)


def written(tmp_path: Path, *lines: str) -> Path:
    path = tmp_path / "taught.csv"
    path.write_text("\n".join(lines))
    return path


def test_a_name_is_the_feature_where_no_column_says_otherwise(tmp_path: Path) -> None:
    rows = [f"v{i},{i},0,0" for i in (3, 1, 4)]
    pairs, check = pair_points(read_taught(written(tmp_path, "name,x_mm,y_mm,z_mm", *rows)), FEATURES)
    np.testing.assert_array_equal(pairs.p_source, CORNERS[[2, 0, 3]])
    np.testing.assert_array_equal(pairs.p_target[:, 0], [3, 1, 4])
    assert check is None


def test_use_says_what_is_fitted_and_what_is_checked(tmp_path: Path) -> None:
    rows = ["a,V1,0,0,0,yes", "b,V2,1,0,0,", "c,V3,2,0,0,check", "d,V4,3,0,0,YES", "e,nonsense,4,0,0,no"]
    taught = read_taught(written(tmp_path, "name,feature,x_mm,y_mm,z_mm,use", *rows))
    pairs, check = pair_points(taught, FEATURES)
    assert pairs.names == ("a", "b", "d")
    assert check.names == ("c",)
    np.testing.assert_array_equal(check.p_source, CORNERS[[2]])


def test_model_coordinates_need_no_feature(tmp_path: Path) -> None:
    header = "name,x_mm,y_mm,z_mm,model_x_mm,model_y_mm,model_z_mm"
    rows = ["a,0,0,0,1,2,3", "b,1,0,0,4,5,6", "c,0,1,0,7,8,10"]
    pairs, _ = pair_points(read_taught(written(tmp_path, header, *rows)), ())
    np.testing.assert_array_equal(pairs.p_source, [[1, 2, 3], [4, 5, 6], [7, 8, 10]])


@pytest.mark.parametrize(
    ("lines", "says"),
    [
        (["name,x_mm,y_mm,z_mm", "V9,0,0,0", "V2,1,0,0", "V3,0,1,0"], "line 2: the part has no feature 'V9'; near: V"),
        (["name,x_mm,y_mm,z_mm,feature", "a,0,0,0,", "b,1,0,0,V2", "c,0,1,0,V3"], "line 2, column feature"),
        (["name,x_mm,y_mm,z_mm,use", "V1,0,0,0,yes", "V2,1,0,0,yes", "V3,0,1,0,check"], "at least 3 points"),
    ],
)
def test_points_that_cannot_be_paired(tmp_path: Path, lines: list[str], says: str) -> None:
    with pytest.raises(FormatError, match=says):
        pair_points(read_taught(written(tmp_path, *lines)), FEATURES)


def test_feature_and_model_columns_contradict_each_other(tmp_path: Path) -> None:
    header = "name,x_mm,y_mm,z_mm,feature,model_x_mm,model_y_mm,model_z_mm"
    with pytest.raises(FormatError, match="either the column feature"):
        read_taught(written(tmp_path, header, "a,0,0,0,V1,0,0,0"))


def test_the_robot_space_is_read_and_never_mixed(tmp_path: Path) -> None:
    header = "name,x_mm,y_mm,z_mm,robot_space"
    rows = ["V1,0,0,0,identified", "V2,1,0,0,identified", "V3,0,1,0,identified"]
    assert read_taught(written(tmp_path, header, *rows)).space is RobotSpace.IDENTIFIED
    with pytest.raises(FrameError, match="correct both or neither"):
        read_taught(written(tmp_path, header, *rows[:2], "V3,0,1,0,nominal"))


def test_touched_features_of_a_script() -> None:
    taught = TaughtPoints.of_features(["V1", "V2", "V4"], CORNERS[[0, 1, 3]] + 5.0)
    pairs, _ = pair_points(taught, FEATURES)
    np.testing.assert_array_equal(pairs.p_target - pairs.p_source, np.full((3, 3), 5.0))
    with pytest.raises(InputError, match="2 names and 3"):
        TaughtPoints.of_features(["V1", "V2"], CORNERS[:3])


@pytest.mark.parametrize(
    ("columns", "first", "second"),
    [
        ("feature,use", "V1,yes", ",check"),
        ("model_x_mm,model_y_mm,model_z_mm,sigma_mm,tcp_bias_mm", "1.5,2,3,0.25,0.125", "4,5,6,0.5,0.125"),
        ("kind,feature,model_x_mm,model_y_mm,model_z_mm,radius_mm", "plane,,1,2,3,2.5", "hole,H2,,,,"),
        ("rx_deg,ry_deg,rz_deg,robot_space", "10,20,30,identified", ",,,identified"),
        (",".join(f"cov_{axes}_mm2" for axes in ("xx", "xy", "xz", "yy", "yz", "zz")), "4,1,0,5,2,6", "1,0,0,1,0,1"),
    ],
)
def test_what_is_read_is_written_and_read_again(tmp_path: Path, columns: str, first: str, second: str) -> None:
    rows = f"name,x_mm,y_mm,z_mm,{columns}", f"A,1.25,2,3,{first}", f"B,4,5,6,{second}"
    taught = read_taught(written(tmp_path, *rows))
    again = read_taught(written(tmp_path, taught_csv(taught)))
    for field in fields(TaughtPoints):
        if field.name != "sha256":
            np.testing.assert_array_equal(getattr(again, field.name), getattr(taught, field.name), field.name)


HEADER = "name,model_x_mm,model_y_mm,model_z_mm,real_x_mm,real_y_mm,real_z_mm"
ROWS = ["a,0,0,0,1,0,0", "b,100,0,0,101,0,0", "c,0,100,0,1,100,0"]


def test_rows_become_pairs_of_part_and_base(tmp_path):
    pairs, check = read_pairs(written(tmp_path, HEADER, *ROWS))
    assert (pairs.names, pairs.source, pairs.target, check) == (("a", "b", "c"), "part", "base", None)
    assert np.array_equal(pairs.p_target[1], [101, 0, 0])


def test_the_use_column_splits_fitted_check_and_unused_rows(tmp_path):
    uses = [",yes", ",", ",YES", ",check", ",no"]
    rows = [row + use for row, use in zip([*ROWS, "d,5,5,5,6,5,5", "e,9,9,9,9,9,9"], uses, strict=True)]
    pairs, check = read_pairs(written(tmp_path, HEADER + ",use", *rows))
    assert (pairs.names, check.names) == (("a", "b", "c"), ("d",))


def test_the_robot_space_goes_into_the_record(tmp_path):
    rows = [row + ",identified" for row in ROWS]
    pairs, _ = read_pairs(written(tmp_path, HEADER + ",robot_space", *rows))
    assert calibrate(pairs).to_record()["robot_space"] == "identified"


def test_a_doubtful_point_weighs_less(tmp_path):
    rows = [*ROWS, "d,0,0,100,1,0,103"]
    equal, _ = read_pairs(written(tmp_path, HEADER + ",sigma_mm", *(f"{row},0.2" for row in rows)))
    sure, _ = read_pairs(written(tmp_path, HEADER + ",sigma_mm", *(f"{row},0.1" for row in ROWS), rows[3] + ",100"))
    fits = [calibrate(pairs, criterion=Criterion.WEIGHTED, tolerance_mm=5.0).residuals for pairs in (equal, sure)]
    plain = calibrate(equal, criterion=Criterion.LEAST_SQUARES, tolerance_mm=5.0).residuals
    np.testing.assert_allclose(fits[0].vectors_mm, plain.vectors_mm, rtol=0, atol=1e-9)
    np.testing.assert_allclose(fits[1].norms_mm, [0, 0, 0, 3], rtol=0, atol=1e-4)  # weights of one to a million


def test_a_sigma_that_is_none_is_refused(tmp_path):
    with pytest.raises(FormatError, match="line 3, column sigma_mm"):
        read_pairs(written(tmp_path, HEADER + ",sigma_mm", ROWS[0] + ",1", ROWS[1] + ",0", ROWS[2] + ",1"))


COVARIANCE = ",cov_xx_mm2,cov_xy_mm2,cov_xz_mm2,cov_yy_mm2,cov_yz_mm2,cov_zz_mm2"


def test_six_columns_are_the_covariance_of_a_row(tmp_path):
    pairs, _ = read_pairs(written(tmp_path, HEADER + COVARIANCE, *(row + ",0.4,0.1,0.2,0.5,0.3,0.6" for row in ROWS)))
    expected = [[0.4, 0.1, 0.2], [0.1, 0.5, 0.3], [0.2, 0.3, 0.6]]
    np.testing.assert_array_equal(pairs.covariances, [expected] * 3)


def test_sigma_and_the_same_covariance_weigh_alike(tmp_path):
    rows = [*ROWS, "d,0,0,100,1,0,103"]
    sigmas = (0.1, 0.2, 0.3, 0.4)
    by_sigma, _ = read_pairs(
        written(tmp_path, HEADER + ",sigma_mm", *(f"{r},{s}" for r, s in zip(rows, sigmas, strict=True)))
    )
    cells = [f"{r},{s**2},0,0,{s**2},0,{s**2}" for r, s in zip(rows, sigmas, strict=True)]
    by_matrix, _ = read_pairs(written(tmp_path, HEADER + COVARIANCE, *cells))
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
        read_pairs(written(tmp_path, HEADER + columns, *(row + cells for row in ROWS)))
