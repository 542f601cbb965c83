"""A planned program is swept in its cell: moves of the text that meet something are named, the wire included."""

from dataclasses import replace
from unittest import mock

import numpy as np
import pytest

from tests.few import few
from tests.one_robot_cells import TEE, TEE_ON_TABLE, fixed_cell, pipe_ring, with_positioner, write_cell
from tests.unit.controllers.judging import judged
from wpcal.controllers.judge.asked import asked_of, compare
from wpcal.controllers.judge.execute import execute
from wpcal.controllers.judge.in_cell import CellSweep, FreeWays
from wpcal.controllers.program.planned_program import PlanOutput, build_planned_program
from wpcal.controllers.registry import controller_named
from wpcal.core.errors import InputError
from wpcal.planning.cell.cell import Rail
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.cell_file import read_one_robot
from wpcal.planning.cell.shape import Shape
from wpcal.planning.sequence.kept_plan import KeptPlan
from wpcal.planning.sequence.motion_check import MotionChecker
from wpcal.planning.sequence.plan_sequence import plan_sequence
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.targets import SequenceTargets, WeldPosition
from wpcal.robot.kinematics.arm import Coupling

pytest.importorskip("fcl", reason="python-fcl is not installed")


@pytest.fixture(scope="module")
def swept():
    """A plan of one seam, what sweeps it, and the motions of its text."""
    cell = fixed_cell()
    given = read_sequence_input(TEE, cell, ["W2"])
    cell = given.placed(cell)
    plan = KeptPlan.of(plan_sequence(cell, given.part, given.seams, SequenceTargets()).sequence)
    program = build_planned_program(plan, {each.name: each for each in given.seams}, PlanOutput())
    motions = {}
    for name in ("rapid", "krl", "urscript"):
        motions[name] = execute(controller_named(name).write(program), tools=("tTorch", 1, "torch")).motions
    return plan, CellSweep(cell, given.part, np.zeros(0)), motions


@pytest.mark.parametrize("name", ["rapid", "krl", "urscript"])
def test_what_was_planned_is_free(swept, name):
    _, sweep, motions = swept
    assert [meeting.what for meeting in sweep.meetings(motions[name])] == []


def test_a_joint_move_to_the_seam_has_the_wire_on_the_part(swept, golden):
    plan, sweep, motions = swept
    (piece,) = plan.pieces
    row = next(row for row, motion in enumerate(motions["rapid"]) if motion.kind != "J")
    to_seam = replace(motions["rapid"][row - 1], joints=np.degrees(piece.q[0, :6]))
    (meeting,) = sweep.meetings([*motions["rapid"][: row - 1], to_seam])
    assert "wire and part miss their safety distance" in meeting.what
    assert meeting.motion is to_seam
    golden(meeting)


def test_a_line_through_the_part_is_named_with_the_bodies(swept, golden):
    _, sweep, motions = swept
    row = next(row for row, motion in enumerate(motions["rapid"]) if motion.kind != "J")
    deeper = motions["rapid"][row].goal.copy()
    deeper[:3, 3] += 60.0 * deeper[:3, 2]
    (meeting, *_) = sweep.meetings([*motions["rapid"][:row], replace(motions["rapid"][row], goal=deeper)])
    assert "and part miss their safety distance" in meeting.what
    golden(meeting)


def test_joints_beyond_a_limit_and_out_of_reach_are_named(swept, golden):
    _, sweep, motions = swept
    first = motions["rapid"][0]
    (meeting,) = sweep.meetings([replace(first, joints=np.array([0.0, 0.0, 0.0, 0.0, 400.0, 0.0]))])
    assert meeting.what == "a joint is beyond its limits"
    far = np.eye(4)
    far[:3, 3] = 9000.0
    (meeting,) = sweep.meetings([first, replace(first, joints=None, goal=far)])
    assert "the arm does not get there" in meeting.what
    golden(meeting)


def test_a_way_within_the_digits_of_a_free_one_is_not_measured_again_and_any_other_is(swept):
    plan, sweep, _ = swept
    checker = MotionChecker(sweep.cell, CellClearance(sweep.cell, sweep.part))
    ways, air, turned, hit = FreeWays(checker), plan.air[0], plan.air[0].copy(), plan.air[0].copy()
    turned[0, 5] += np.radians(1.0)
    hit[0, :3] = plan.pieces[0].q[0, :3] + [0.0, np.radians(20.0), 0.0]
    with mock.patch.object(checker, "check", wraps=checker.check) as check:
        free = [ways.is_free(q, np.zeros(len(q) - 1, dtype=bool)) for q in (air, air + 1e-9, turned, hit)]
    assert free == [True, True, True, False]
    assert [len(call.args[0]) for call in check.call_args_list] == [len(air), 2, 2]


TURNED_DEG = 70.0  #: Then the part is where the torch waits.
MOVING = ("rapid", "krl", "inform", "fanuc", "as")


def rail_cell():
    """The fixed part, the arm on a rail, and a wall at its end that no way of the plan comes near to."""
    wall = Shape(
        "wall", np.zeros((1, 3)), np.zeros((1, 3)), np.array([1.0]), hull=corners((-900, -2200, 0), (900, -2100, 2000))
    )
    cell = fixed_cell()
    rail = Rail(np.array([0.0, 1.0, 0.0]), -2500.0, 2500.0, 500.0)
    return replace(cell, rail=rail, bench=(wall,), home=np.append(cell.home, 200.0), touched_at=np.array([200.0]))


def corners(low, high):
    return np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T.astype(float)


@pytest.fixture(scope="module", params=["rail", "positioner", "ring"])
def moving(request, tmp_path_factory):
    """A plan whose external axes move, its seams, what sweeps it, and where an axis may be brought to collide."""
    if request.param == "rail":
        cell = rail_cell()
        given = read_sequence_input(TEE, cell, ["W2"])
        cell, part, seams = given.placed(cell), given.part, given.seams
    else:
        record = with_positioner(TEE_ON_TABLE if request.param == "positioner" else (0.0, 0.0, 10.0))
        cell = read_one_robot(write_cell(tmp_path_factory.mktemp("cell"), record))
        given = read_sequence_input(TEE, fixed_cell(), ["W2"])
        is_ring = request.param == "ring"
        part, seams = (None, (pipe_ring(given.seams[0]),)) if is_ring else (given.part, given.seams)
    targets = SequenceTargets(position=WeldPosition.PA) if request.param == "ring" else SequenceTargets()
    plan = KeptPlan.of(plan_sequence(cell, part, seams, targets).sequence)
    sweep = CellSweep.of(plan.cell, part, plan.air, [piece.q for piece in plan.pieces])
    assert sweep.has_moving_axes
    assert sweep.follows == (request.param == "ring")
    return request.param, plan, {each.name: each for each in seams}, sweep


def written_in(name, plan, seams):
    """The program of a plan and its motions; that of FANUC with the coupling that the mh6 does not have."""
    is_carried = controller_named(name).coordinates_arcs
    program = build_planned_program(plan, seams, PlanOutput(is_carried=is_carried))
    if name == "fanuc":
        names = [joint.name for joint in program.arm.joints]
        program = replace(program, arm=replace(program.arm, couplings=(Coupling(names[2], names[1], 0.0),)))
    files = controller_named(name).write(program)
    assert not judged(files, program, name).not_checked
    return program, execute(files, tools=("tTorch", 1, 0, "torch"))


@pytest.mark.parametrize("name", few(MOVING, 3))
def test_a_plan_with_moving_axes_is_free_and_a_turned_part_or_a_moved_arm_is_named(moving, name):
    """The text leads the arm on the rail into the wall, or turns the part into the torch that waits beside it."""
    kind, plan, seams, sweep = moving
    if name == "as" and kind != "positioner":
        with pytest.raises(InputError, match=r"move with a rail|turns along a seam"):
            written_in(name, plan, seams)
        return
    program, trace = written_in(name, plan, seams)
    sweep = replace(sweep, is_carried=program.planned.is_carried)
    assert [meeting.what for meeting in sweep.meetings(trace.motions)] == []
    air, states = [q.copy() for q in plan.air], plan.pieces[0].states.copy()
    turned_to = -2000.0 if kind == "rail" else TURNED_DEG
    if kind == "rail":
        air[-1][-1, 6] = turned_to
    else:
        air[0][-1, 6] = states[0, 6] = np.radians(turned_to)
    wrong = replace(plan, air=tuple(air), pieces=(replace(plan.pieces[0], states=states),))
    _, turned = written_in(name, wrong, seams)
    found = compare(turned, asked_of(program, alone=controller_named(name).welds_alone)).others
    assert {motion.place.external[0] for motion in found} == {turned_to}
    if kind != "ring":  # it has no body
        meeting, *_ = sweep.meetings(turned.motions)
        assert meeting.motion.place.line == found[0].place.line
        assert ("wall" if kind == "rail" else "and part miss their safety distance") in meeting.what
