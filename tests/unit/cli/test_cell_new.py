"""`wpcal cell new` of an arm whose third joint is shown against the horizontal, and its FANUC program."""

import itertools
import shutil

import numpy as np
import pytest

from tests.one_robot_cells import TEE
from tests.running import run_here
from wpcal.robot.kinematics.arm_file import find_arm

AXES = ("0 0 1", "0 1 0", "0 -1 0", "-1 0 0", "0 -1 0", "-1 0 0")
ORIGINS = ("0 0 0", "0.15 0 0", "0 0 0.6", "0 0 0.2", "0.64 0 0", "0.1 0 0")
LIMITS = ((-2.9, 2.9), (-1.5, 2.7), (-3.1, 4.6), (-3.3, 3.3), (-2.4, 2.4), (-6.2, 6.2))


@pytest.fixture
def urdf(tmp_path):
    """An arm of this kind: upper arm 600 mm, forearm 640 mm, flange x forward."""
    joints = "".join(
        f'<joint name="joint_{n}" type="revolute"><parent link="l{n - 1}"/><child link="l{n}"/><origin xyz="{xyz}"/>'
        f'<axis xyz="{axis}"/><limit lower="{low}" upper="{high}" velocity="3" effort="1"/></joint>'
        for n, (xyz, axis, (low, high)) in enumerate(zip(ORIGINS, AXES, LIMITS, strict=True), start=1)
    )
    ends = '<parent link="l6"/><child link="tool0"/><origin rpy="0 1.5707963268 0"/>'
    tip = f'<joint name="tip" type="fixed">{ends}</joint>'
    links = "".join(f'<link name="l{n}"/>' for n in range(7)) + '<link name="tool0"/>'
    path = tmp_path / "arm.urdf"
    path.write_text(f'<robot name="coupled">{links}{joints}{tip}</robot>', encoding="utf-8")
    return path


def new_cell(urdf, *more):
    cell = urdf.with_name("cell.json")
    done = run_here(
        "cell", "new", "--torch-robot", urdf, "--tool", "0,0,350,0,40,0", "--robot-at", "0,0,500", "-o", cell, *more
    )
    return cell, done


def test_j3_against_the_horizontal_keeps_the_forearm_level(urdf):
    cell, done = new_cell(urdf, "--coupled", "joint_3:joint_2")
    assert done.returncode == 0, done.stderr
    arm = find_arm(str(cell.with_name("arm.arm.json")))
    q = np.radians([[20.0, tilt, 12.0, 0.0, 0.0, 0.0] for tilt in (-30.0, 0.0, 45.0)])
    R = arm.forward(q)[:, :3, :3]
    for a, b in itertools.pairwise(R):
        assert np.allclose(a, b, rtol=0, atol=1e-9)  # J2 moves the forearm and does not tilt it


def test_a_fanuc_program_is_written_with_the_coupling_only(urdf, tmp_path):
    pytest.importorskip("fcl", reason="python-fcl is not installed")
    pytest.importorskip("ompl", reason="ompl is not installed")
    shutil.copytree(TEE, tmp_path / "tee")
    coupled, _ = new_cell(urdf, "--coupled", "joint_3:joint_2")
    asked = ("plan", coupled, tmp_path / "tee", "--only", "W2", "-f", "fanuc", "-o", tmp_path / "plan")
    done = run_here(*asked)
    assert (tmp_path / "plan" / "fanuc" / "W2.ls").exists(), done.stderr
    assert done.returncode == 0
    new_cell(urdf, "--force")
    done = run_here(*asked, "--force")
    assert done.returncode == 1
    assert "no fanuc program: FANUC shows J3 against the horizontal" in done.stderr


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("joint_3", "expected JOINT:ADDS"),
        ("joint_3:joint_2:x", "expected JOINT:ADDS"),
        ("a:joint_2", "names joint 'a'"),
    ],
)
def test_a_coupling_that_cannot_be_is_one_line(urdf, text, says):
    _, done = new_cell(urdf, "--coupled", text)
    assert done.returncode == 2
    assert says in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1
