"""Plans of one robot in URScript, VAL3 and AS, read by patterns of the languages and checked by forward kinematics."""

import dataclasses
import re

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.one_robot_cells import TEE, TEE_ON_TABLE, fixed_cell, with_positioner, write_cell
from tests.unit.controllers.judging import judged
from wpcal.controllers.program.arc import ArcSettings
from wpcal.controllers.program.planned_program import PlanOutput, build_planned_program
from wpcal.controllers.registry import controller_named
from wpcal.core.errors import InputError
from wpcal.planning.cell.cell_file import read_one_robot
from wpcal.planning.sequence.kept_plan import KeptPlan
from wpcal.planning.sequence.plan_sequence import plan_sequence
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.targets import SequenceTargets

pytest.importorskip("fcl", reason="python-fcl is not installed")

WRITTEN_MM = 2e-3  #: Angles with six decimals move a point at 2 m by less.
WRITTEN = 1e-6  #: Of entries of rotations.
SEAMS = ["W2", "W3"]


def made(cell, **output):
    given = read_sequence_input(TEE, cell, SEAMS)
    cell = given.placed(cell)
    sequence = plan_sequence(cell, given.part, given.seams, SequenceTargets()).sequence
    return cell, build_planned_program(
        KeptPlan.of(sequence), {each.name: each for each in given.seams}, PlanOutput(**output)
    )


@pytest.fixture(scope="module")
def fixed():
    return made(fixed_cell())


@pytest.fixture(scope="module")
def turned(tmp_path_factory):
    return made(read_one_robot(write_cell(tmp_path_factory.mktemp("cell"), with_positioner(TEE_ON_TABLE))))


def written(program, name):
    files = controller_named(name).write(program)
    judged(files, program, name)
    return files


def tips(cell, joints):
    q = np.concatenate([joints, np.zeros((len(joints), len(cell.axis_names) - 6))], axis=1)
    return np.linalg.inv(cell.base_places(q)) @ cell.tool_places(q)


def numbers(text):
    return np.array([float(value) for value in re.findall(r"[-+0-9.]+", text)])


def same(T, p, R):
    assert np.allclose(T[:3, 3], p, rtol=0, atol=WRITTEN_MM)
    assert np.allclose(T[:3, :3], R, rtol=0, atol=WRITTEN)


def check_ends(cell, program, joints, points):
    """Compare the joint moves with the poses of the paths: home, each approach, and each retract."""
    T, row = tips(cell, joints), 0
    assert np.allclose(joints[[0, -1]], cell.home[:6], rtol=0, atol=1e-6)
    for way, path in zip(program.planned.air, program.paths, strict=False):
        row += len(way)
        same(T[row - 1], path.p_base[0], path.R_base[0])
    for (p, R), path in zip(points, program.paths, strict=True):
        assert np.allclose(p, path.p_base[path.before :], rtol=0, atol=WRITTEN_MM)
        assert np.allclose(R, path.R_base[path.before :], rtol=0, atol=WRITTEN)


def test_urscript_goes_to_joints_between_seams(fixed):
    cell, program = fixed
    (text,) = written(program, "urscript").values()
    joints = np.array([numbers(row) for row in re.findall(r"movej\(\[([^\]]*)\]", text)])
    assert text.count("movej(") == len(joints) == sum(map(len, program.planned.air))
    frame = numbers(re.search(r"wp_part = p\[([^\]]*)\]", text)[1])
    R_part = Rotation.from_rotvec(frame[3:]).as_matrix()
    poses = np.array([numbers(row) for row in re.findall(r"movel\(pose_trans\(wp_part, p\[([^\]]*)\]", text)])
    p = 1e3 * (poses[:, :3] @ R_part.T + frame[:3])
    R = R_part @ Rotation.from_rotvec(poses[:, 3:]).as_matrix()
    counts = np.cumsum([len(path) - path.before for path in program.paths])[:-1]
    check_ends(cell, program, joints, zip(np.split(p, counts), np.split(R, counts), strict=True))
    speeds = {float(v) for v in re.findall(r"movej\(\[[^\]]*\], a=[\d.]+, v=([\d.]+)\)", text)}
    allowed = 0.5 * min(joint.speed_rad_s for joint in cell.arm.joints)
    assert max(speeds) <= allowed * 1.001
    assert text.index("RUN IT DRY") < text.index("movej")


def test_val3_goes_to_joints_between_seams(fixed):
    cell, program = fixed
    files = written(program, "val3")
    data, start = files["WPCAL.dtx"], files["start.pgx"]
    block = re.search(
        r'<Data name="jPlan" access="public" xsi:type="array" type="jointRx" size="(\d+)">(.*?)</Data>', data, re.S
    )
    rows = re.findall(r'<Value key="(\d+)"((?: j\d="[^"]*"){6}) />', block[2])
    joints = np.radians([numbers(re.sub(r"j\d=", "", row)) for _, row in rows])
    assert [int(key) for key, _ in rows] == list(range(int(block[1])))
    assert [int(key) for key in re.findall(r"movej\(jPlan\[(\d+)\],tTorch,mJoint\)", start)] == list(range(len(rows)))
    assert start.count("movej(") == len(rows)
    assert re.search(r'name="mJoint".*?vel="50".*?blend="off"', data, re.S)
    frame = numbers(re.search(r'key="0" (x=.*?) fatherId="world', data)[1].replace("x=", "", 1))
    points = []
    for name in SEAMS:
        own = re.search(rf'<Data name="{name}" .*?</Data>', data, re.S)[0]
        values = np.array([numbers(v) for v in re.findall(r' (x="[^/]*rz="[^"]*")', own)])
        R_part = Rotation.from_euler("XYZ", frame[3:], degrees=True).as_matrix()
        R = R_part @ Rotation.from_euler("XYZ", values[:, 3:], degrees=True).as_matrix()
        points.append((values[:, :3] @ R_part.T + frame[:3], R))
    ordered = {path.seam.name: row for path, row in zip(program.paths, range(len(SEAMS)), strict=True)}
    check_ends(cell, program, joints, [points[SEAMS.index(name)] for name in sorted(ordered, key=ordered.get)])


def as_values(text, section):
    block = re.search(rf"^\.{section}\r\n(.*?)^\.END", text, re.S | re.M)[1]
    return {name: numbers(values) for name, values in re.findall(r"^(\S+) ([^\r]*)\r$", block, re.M)}


def test_as_goes_to_precision_points_between_seams(turned):
    cell, program = turned
    (text,) = written(program, "as").values()
    axes, points = as_values(text, "JOINTS"), as_values(text, "TRANS")
    assert sorted(re.findall(r"JMOVE (\S+)\r", text)) == sorted(axes)
    assert len(axes) == sum(map(len, program.planned.legs))
    assert {len(row) for row in axes.values()} == {8}
    external = np.radians(np.array(list(axes.values()))[:, 6:])
    assert np.allclose(external, np.concatenate([m.external for m in program.planned.legs]), rtol=0, atol=1e-7)
    frame, found = points.pop("wp_part"), []
    assert np.allclose(frame, 0.0, rtol=0, atol=1e-9)  # the part turns: the points are in the base of the robot
    for path in program.paths:
        own = np.array([row for name, row in points.items() if name.startswith(f"{path.seam.name}_")])
        R = Rotation.from_euler("ZYZ", own[:, 3:6], degrees=True).as_matrix()
        found.append((own[:, :3], R))
        assert np.allclose(np.radians(own[:, 6:]), path.external[path.before :], rtol=0, atol=1e-7)
    check_ends(cell, program, np.radians(np.array(list(axes.values()))[:, :6]), found)
    main, *seams = text.split(".PROGRAM ")[1:]
    seams = [part for part in seams if not part.startswith("only_")]
    assert [part.count("JMOVE") for part in seams] == [1] * len(program.paths)
    assert "JT7 = tilt, JT8 = turn" in main


def test_with_the_arc_on_all_three_start_and_end_it(fixed):
    _cell, program = fixed
    program = dataclasses.replace(program, arc=ArcSettings(output=3))
    for name, on in (("urscript", "set_standard_digital_out(3, True)"), ("val3", "doArc=true")):
        assert "".join(written(program, name).values()).count(on) == len(SEAMS)


@pytest.mark.parametrize("name", ["urscript", "val3"])
def test_a_language_without_external_axes_says_so_if_they_move(fixed, turned, name):
    _cell, program = turned
    with pytest.raises(InputError, match=r"this plan moves tilt, turn, and programs in .* move the arm only"):
        controller_named(name).write(program)
    still = tuple(dataclasses.replace(m, external=np.full((len(m), 2), 0.5)) for m in program.planned.air)
    standing = dataclasses.replace(program, planned=dataclasses.replace(program.planned, air=still))
    text = " ".join("".join(controller_named(name).write(standing).values()).split())
    assert "does not move tilt, turn: bring before tilt at 28.6479 deg, turn at 28.6479 deg" in text


def test_as_refuses_a_rail_and_coordinated_moves_in_one_line(turned):
    _cell, program = turned
    for change, says in (({"rail": "track"}, "move with a rail"), ({"follows": True}, "turns along a seam")):
        planned = dataclasses.replace(program.planned, **change)
        with pytest.raises(InputError, match=says):
            controller_named("as").write(dataclasses.replace(program, planned=planned))
