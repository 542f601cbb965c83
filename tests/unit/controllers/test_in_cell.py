"""A planned program is swept in its cell: moves of the text that meet something are named, the wire included."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.one_robot_cells import TEE, fixed_cell
from wpcal.controllers.judge.execute import execute
from wpcal.controllers.judge.in_cell import CellSweep
from wpcal.controllers.program.planned_program import PlanOutput, build_planned_program
from wpcal.controllers.registry import controller_named
from wpcal.planning.sequence.kept_plan import KeptPlan
from wpcal.planning.sequence.plan_sequence import plan_sequence
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.targets import SequenceTargets

pytest.importorskip("fcl", reason="python-fcl is not installed")
pytest.importorskip("ompl", reason="ompl is not installed")


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


def test_a_joint_move_to_the_seam_has_the_wire_on_the_part(swept):
    plan, sweep, motions = swept
    (piece,) = plan.pieces
    row = next(row for row, motion in enumerate(motions["rapid"]) if motion.kind != "J")
    to_seam = replace(motions["rapid"][row - 1], joints=np.degrees(piece.q[0, :6]))
    (meeting,) = sweep.meetings([*motions["rapid"][: row - 1], to_seam])
    assert "wire and part miss their safety distance" in meeting.what
    assert meeting.motion is to_seam


def test_a_line_through_the_part_is_named_with_the_bodies(swept):
    _, sweep, motions = swept
    row = next(row for row, motion in enumerate(motions["rapid"]) if motion.kind != "J")
    deeper = motions["rapid"][row].goal.copy()
    deeper[:3, 3] += 60.0 * deeper[:3, 2]
    (meeting, *_) = sweep.meetings([*motions["rapid"][:row], replace(motions["rapid"][row], goal=deeper)])
    assert "and part miss their safety distance" in meeting.what


def test_joints_beyond_a_limit_and_out_of_reach_are_named(swept):
    _, sweep, motions = swept
    first = motions["rapid"][0]
    (meeting,) = sweep.meetings([replace(first, joints=np.array([0.0, 0.0, 0.0, 0.0, 400.0, 0.0]))])
    assert meeting.what == "a joint is beyond its limits"
    far = np.eye(4)
    far[:3, 3] = 9000.0
    (meeting,) = sweep.meetings([first, replace(first, joints=None, goal=far)])
    assert "the arm does not get there" in meeting.what
