"""Plans of arms without a spherical wrist, and cells of arms without meshes."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.few import few
from tests.one_robot_cells import TEE
from tests.samples.offset_wrists import crx10ia, ur10e
from wpcal.core.records import to_json
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell_file import read_one_robot
from wpcal.planning.cell.new_cell import NewCell, new_cell_files
from wpcal.planning.sequence.plan_sequence import plan_sequence
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.robot.kinematics.arm_file import arm_record
from wpcal.robot.torch.file import find_torch

pytest.importorskip("fcl", reason="python-fcl is not installed")
ON_SEAM_MM, STEP_RAD = 1e-6, np.radians(20.0)


def cell_of(robot, folder, place):
    tool = RigidTransform.from_matrix(np.eye(4), target="flange", source="tool")
    new = NewCell(
        robot=str(robot),
        T_world_base=RigidTransform(np.eye(3), np.array([0.0, 0.0, 245.0]), "world", "base"),
        T_flange_tool=RigidTransform(tool.R, np.array([0.0, 0.0, 350.0]), "flange", "tool"),
        torch=find_torch("straight"),
        T_carrier_part=RigidTransform(np.eye(3), np.array(place), "world", "part"),
    )
    for name, record in new_cell_files(new, "cell.json").items():
        (folder / name).write_text(to_json(record), encoding="utf-8")
    return read_one_robot(folder / "cell.json")


@pytest.mark.parametrize(
    ("arm", "names"), few([(crx10ia(), ["W2"]), (ur10e(), ["W2", "W3"])], 1), ids=["crx10ia", "ur10e"]
)
def test_a_seam_is_welded_in_one_configuration_with_the_wire_on_it(tmp_path, arm, names):
    robot = tmp_path / "arm.json"
    robot.write_text(to_json(arm_record(arm)), encoding="utf-8")
    cell = cell_of(robot, tmp_path, (500.0, -100.0, 150.0))
    given = replace(read_sequence_input(TEE, cell, names), T_base_part=None)
    plan = plan_sequence(given.placed(cell), given.part, given.seams, SequenceTargets()).sequence
    assert plan.is_free
    assert not plan.unwelded
    for piece in plan.pieces:
        task, q = piece.candidate.task, piece.candidate.q
        tip = np.linalg.inv(plan.cell.part_places(q)) @ plan.cell.tool_places(q)
        assert np.abs(tip[:, :3, 3] - task.p).max() < ON_SEAM_MM
        assert np.abs(np.diff(q, axis=0)).max() < STEP_RAD
    assert plan.open_points(has_part=True)[0].startswith("NOT CHECKED: the true shape of the arm")


def test_a_shipped_arm_without_meshes_has_bodies_that_hold_its_joints(tmp_path):
    cell = cell_of("mh6", tmp_path, (800.0, 0.0, 200.0))
    assert {shape.link for shape in cell.links} >= {1, 2, 3, 4, 6}
    record = json.loads((tmp_path / "cell.json").read_text(encoding="utf-8"))
    assert "estimated from its lengths" in record["source"]
    q = np.random.default_rng(0).uniform(*cell.limits, (20, 6))
    frames = cell.frames(q)
    ends = {}
    for shape in cell.links:
        for point in (*shape.p, *shape.q):
            ends.setdefault(shape.link, []).append(frames[shape.link].point(point).T)
    for link in (3, 4):  # the bodies of neighbours meet at the joint between them
        gaps = [np.linalg.norm(a - b, axis=1).max() for a in ends[link - 1] for b in ends[link]]
        assert min(gaps) < ON_SEAM_MM
