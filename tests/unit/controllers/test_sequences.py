"""Programs of a sequence, read by patterns of the languages and checked by kinematics of their own."""

import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.one_robot_cells import TEE, fixed_cell, with_positioner, write_cell
from wpcal.controllers.sequence_program import build_sequence_program, possible_sequences
from wpcal.controllers.tool_data import read_tool_data
from wpcal.core.errors import InputError
from wpcal.formats.trajectory import joint_trajectory
from wpcal.planning.cell.one_robot_file import read_one_robot
from wpcal.planning.sequence.plan_sequence import plan_sequence
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.planning.sequence.timeline import build_timeline

yaml = pytest.importorskip("yaml", reason="pyyaml is not installed")
pytest.importorskip("fcl", reason="python-fcl is not installed")
pytest.importorskip("ompl", reason="ompl is not installed")

NUMBER = r"[-+0-9.eE]+"
WRITTEN_MM = 2e-3
"""Angles with five decimals move a point at 2 m by less."""


@pytest.fixture(scope="module")
def sequence(tmp_path_factory):
    record = with_positioner()
    record["positioner"]["T_flange_part"] = {"xyz_mm": [-75, -50, 10], "rpy_deg": [0, 0, 0]}
    cell = read_one_robot(write_cell(tmp_path_factory.mktemp("cell"), record))
    given = read_sequence_input(TEE, fixed_cell(), ["W2", "W3"])
    return plan_sequence(cell, given.part, given.seams, SequenceTargets()).sequence


@pytest.fixture(scope="module")
def files(sequence):
    found, refused = possible_sequences(sequence)
    assert set(refused) == {"fanuc"}  # the mh6 is not one of theirs: J3 without a coupling
    return found


def tip(cell, joints_deg):
    q = np.concatenate([np.radians(joints_deg), np.zeros(len(cell.axis_names) - 6)])[None]
    return np.linalg.inv(cell.base_places(q))[0] @ cell.tool_places(q)[0]


def test_rapid_has_two_targets_for_a_straight_seam_and_all_axes(sequence, files):
    text = files["WPCAL.mod"]
    weld = re.findall(r"! ARC ON\r\n(.*?)! ARC OFF", text, re.DOTALL)
    assert [block.count("Move") for block in weld] == [1, 1]
    assert text.count("MoveL") == 6  # approach, weld and retract of both
    joints = {
        name: np.array([float(v) for v in a.split(",")])
        for name, a in re.findall(r"jointtarget (\w+):=\[\[([^\]]*)\]", text)
    }
    first, last = min(joints), max(joints)
    assert np.allclose(joints[first], np.degrees(sequence.cell.home[:6]), rtol=0, atol=1e-4)
    assert np.allclose(joints[last], joints[first], rtol=0, atol=1e-4)
    targets = re.findall(r"robtarget \w+:=\[\[([^\]]*)\],\[([^\]]*)\],\[([^\]]*)\],\[([^\]]*)\]\]", text)
    assert len(targets) == 6
    for _, _, conf, outer in targets:
        assert len(conf.split(",")) == 4
        assert outer.count("9E+09") == 4  # two axes of the positioner


def test_poses_and_joints_of_rapid_agree_with_inform(sequence, files):
    """The same targets as poses in one language and as joints in another one."""
    poses = re.findall(r"robtarget wp(\d+):=\[\[([^\]]*)\],\[([^\]]*)\]", files["WPCAL.mod"])
    joints = {
        int(n): [float(v) for v in row.split(",")] for n, row in re.findall(r"\nC(\d{5})=([^\r]*)", files["WPCAL.jbi"])
    }
    outer = re.findall(r"\nEC(\d{5})=([^\r]*)", files["WPCAL.jbi"])
    assert len(outer) == len(joints)
    assert "///GROUP2 ST1" in files["WPCAL.jbi"]
    assert f"///NPOS {len(joints)},0,{len(joints)},0,0,0" in files["WPCAL.jbi"]
    assert len(poses) == 6
    for number, place, turn in poses:
        T = tip(sequence.cell, joints[int(number) - 1])
        assert np.allclose(T[:3, 3], [float(v) for v in place.split(",")], rtol=0, atol=10 * WRITTEN_MM)
        w, x, y, z = (float(v) for v in turn.split(","))
        R = Rotation.from_quat([x, y, z, w]).as_matrix()
        assert np.allclose(T[:3, :3], R, rtol=0, atol=1e-5)


def test_krl_states_status_turn_and_external_axes(files):
    text = files["WPCAL.src"]
    poses = re.findall(r"\r\nLIN \{([^}]*)\}", text)
    assert len(poses) == 6
    assert all(re.search(rf"S \d,T \d+,E1 {NUMBER},E2 {NUMBER}$", pose) for pose in poses)
    assert text.count("PTP {A1 ") >= 3
    assert "$TOOL={X 77.782" in text
    assert text.index(["RUN", "IT DRY FIRST"][0]) < text.index("PTP")


def test_every_speed_and_every_seam_is_written(sequence, files):
    for name in (piece.name for piece in sequence.pieces):
        assert f"! {name}" in files["WPCAL.mod"]
        assert f"; {name}" in files["WPCAL.src"]
        assert f"'{name}" in files["WPCAL.jbi"]
    assert "V=6.0" in files["WPCAL.jbi"]
    assert "$VEL.CP=0.006" in files["WPCAL.src"]


def test_the_trajectory_has_every_state_with_its_time(sequence):
    line = build_timeline(sequence)
    record = yaml.safe_load(joint_trajectory(sequence, line))
    assert record["joint_names"] == list(sequence.cell.axis_names)
    q = np.array([point["positions"] for point in record["points"]])
    assert np.allclose(q, line.q, rtol=0, atol=1e-9)
    times = [p["time_from_start"]["sec"] + 1e-9 * p["time_from_start"]["nanosec"] for p in record["points"]]
    assert np.allclose(times, line.t_s, rtol=0, atol=1e-8)


def test_fanuc_has_joints_in_the_air_and_config_on_the_seams(sequence):
    import dataclasses

    from wpcal.controllers.fanuc.sequence import write_sequence_fanuc
    from wpcal.robot.kinematics.arm import Coupling

    program = build_sequence_program(sequence)
    names = [joint.name for joint in program.arm.joints]
    arm = dataclasses.replace(program.arm, couplings=(Coupling(names[2], names[1], 0.0),))
    text = write_sequence_fanuc(dataclasses.replace(program, arm=arm))["wpcal.ls"]
    assert text.count("CONFIG") == 6
    assert len(re.findall(r"GP2:", text)) == len(program.joints)
    assert len(re.findall(r":J P\[\d+\] 50% FINE", text)) == sum(s.speed_mm_s is None for s in program.steps)
    assert "360cm/min" in text or "6mm/sec" in text


RAPID = "PERS tooldata tGun:=[TRUE,[[10,-20,330.5],[0.92388,0,0.382683,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];"
KRL = "TOOL_DATA[3]={X 1.0,Y 2.0,Z 300.0,A 0.0,B 45.0,C 0.0}\nTOOL_DATA[4]={X 0,Y 0,Z 1,A 0,B 0,C 0}"


@pytest.mark.parametrize(
    ("name", "text", "tool", "place"),
    [
        ("a.mod", RAPID, None, [10, -20, 330.5]),
        ("a.src", KRL, "3", [1, 2, 300]),
        ("a.script", "  set_tcp(p[0.01,0,0.35,0,0.785398,0])", None, [10, 0, 350]),
    ],
)  # fmt: skip
def test_tool_data_are_read_from_programs(tmp_path, name, text, tool, place):
    path = tmp_path / name
    path.write_text(text, encoding="utf-8")
    found = read_tool_data(path, tool)
    assert np.allclose(found.t_mm, place, rtol=0, atol=1e-9)
    assert np.allclose(found.R, Rotation.from_euler("y", 45, degrees=True).as_matrix(), rtol=0, atol=1e-5)


@pytest.mark.parametrize(
    ("text", "tool", "says"),
    [
        ("MODULE x\nENDMODULE", None, "no tool data"),
        ("TOOL_DATA[3]={X 1,Y 2,Z 3,A 0,B 0,C 0}\n$TOOL={X 0,Y 0,Z 1,A 0,B 0,C 0}", None, "several tools: name one"),
        ("TOOL_DATA[3]={X 1,Y 2,Z 3,A 0,B 0,C 0}", "7", "no tool '7'"),
        ("tooldata t:=[TRUE,[[1,2,3],[5,0,0,0]]]", None, "the quaternion has length 5"),
    ],
)
def test_tool_data_that_cannot_be_read_are_one_line(tmp_path, text, tool, says):
    path = tmp_path / "a.mod"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=says):
        read_tool_data(path, tool)
