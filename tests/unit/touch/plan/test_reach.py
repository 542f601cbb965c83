"""A plan with an arm: its joints give the searches, one branch along each, and its ways keep away from everything."""

import json
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np
import pytest

from cad.cli.touches import ArmAsked
from tests.one_robot_cells import TEE, fixed_cell
from tests.touch_parts import touch_part
from tests.unit.conftest import box_mesh
from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh import PartMesh
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.controllers.program.touch_program import TouchProgram
from wpcal.controllers.registry import controller_named
from wpcal.core.errors import ErrorCode, GeometryError
from wpcal.core.records import to_json
from wpcal.core.same_bits import poses
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.new_cell import bare_cell
from wpcal.robot.identify.poses_file import parse_tool
from wpcal.robot.torch.shape import USUAL_TORCH
from wpcal.touch.plan import TouchOptions, plan_touches
from wpcal.touch.plan.displaced import DisplacedPart
from wpcal.touch.plan.options import NominalError
from wpcal.touch.plan.order import Air
from wpcal.touch.plan.reach import MOST_TURN_RAD, ArmReach
from wpcal.touch.searches import plan_from_record, touches_record

PLACE_MM = 1e-6
STATES = 40  #: States on each move in the air that are measured again.


@pytest.fixture(scope="module")
def reach() -> ArmReach:
    """Return the mh6 with the tee in front of it."""
    material = TriangleMaterial.of(read_part_glb((TEE / "part.glb").read_bytes()))
    return ArmReach.of(fixed_cell((700.0, -100.0, 150.0)), None, material)


def test_joints_are_those_of_the_searches_and_every_move_is_free(reach: ArmReach, golden: Any) -> None:
    cell = reach.cell
    options = TouchOptions(up_base=reach.up_base, post_base=(500.0, 300.0, 300.0))
    plan = plan_touches(
        replace(touch_part("tee"), material=reach.clearance.part),
        options=options,
        T_base_part=reach.T_base_part,
        reach=reach,
    )
    assert [search.name for search in plan.searches] == ["POST", *(f"T{k}" for k in range(1, 9))]
    assert plan.robot == cell.arm.name
    assert plan.home_joints is not None
    before = plan.home_joints
    for search in plan.searches:
        assert search.via_joints is not None
        T = cell.arm.forward(search.joints) @ cell.T_flange_tool.matrix
        places = plan.T_base_part.apply(np.stack([search.approach, search.start, search.end]))
        np.testing.assert_allclose(T[:, :3, 3], places, rtol=0, atol=PLACE_MM)
        np.testing.assert_allclose(T[0, :3, :3], plan.T_base_part.rotate(search.R_part_tool.T).T, rtol=0, atol=1e-9)
        assert np.abs(np.diff(search.joints, axis=0)).max() <= MOST_TURN_RAD
        assert cell.arm.within_limits(search.joints).all()
        via = (
            cell.arm.forward(search.via_joints) @ cell.T_flange_tool.matrix if len(search.via) else np.empty((0, 4, 4))
        )
        np.testing.assert_allclose(via[:, :3, 3], plan.T_base_part.apply(search.via), rtol=0, atol=PLACE_MM)
        way = np.concatenate([before[None], search.via_joints, search.joints[:1]])
        share = np.linspace(0.0, 1.0, STATES)[:, None]
        states = np.concatenate([a + share * (b - a) for a, b in pairwise(way)])
        assert reach.clearance.margins(states).is_clear.all()
        before = search.joints[0]
    kept = plan_from_record(json.loads(to_json(touches_record(plan))))  # with its arm, whose file may not be there
    texts = controller_named("rapid").write_touches(TouchProgram(kept, arm=kept.arm))
    assert any("confdata is computed" in text for text in texts.values())
    golden(plan)


def test_a_part_out_of_reach_is_one_line(reach: ArmReach) -> None:
    far = RigidTransform(np.eye(3), [4000.0, 0.0, 200.0], "base", "part")
    away = ArmReach.of(reach.cell, far, None)
    with pytest.raises(GeometryError, match=r"reaches no start of a search, such as .* out of reach") as caught:
        plan_touches(touch_part("tee"), options=TouchOptions(), T_base_part=away.T_base_part, reach=away)
    assert caught.value.code is ErrorCode.JOINT_PATH


def test_an_arm_alone_has_no_floor() -> None:
    tool = RigidTransform(np.eye(3), [0.0, 0.0, 350.0], "flange", "tool")
    cell = bare_cell("mh6", tool, USUAL_TORCH)
    assert cell.floor_z_mm < -1e4
    assert cell.torch


def test_the_tool_of_an_arm_is_the_tool_centre_point_and_its_tip_makes_the_searches(golden: Any) -> None:
    place = RigidTransform(np.eye(3), [700.0, -100.0, 150.0], "base", "part")
    cell = ArmAsked(arm="mh6", tool="0,0,350,0,30,0").to_cell(USUAL_TORCH, is_placed=True, standoff_mm=15.0)
    options = TouchOptions(standoff_mm=15.0)
    reach = ArmReach.of(cell, place, None)
    plan = plan_touches(touch_part("tee"), options=options, T_base_part=place, reach=reach)
    T_tool = parse_tool("0,0,350,0,30,0")[0].matrix
    for search in plan.searches:
        assert search.joints is not None
        T = cell.arm.forward(search.joints) @ T_tool
        tips = place.apply(np.stack([search.approach, search.start, search.end]))
        np.testing.assert_allclose(T[:, :3, 3] + 15.0 * T[:, :3, 2], tips, rtol=0, atol=PLACE_MM)
    golden(plan)


def test_a_way_to_a_search_is_free_in_lines_too_as_programs_write_it(
    reach: ArmReach, monkeypatch: pytest.MonkeyPatch
) -> None:
    """On the way of the joints the torch lies under a plate; with the axes of the search it stands in the plate."""
    plate = TriangleMaterial.of(PartMesh((box_mesh("plate", (-90, -90, 60), (90, 90, 70)),), 0.01, 0.5))
    part = DisplacedPart.of(plate, np.zeros(3), NominalError(sigma_mm=0.1, sigma_rad=1e-3))
    air, down = Air([plate], USUAL_TORCH, 1.2, np.eye(3)[2], 100.0, 3.0, part), np.array([np.pi, 0.0, 0.0])
    monkeypatch.setattr(ArmReach, "_tools", lambda _, q: poses(exp_rotation(q[:, 3:] - down), q[:, :3]))
    far, under = [0.0, -700.0, 0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, np.pi / 2, 0.0, 0.0]
    assert not reach._passes(air, np.array([far, under, far]))
    monkeypatch.setattr(DisplacedPart, "lets_pass", lambda *_: True)
    assert reach._passes(air, np.array([far, under, far]))
