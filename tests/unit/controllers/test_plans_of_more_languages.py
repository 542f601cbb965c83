"""Plans of one robot in every language, read by `tests.program_text` and checked by forward kinematics."""

import dataclasses
import re

import numpy as np
import pytest

from tests.one_robot_cells import TEE, TEE_ON_TABLE, fixed_cell, with_positioner, write_cell
from tests.program_text import READERS, as_values
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

WRITTEN_MM = 2e-3, 2e-2  #: Angles with six decimals move a point at 2 m by less, and those of joints with four.
WRITTEN = 1e-6, 1e-5  #: Of entries of rotations.
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


@pytest.mark.parametrize("name", ["rapid", "krl", "inform", "urscript", "val3", "as"])
def test_a_plan_goes_to_its_joints_between_seams_and_to_its_poses_along_them(fixed, turned, name):
    """From home to home; the joints before a seam are those of its approach, by forward kinematics."""
    cell, program = turned if name == "as" else fixed
    main, *_ = READERS[name](written(program, name)).steps()
    air = [step.joints for step in main if step.kind == "J"]
    ways = program.planned.air
    np.testing.assert_allclose(np.radians(air), np.concatenate([way.joints for way in ways]), rtol=0, atol=1e-6)
    np.testing.assert_allclose(np.radians([air[0], air[-1]]), [cell.home[:6]] * 2, rtol=0, atol=1e-6)
    kinds = "".join(
        "J" * len(way) + "L" * (len(path) - path.before) for way, path in zip(ways, program.paths, strict=False)
    )
    assert "".join(step.kind for step in main) == kinds + "J" * len(ways[-1])
    before = tips(cell, np.array([way.joints[-1] for way in ways[:-1]]))
    along = [tips(cell, np.radians(s.joints)[None])[0] if s.goal is None else s.goal for s in main if s.kind != "J"]
    found, planned = [*before, *along], [(path.p_base[0], path.R_base[0]) for path in program.paths]
    planned += [pose for path in program.paths for pose in [*zip(path.p_base, path.R_base, strict=True)][path.before :]]
    for T, (p, R) in zip(found, planned, strict=True):
        np.testing.assert_allclose(T[:3, 3], p, rtol=0, atol=WRITTEN_MM[name == "inform"])
        np.testing.assert_allclose(T[:3, :3], R, rtol=0, atol=WRITTEN[name == "inform"])


def test_speeds_of_joint_moves_are_those_of_the_plan(fixed):
    cell, program = fixed
    (text,) = written(program, "urscript").values()
    speeds = {float(v) for v in re.findall(r"movej\(\[[^\]]*\], a=[\d.]+, v=([\d.]+)\)", text)}
    allowed = 0.5 * min(joint.speed_rad_s for joint in cell.arm.joints)
    assert max(speeds) <= allowed * 1.001
    assert text.index("RUN IT DRY") < text.index("movej")
    files = written(program, "val3")
    assert re.findall(r"movej\(jPlan\[\d+\],tTorch,(\w+)\)", files["start.pgx"]) == ["mJoint"] * text.count("movej(")
    assert re.search(r'name="mJoint".*?vel="50".*?blend="off"', files["WPCAL.dtx"], re.S)


def test_as_states_the_axes_of_a_positioner_behind_those_of_the_arm(turned):
    _, program = turned
    (text,) = written(program, "as").values()
    axes, points = as_values(text, "JOINTS"), as_values(text)
    assert sorted(re.findall(r"JMOVE (\S+)\r", text)) == sorted(axes)
    external = np.radians([row[6:] for row in axes.values()])
    np.testing.assert_allclose(external, np.concatenate([m.external for m in program.planned.legs]), rtol=0, atol=1e-7)
    assert np.allclose(points.pop("wp_part"), 0.0, rtol=0, atol=1e-9)  # the points are in the base of the robot
    for path in program.paths:
        own = np.array([row for name, row in points.items() if name.startswith(f"{path.seam.name}_")])
        np.testing.assert_allclose(np.radians(own[:, 6:]), path.external[path.before :], rtol=0, atol=1e-7)
    main, *seams = text.split(".PROGRAM ")[1:]
    assert [part.count("JMOVE") for part in seams if not part.startswith("only_")] == [1] * len(program.paths)
    assert "JT7 = tilt, JT8 = turn" in main


def test_with_the_arc_on_all_three_start_and_end_it(fixed):
    _cell, program = fixed
    program = dataclasses.replace(program, arc=ArcSettings(output=0))
    for name, on in (("urscript", "set_standard_digital_out(0, True)"), ("val3", "doArc=true")):
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
