"""The tool turns as little as its wire must, within the range of its spin."""

import contextlib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from wpcal.controllers.program import build_program
from wpcal.controllers.program.reachable_spin import ArmAtTool, spun_programs
from wpcal.controllers.program.spin import least_turn, spun, swing_and_twist, unwinding_spin
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.tangent import exp_rotation, log_rotation
from wpcal.results.folder import read_finished
from wpcal.robot.identify.poses_file import parse_tool
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.robot.kinematics.inverse import nearest_joints
from wpcal.robot.torch.attitude import ToolAxis, TorchSettings, wire_directions

SADDLE = Path(__file__).parents[3] / "fixtures" / "saddle" / "golden"
ROUND_OFF = 1e-9


def total_turn(R):
    return float(np.linalg.norm(log_rotation(np.swapaxes(R[:-1], 1, 2) @ R[1:]), axis=1).sum())


def saddle(axis, range_deg):
    torch = TorchSettings(tool_axis=axis, spin_range_rad=np.radians(range_deg))
    return build_program(read_finished(SADDLE).select(), torch=torch).paths[0].R_base[1:-1]


@pytest.mark.parametrize("axis", ToolAxis)
def test_the_saddle_is_welded_without_turning_the_tool_about_its_wire(axis, golden):
    before, after = saddle(axis, 0), saddle(axis, 180)
    assert np.degrees(total_turn(before)) == pytest.approx(378, abs=2)
    swing = swing_and_twist(before, axis)[0].sum()
    assert total_turn(after) == pytest.approx(swing, abs=np.radians(1e-3))  # what the wire itself swings, and no more
    np.testing.assert_allclose(wire_directions(before, axis), wire_directions(after, axis), rtol=0, atol=ROUND_OFF)
    assert np.abs(unwinding_spin(before, axis, np.pi)).max() <= np.pi + ROUND_OFF
    golden(after)


@pytest.mark.parametrize("range_deg", [0, 20, 60, 90])
def test_a_small_range_is_kept_and_the_turn_falls_with_it(range_deg):
    before = saddle(ToolAxis.Z, 0)
    spin = unwinding_spin(before, ToolAxis.Z, np.radians(range_deg))
    assert np.degrees(np.abs(spin).max()) <= range_deg + 1e-6
    turn = total_turn(spun(before, spin, ToolAxis.Z))
    assert total_turn(saddle(ToolAxis.Z, 180)) - ROUND_OFF <= turn <= total_turn(before) + ROUND_OFF


def test_a_straight_seam_keeps_the_direction_of_travel():
    R = np.repeat(exp_rotation(np.array([0.3, -1.0, 0.2]))[None], 9, axis=0)
    np.testing.assert_allclose(unwinding_spin(R, ToolAxis.Z, np.pi), 0.0, rtol=0, atol=ROUND_OFF)


@pytest.mark.parametrize("seed", range(10))
def test_no_choice_turns_less(seed):
    rng = np.random.default_rng(seed)
    swing, e = rng.uniform(0, 0.3, 4), rng.uniform(-1, 1, (5, 4))
    every = np.stack(np.meshgrid(*[np.arange(4)] * 5), axis=-1).reshape(-1, 5)
    cost = np.hypot(swing, np.diff(e[np.arange(5), every], axis=1)).sum(axis=1)
    chosen = least_turn(swing, e)
    turned = np.hypot(swing, np.diff(e[np.arange(5), chosen])).sum()
    assert turned <= cost.min() + 1e-2  # a start far from the travel costs 1e-3


def test_a_range_beyond_half_a_turn_is_refused():
    with pytest.raises(InputError, match="turn about the wire: expected 0 to 180 deg"):
        TorchSettings(spin_range_rad=4.0)


def joint_6_limits(program, arm, tool):
    T = np.tile(np.eye(4), (len(program.paths[0]), 1, 1))
    T[:, :3, :3], T[:, :3, 3] = program.paths[0].R_base, program.paths[0].p_base
    return nearest_joints(arm, T @ tool.inverse().matrix, np.zeros(6))


def test_the_arm_keeps_its_limits_where_another_turn_about_the_wire_does():
    arm, tool = find_arm("irb1600_8_145"), parse_tool("20,0,350,0,30,0")[0]
    program = build_program(read_finished(SADDLE).select())
    found = 0
    for centre_deg in range(-150, 180, 30):
        low, high = np.radians([centre_deg - 100, centre_deg + 100])
        tight = replace(arm, joints=(*arm.joints[:5], replace(arm.joints[5], min_rad=low, max_rad=high)))
        try:
            kept = next(spun_programs(program, ArmAtTool(tight, tool, np.zeros(6)))).program
        except GeometryError:
            continue
        wires = [wire_directions(each.paths[0].R_base, ToolAxis.Z) for each in (program, kept)]
        np.testing.assert_allclose(*wires, rtol=0, atol=ROUND_OFF)
        q = joint_6_limits(kept, tight, tool)  # raises if a pose breaks a limit
        assert ((q[:, 5] >= low) & (q[:, 5] <= high)).all()
        with contextlib.suppress(GeometryError):
            joint_6_limits(program, tight, tool)
            continue
        found += 1  # without the choice a limit was broken
    assert found >= 1


def test_an_open_seam_begins_and_ends_at_its_own_poses(golden):
    arm, tool = find_arm("irb1600_8_145"), parse_tool("20,0,350,0,30,0")[0]
    finished = read_finished(SADDLE).select()
    (seam,) = finished.seams
    f, n = seam.frames, len(seam.frames) // 3
    part = replace(
        seam, closed=False, frames=replace(f, s_mm=f.s_mm[:n], p=f.p[:n], R=f.R[:n], angle_rad=f.angle_rad[:n])
    )
    program = build_program(replace(finished, seams=(replace(part, lean_rad=None, spin_rad=None),)))
    golden(next(spun_programs(program, ArmAtTool(arm, tool, np.zeros(6)))).program.paths)


def test_a_seam_that_no_turn_brings_within_the_limits_is_named():
    arm, tool = find_arm("irb1600_8_145"), parse_tool("20,0,350,0,30,0")[0]
    tight = replace(arm, joints=(replace(arm.joints[0], min_rad=1.5, max_rad=1.6), *arm.joints[1:]))
    with pytest.raises(
        GeometryError, match=r"seam W1: point 0, 0\.0 mm along it, base .* mm: no turn .* joint 1 is beyond its limit"
    ):
        next(spun_programs(build_program(read_finished(SADDLE).select()), ArmAtTool(tight, tool, np.zeros(6))))
