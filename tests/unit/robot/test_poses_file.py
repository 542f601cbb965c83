import numpy as np
import pytest

from wpcal.core.errors import FormatError, UnitError
from wpcal.core.rotations import quaternion_from_rotation, zyx_from_rotation
from wpcal.robot.identify.poses_file import corrected_table, plan_table, read_poses, read_taught_joints
from wpcal.robot.kinematics.arm_file import find_arm

JOINTS = ",".join(f"q{i}_deg" for i in range(1, 7))
ROWS = [[10, 20, -30, 40, 50, 60], [-10, 25, -35, 45, 55, 65], [0, 30, -20, 10, 20, 30]]
PRINTED = 1e-9  # what is written here with all digits comes back to round-off


def text(header, *rows):
    return "\n".join([header, *(",".join(str(cell) for cell in row) for row in rows)]) + "\n"


def read(tmp_path, content):
    path = tmp_path / "poses.csv"
    path.write_text(content)
    return read_poses(path, find_arm("mh6"))


def good_rows(tail=(1, 2, 3)):
    return [[*row, *tail] for row in ROWS]


def test_positions_only(tmp_path):
    poses, test = read(tmp_path, text(f"{JOINTS},x_mm,y_mm,z_mm", *good_rows()))
    np.testing.assert_allclose(np.rad2deg(poses.joints), ROWS, rtol=0, atol=PRINTED)
    assert not poses.has_orientations
    assert test is None
    assert poses.rows == (2, 3, 4)


@pytest.mark.parametrize("form", ["quaternion", "angles"])
def test_both_forms_of_an_orientation(tmp_path, form):
    T = find_arm("mh6").forward(np.deg2rad(ROWS))
    if form == "quaternion":
        tails, columns = quaternion_from_rotation(T[:, :3, :3]), "qx,qy,qz,qw"
    else:
        tails, columns = [np.rad2deg(zyx_from_rotation(R)) for R in T[:, :3, :3]], "rx_deg,ry_deg,rz_deg"
    rows = [[*q, *p, *tail] for q, p, tail in zip(ROWS, T[:, :3, 3], tails, strict=True)]
    poses, _ = read(tmp_path, text(f"{JOINTS},x_mm,y_mm,z_mm,{columns}", *rows))
    np.testing.assert_allclose(poses.R_base_flange, T[:, :3, :3], rtol=0, atol=PRINTED)


def test_sets_and_reflectors(tmp_path):
    rows = [[*ROWS[0], 1, 2, 3, "B", "train"], [*ROWS[0], 1, 2, 3, "A", "train"], [*ROWS[1], 1, 2, 3, "A", "test"]]
    poses, test = read(tmp_path, text(f"{JOINTS},x_mm,y_mm,z_mm,reflector,set", *rows))
    assert poses.reflectors == ("A", "B")
    assert poses.reflector.tolist() == [1, 0, 0]
    assert test.tolist() == [False, False, True]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (text(f"{JOINTS},x_mm,y_mm", *[row[:-1] for row in good_rows()]), "missing column z_mm"),
        (text("q1_deg,q2_deg,x_mm,y_mm,z_mm", [1, 2, 3, 4, 5]), "missing column q3_deg"),
        (text(f"{JOINTS},q7_deg,x_mm,y_mm,z_mm", [*ROWS[0], 1, 1, 2, 3]), "has 6 joints"),
        (text(f"{JOINTS},x_mm,y_mm,z_mm", [*ROWS[0], "nan", 2, 3]), "line 2, column x_mm.*finite"),
        (text(f"{JOINTS},x_mm,y_mm,z_mm", *good_rows(), [*ROWS[1], 4, 5, 6]), "line 5.*same joint angles as in line 3"),
        (text(f"{JOINTS},x_mm,y_mm,z_mm", [10, 20, -30, 40, 170, 60, 1, 2, 3]), "line 2.*joint B at 170 deg is beyond"),
        (text(f"{JOINTS},x_mm,y_mm,z_mm,qx,qy,qz,qw", *good_rows((1, 2, 3, 0, 0, 0, 1.1))), "length 1, this one 1.1"),
        (text(f"{JOINTS},x_mm,y_mm,z_mm,qx,qy,qz", *good_rows((1, 2, 3, 0, 0, 0))), "missing column qw"),
        (
            text(
                f"{JOINTS},x_mm,y_mm,z_mm,qx,qy,qz,qw,rx_deg,ry_deg,rz_deg", *good_rows((1, 2, 3, 0, 0, 0, 1, 0, 0, 0))
            ),
            "twice",
        ),
        (text(f"{JOINTS},x_mm,y_mm,z_mm,set", *good_rows((1, 2, 3, "train"))), "one word only"),
        (text(f"{JOINTS},x_mm,y_mm,z_mm,set", *good_rows((1, 2, 3, "fit"))), "train or test"),
        (text(f"{JOINTS},x_mm,y_mm,z_mm,reflector", *good_rows((1, 2, 3, ""))), "name is empty"),
        (
            text(
                f"{JOINTS},x_mm,y_mm,z_mm,reflector,qx,qy,qz,qw",
                [*ROWS[0], 1, 2, 3, "A", 0, 0, 0, 1],
                [*ROWS[0], 1, 2, 3, "B", 0, 0, 0, 1],
            ),
            "positions only",
        ),
    ],
)
def test_a_wrong_file_is_one_clear_error(tmp_path, content, message):
    with pytest.raises(FormatError, match=message):
        read(tmp_path, content)


def test_radians_are_noticed(tmp_path):
    rows = [[*np.deg2rad(row), 1, 2, 3] for row in ROWS]
    with pytest.raises(UnitError, match="radians"):
        read(tmp_path, text(f"{JOINTS},x_mm,y_mm,z_mm", *rows))


def test_taught_joints_pass_other_columns_on(tmp_path):
    path = tmp_path / "taught.csv"
    path.write_text(
        text(f"name,{JOINTS},feature,use", ["P1", *ROWS[0], "V1", "yes"], ["P2", *ROWS[1], "V,2", "check"]).replace(
            "V,2", '"V,2"'
        )
    )
    names, joints, others = read_taught_joints(path, find_arm("mh6"))
    assert names == ("P1", "P2")
    table = corrected_table(names, np.ones((2, 3)), others, find_arm("mh6").space)
    assert table.splitlines()[0] == "name,x_mm,y_mm,z_mm,robot_space,feature,use"
    assert table.splitlines()[2] == 'P2,1.000000,1.000000,1.000000,nominal,"V,2",check'
    assert joints.shape == (2, 6)


def test_taught_joints_that_hold_points_already_are_refused(tmp_path):
    path = tmp_path / "taught.csv"
    path.write_text(text(f"name,{JOINTS},x_mm", ["P1", *ROWS[0], 1]))
    with pytest.raises(FormatError, match="column x_mm"):
        read_taught_joints(path, find_arm("mh6"))


def test_a_plan_can_be_filled_in_and_read(tmp_path):
    arm = find_arm("mh6")
    lines = plan_table(arm, np.deg2rad(ROWS)).replace("nominal_", "").splitlines()
    poses, _ = read(tmp_path, "\n".join(lines))
    np.testing.assert_allclose(np.rad2deg(poses.joints), ROWS, rtol=0, atol=PRINTED)
