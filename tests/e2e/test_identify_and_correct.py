"""`wpcal identify` and `wpcal correct` as a user types them: files in, files out, exit codes, one line on an error."""

import json

import numpy as np
import pytest

from tests.simulated_poses import XIONG_2015_ERRORS, random_joints, simulate_poses
from wpcal.cli.main import run
from wpcal.core.rotations import quaternion_from_rotation
from wpcal.robot.identify.identifiability import Noise
from wpcal.robot.kinematics.arm_file import find_arm, read_arm

HEADER = "q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,x_mm,y_mm,z_mm,qx,qy,qz,qw"
NOISE = Noise(0.05, float(np.deg2rad(0.005)))


def wpcal(capsys, *arguments):
    with pytest.raises(SystemExit) as ending:
        run([str(argument) for argument in arguments])
    return ending.value.code, *capsys.readouterr()


@pytest.fixture
def rows():
    arm, rng = find_arm("mh6"), np.random.default_rng(0)
    seen = simulate_poses(arm, XIONG_2015_ERRORS, random_joints(arm, 70, rng=rng), rng=rng, noise=NOISE)
    return np.column_stack([np.rad2deg(seen.joints), seen.p_base, quaternion_from_rotation(seen.R_base_flange)])


def write(path, rows, header=HEADER):
    path.write_text("\n".join([header, *(",".join(f"{value:.9f}" for value in row) for row in rows)]) + "\n")
    return path


@pytest.mark.deep
def test_the_published_solver_draws_its_fitness(tmp_path, capsys, rows):
    poses = write(tmp_path / "poses.csv", rows)
    code, text, _ = wpcal(capsys, "identify", "mh6", poses, "-o", tmp_path / "out", "--method", "ga-tabu", "--json")
    record = json.loads(text)
    assert code == 0
    assert record["search"]["tabu"]["evaluations"] == 1 + 2500 * 20
    assert (tmp_path / "out" / "fitness.png").stat().st_size > 5000


def test_shuffled_measurements_end_with_code_1_and_no_arm(tmp_path, capsys, rows):
    rows[:, 6:] = np.random.default_rng(1).permutation(rows[:, 6:])
    out = tmp_path / "out"
    code, text, _ = wpcal(capsys, "identify", "mh6", write(tmp_path / "poses.csv", rows), "-o", out, "--no-charts")
    assert code == 1
    assert "NOT IMPROVED" in text
    assert [file.name for file in out.iterdir()] == ["identification.json"]


def test_a_result_is_the_same_bytes_again_and_not_overwritten(tmp_path, capsys, rows):
    poses, out = write(tmp_path / "poses.csv", rows), tmp_path / "out"
    arguments = ["identify", "mh6", poses, "-o", out]
    wpcal(capsys, *arguments)
    first = {file.name: file.read_bytes() for file in out.iterdir()}
    code, _, error = wpcal(capsys, *arguments)
    assert code == 2
    assert "--force" in error
    wpcal(capsys, *arguments, "--force")
    assert {file.name: file.read_bytes() for file in out.iterdir()} == first


def test_a_plan_is_written(tmp_path, capsys):
    out = tmp_path / "plan"
    code, text, _ = wpcal(capsys, "identify", "mh6", "--plan", 20, "-o", out, "--above-mm", 200)
    assert code == 0
    assert "observability" in text
    assert len((out / "plan.csv").read_text().splitlines()) == 21


def radians(rows):
    rows[:, :6] = np.deg2rad(rows[:, :6])


def far(rows):
    rows[3, 6] = 9000.0


def nothing(rows):
    rows[5, 7] = np.nan


def stretched(rows):
    rows[2, 9:] *= 1.2


def doubled(rows):
    rows[9] = rows[4]


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (radians, "radians"),
        (far, "row 5 is"),
        (nothing, "line 7, column y_mm"),
        (stretched, "line 4, column qx"),
        (doubled, "line 11: the same joint angles as in line 6"),
    ],
)
def test_bad_poses_are_one_line_and_nothing_is_written(tmp_path, capsys, rows, damage, message):
    damage(rows)
    out = tmp_path / "out"
    code, text, error = wpcal(capsys, "identify", "mh6", write(tmp_path / "poses.csv", rows), "-o", out)
    assert code == 2
    assert text == ""
    assert message in error
    assert error.count("\n") == 1
    assert not out.exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["mh6", "POSES4", "-o", "OUT"], "too few poses"),
        (["mh9", "POSES", "-o", "OUT"], "no shipped arm"),
        (["mh6", "-o", "OUT"], "POSES.csv is missing"),
        (["mh6", "POSES", "-o", "OUT", "--plan", "9"], "leave out POSES.csv"),
        (["mh6", "POSES", "-o", "OUT", "--parameters", "theta1,gamma2"], "unknown parameter 'gamma2'"),
        (["mh6", "POSES", "-o", "OUT", "--noise-mm", "0.1"], "together"),
        (["mh6", "POSES", "-o", "OUT", "--method", "ga-tabu", "--unknown-base"], "known base and tool"),
        (["mh6", "POSES", "-o", "OUT", "--folds", "90"], "2 to 70 folds"),
        (["mh6", "--plan", "2", "-o", "OUT"], "plan more poses"),
        (["mh6", "absent.csv", "-o", "OUT"], "no such file"),
    ],
)
def test_wrong_use_is_one_line_and_nothing_is_written(tmp_path, capsys, rows, arguments, message):
    names = {
        "POSES": str(write(tmp_path / "poses.csv", rows)),
        "POSES4": str(write(tmp_path / "few.csv", rows[:6])),  # two of the six are test poses
        "OUT": str(tmp_path / "out"),
    }
    code, text, error = wpcal(capsys, "identify", *(names.get(argument, argument) for argument in arguments))
    assert code == 2
    assert text == ""
    assert message in error
    assert error.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_a_robot_file_with_a_wrong_number_of_joints(tmp_path, capsys, rows):
    from wpcal.robot.kinematics.arm_file import arm_record

    record = arm_record(find_arm("mh6"))
    record["joints"].pop()
    robot = tmp_path / "robot.json"
    robot.write_text(json.dumps(record))
    poses = write(tmp_path / "poses.csv", rows)
    code, _, error = wpcal(capsys, "identify", robot, poses, "-o", tmp_path / "out")
    assert code == 2
    assert "6 links, but 5 joints" in error


def test_missing_matplotlib_is_one_line_that_says_what_to_install(tmp_path, capsys, rows, monkeypatch):
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None)
    poses = write(tmp_path / "poses.csv", rows)
    code, _, error = wpcal(capsys, "identify", "mh6", poses, "-o", tmp_path / "out")
    assert code == 2
    assert "wpcal[plots]" in error


def test_taught_joints_become_points_that_are_read_as_taught(tmp_path, capsys, rows):
    from wpcal.core.robot_space import RobotSpace, space_of_table
    from wpcal.core.tables import read_table
    from wpcal.taught.table import read_taught

    wpcal(capsys, "identify", "mh6", write(tmp_path / "poses.csv", rows), "-o", tmp_path / "out", "--no-charts")
    taught = tmp_path / "taught.csv"
    taught.write_text(
        "name,q1_deg,q2_deg,q3_deg,q4_deg,q5_deg,q6_deg,feature\nP1,10,20,-30,20,40,50,V1\nP2,12,22,-33,22,44,55,V2\n"
    )
    robot, points = tmp_path / "out" / "identified.json", tmp_path / "points.csv"
    code, text, _ = wpcal(capsys, "correct", taught, "--robot", robot, "-o", points, "--tool", "0,0,300")
    assert code == 0
    assert "P2" in text
    read = read_taught(points)
    assert read.features == ("V1", "V2")
    assert space_of_table(read_table(points)) is RobotSpace.IDENTIFIED
    q = np.deg2rad([[10, 20, -30, 20, 40, 50], [12, 22, -33, 22, 44, 55]])
    wanted = read_arm(robot).forward(q) @ [0, 0, 300, 1]
    np.testing.assert_allclose(read.p_base, wanted[:, :3], rtol=0, atol=1e-6)  # written with six decimals
    np.testing.assert_allclose(read.R_base_tool, read_arm(robot).forward(q)[:, :3, :3], rtol=0, atol=1e-5)
    code, text, _ = wpcal(capsys, "correct", taught, "--robot", robot)
    assert code == 0
    assert text.startswith("name,x_mm,y_mm,z_mm,robot_space,rx_deg,ry_deg,rz_deg,feature\n")
    code, _, error = wpcal(capsys, "correct", taught, "--robot", robot, "-o", points)
    assert code == 2
    assert "--force" in error
