"""The file of taught points: columns, uses and the robot's space."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from wpcal.core.arrays import frozen
from wpcal.core.errors import FormatError, FrameError, InputError
from wpcal.core.robot_space import RobotSpace
from wpcal.taught.features import FeatureKind, ReferenceFeature
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
    assert check is not None
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
