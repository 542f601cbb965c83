"""The tool centre point: found from exact data, its interval holds, and it mends an arm with an unknown tool."""

import json

import numpy as np
import pytest

from tests.simulated_poses import random_joints
from wpcal.cli.main import run
from wpcal.core.errors import FormatError, GeometryError
from wpcal.core.records import to_json
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform
from wpcal.robot.compensation import correct_points
from wpcal.robot.identify.identification import IdentifyOptions, identify_arm
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.parameters import KinematicModel, link_parameters
from wpcal.robot.identify.poses_file import parse_tool
from wpcal.robot.kinematics.arm_file import arm_record, find_arm, read_arm
from wpcal.robot.kinematics.inverse import solve_inverse, turn_into_limits
from wpcal.robot.tool_point import find_tool_point

MH6 = find_arm("mh6")
TIP = np.array([20.0, -35.0, 310.0])
EXACT_MM = 1e-9  # round-off of an arm two metres long
SPOT = np.array([900.0, 150.0, 350.0])


def touches(arm, count, rng, tip=TIP):
    """Joint angles at which an arm holds its tip at one place, the tool tilted at random; about 30 degrees."""
    found = []
    while len(found) < count:
        R = exp_rotation(rng.normal(0.0, 0.5, 3)) @ np.diag([1.0, -1.0, -1.0])
        T = np.eye(4)
        T[:3, :3], T[:3, 3] = R, SPOT - R @ tip
        q = turn_into_limits(arm, solve_inverse(arm, T[None]).joints[0], np.zeros(6))
        usable = np.isfinite(q).all(axis=1)
        if usable.any():
            found.append(q[usable][0])
    return np.array(found)


def bent_arm(rng):
    errors = [rng.normal(0.0, 1.0 if p.is_length else np.deg2rad(0.15)) for p in link_parameters(MH6.chain)]
    chain = KinematicModel(MH6.chain).moved(link_parameters(MH6.chain), errors).chain
    return MH6.as_identified(chain)


def test_exact_touches_give_the_tip_and_the_point():
    found = find_tool_point(MH6, touches(MH6, 5, np.random.default_rng(0)))
    np.testing.assert_allclose(found.t_flange, TIP, rtol=0, atol=EXACT_MM)
    np.testing.assert_allclose(found.p_base, SPOT, rtol=0, atol=EXACT_MM)
    assert found.error_95_mm < EXACT_MM * 10
    assert (
        "mm (RMS) from one point" in find_tool_point(MH6, random_joints(MH6, 6, rng=np.random.default_rng(3))).refusal
    )


def test_the_interval_holds_the_error(golden):
    """Tips that stop 0.1 mm beside the point, per axis: the stated length covers it in 95 of 100 along one axis."""
    rng, sigma, inside, trials = np.random.default_rng(1), 0.1, 0, 100
    for _ in range(trials):
        q = touches(MH6, 6, rng)
        near = q + [rng.normal(0.0, 1.0, 6) * 1e-4 for _ in q]  # joints a little off: about 0.1 mm at the tip
        found = find_tool_point(MH6, near)
        worst = np.linalg.eigh(found.covariance)[1][:, -1]
        inside += abs(worst @ (found.t_flange - TIP)) <= found.error_95_mm
        assert found.rms_mm < 10 * sigma
    assert 0.87 <= inside / trials <= 1.0  # 95 ± 3 sigma of 100 trials, below
    golden([found, found.to_record(MH6, "abcdef")])


def test_postures_about_one_axis_or_too_few_are_refused():
    q = touches(MH6, 4, np.random.default_rng(2))
    spun = np.repeat(q[:1], 5, axis=0)
    spun[:, 5] += np.radians([0, 20, 40, 60, 80])
    with pytest.raises(GeometryError, match="about one axis"):
        find_tool_point(MH6, spun)
    with pytest.raises(GeometryError, match="3 touches"):
        find_tool_point(MH6, q[:3])


def test_with_an_unknown_tool_the_point_has_to_be_found_in_the_identified_arm(tmp_path):
    """Positions of one reflector, base and tool unknown: the last link stays nominal (finding D1)."""
    rng = np.random.default_rng(4)
    real, q = bent_arm(rng), random_joints(MH6, 70, rng=rng)
    T = real.forward(q)
    seen = (T[:, :3, :3] @ [60.0, 10.0, 90.0] + T[:, :3, 3]) @ exp_rotation([0.1, 0.2, 1.0]).T + [3000, -500, 200]
    seen += rng.normal(0.0, 0.03, seen.shape)
    found = identify_arm(MH6, PoseObservations(q, seen), options=IdentifyOptions(free_base=True, free_tool=True)).arm
    assert found.unseen_tool_mm > 1.0
    assert read_back(found, tmp_path).unseen_tool_mm == found.unseen_tool_mm

    tip = find_tool_point(found, touches(real, 8, rng))
    checked = touches(real, 20, rng, tip=TIP)
    base = np.linalg.norm(apart(found, checked, tip.t_flange), axis=1)
    stated = np.linalg.norm(apart(found, checked, TIP), axis=1)
    assert base.max() < 0.2
    assert stated.max() > 3 * base.max()


def apart(arm, joints, tip):
    """Differences of the corrected points, all of one place, from their mean: what a wrong tip cannot hide."""
    tool = RigidTransform(np.eye(3), tip, "flange", "tool")
    points = correct_points(arm, joints, T_flange_tool=tool)
    return points - points.mean(axis=0)


def read_back(arm, folder):
    path = folder / "arm.json"
    path.write_text(to_json(arm_record(arm)), encoding="utf-8")
    return read_arm(path)


def wpcal(capsys, *words):
    with pytest.raises(SystemExit) as ended:
        run([str(word) for word in words])
    return ended.value.code, *capsys.readouterr()


def test_the_command_writes_the_file_that_correct_takes(tmp_path, capsys):
    q = np.rad2deg(touches(MH6, 5, np.random.default_rng(0)))
    header = "name," + ",".join(f"q{i + 1}_deg" for i in range(6))
    rows = [f"P{i}," + ",".join(f"{angle:.9f}" for angle in row) for i, row in enumerate(q)]
    table = tmp_path / "touches.csv"
    table.write_text("\n".join([header, *rows]) + "\n", encoding="utf-8")
    tool = tmp_path / "tool.json"
    code, out, _ = wpcal(capsys, "tcp", table, "--robot", "mh6", "-o", tool)
    assert code == 0
    assert "20.000,-35.000,310.000" in out
    assert json.loads(tool.read_text())["schema"] == "wpcal/tool/1"
    code, out, err = wpcal(capsys, "correct", table, "--robot", "mh6", "--tool", tool)
    assert code == 0, err
    points = np.array([[float(cell) for cell in line.split(",")[1:4]] for line in out.splitlines()[1:]])
    np.testing.assert_allclose(points, np.tile(SPOT, (5, 1)), rtol=0, atol=1e-5)  # the table holds 1e-6 mm
    assert wpcal(capsys, "tcp", table, "--robot", "mh6", "-o", tool)[0] == 2
    table.write_text("\n".join([header, *rows[:-1], "P4,10,20,-30,20,40,50"]) + "\n", encoding="utf-8")
    code, _, err = wpcal(capsys, "tcp", table, "--robot", "mh6")
    assert (code, err.count("\n"), "no tool centre point" in err) == (1, 1, True)


def test_a_broken_tool_file_is_refused(tmp_path):
    path = tmp_path / "tool.json"
    path.write_text('{"schema": "wpcal/tool/1", "xyz_mm": [1, 2], "error_95_mm": 0.1}', encoding="utf-8")
    with pytest.raises(FormatError, match="xyz_mm"):
        parse_tool(str(path))
