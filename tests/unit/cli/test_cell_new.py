"""`wpcal cell new` of an arm whose third joint is shown against the horizontal, and its FANUC program."""

import itertools
import json
import shutil
from dataclasses import asdict

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from tests.one_robot_cells import TEE
from tests.record_checks import check_record
from tests.running import run_here
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.cell_file import read_one_robot
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.robot.kinematics.arm_file import find_arm
from wpcal.robot.torch.file import find_torch, without_none

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
    shutil.copytree(TEE, tmp_path / "tee")
    coupled, _ = new_cell(urdf, "--coupled", "joint_3:joint_2")
    asked = ("plan", coupled, tmp_path / "tee", "--only", "W2", "-f", "fanuc", "-o", tmp_path / "plan")
    done = run_here(*asked)
    assert (tmp_path / "plan" / "fanuc" / "W2.ls").exists(), done.stderr
    assert done.returncode == 0
    new_cell(urdf, "--force")
    done = run_here(*asked, "--force")
    assert done.returncode == 2
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


def made(urdf, *more):
    """Return the cell with the arm of the tests, which has no bodies, and what was said."""
    cell, done = new_cell(urdf, "--force", *more)
    assert done.returncode == 0, done.stderr
    record = json.loads(cell.read_text(encoding="utf-8"))
    check_record(record)
    return record, read_one_robot(cell), done


def swept(path, points, radius, sides=24):
    """Write an STL file (binary) of a tube along points, in the frame of the flange."""
    points, turn = np.asarray(points, dtype=float), 2 * np.pi * np.arange(sides) / sides
    rings = []
    for row, p in enumerate(points):
        way = points[min(row + 1, len(points) - 1)] - points[max(row - 1, 0)]
        side = np.cross(way, [0.0, 1.0, 0.0])
        u = side / np.linalg.norm(side)
        v = np.cross(way / np.linalg.norm(way), u)
        rings.append(p + radius * (np.outer(np.cos(turn), u) + np.outer(np.sin(turn), v)))
    triangles = []
    for a, b in itertools.pairwise(rings):
        for i, j in itertools.pairwise([*range(sides), 0]):
            triangles += [(a[i], b[i], b[j]), (a[i], b[j], a[j])]
    for ring, end in ((rings[0], points[0]), (rings[-1], points[-1])):
        triangles += [(end, ring[i], ring[j]) for i, j in itertools.pairwise([*range(sides), 0])]
    rows = np.zeros(len(triangles), dtype=[("n", "<f4", 3), ("v", "<f4", (3, 3)), ("a", "<u2")])
    rows["v"] = np.array(triangles)
    path.write_bytes(b"\0" * 80 + np.uint32(len(rows)).tobytes() + rows.tobytes())
    return path, np.array(triangles)


def test_a_named_torch_gives_its_bodies_and_is_kept(urdf):
    """The neck of robot-45 leads to the flange: its centre line is the one of the torch file, turned to it."""
    record, cell, _ = made(urdf, "--torch", "robot-45", "--tool", "120,0,300,0,45,0")
    shape = find_torch("robot-45")
    assert cell.torch_shape == shape
    assert record["torch_robot"]["torch_shape"]["neck"]["angle_deg"] == 45.0
    bodies = {each["name"]: each for each in record["torch_robot"]["torch"]}
    assert bodies["nozzle"]["to_part_mm"] == 3.0
    tube = shape.tubes[-1]  # the body: mouth at -wire, z back along the wire, x towards the flange
    last = bodies[f"torch {len(shape.tubes)}"]["capsules"][0]
    flange = cell.T_flange_tool.inverse().t_mm
    side = flange * [1, 1, 0] / np.linalg.norm(flange[:2])
    way = (tube.end - tube.start) / np.linalg.norm(
        tube.end - tube.start
    )  # its front is a prism, as long as it is thick
    for own, p in ((last["p_mm"], tube.start + tube.radius_mm * way), (last["q_mm"], tube.end)):
        assert np.allclose(own, p[0] * side + np.array([0, 0, -shape.wire_mm - p[2]]), rtol=0, atol=0.02)
    assert last["radius_mm"] == tube.radius_mm


def test_a_mesh_of_a_torch_becomes_hulls_that_hold_it_and_little_more(urdf, tmp_path):
    """A bent tube from the flange to the nozzle, as a user draws it: in the frame of the flange."""
    tool = RigidTransform.from_six_tuple([120.0, 0.0, 300.0, 0.0, np.radians(45), 0.0], target="flange", source="tool")
    wire = tool.R[:, 2]
    nozzle = tool.t_mm - 20.0 * wire
    bend = tool.t_mm - 130.0 * wire
    path, corners = swept(tmp_path / "gun.stl", [[0, 0, 0], [0.0, 0.0, 100.0], bend, nozzle], 12.0)
    record, cell, done = made(urdf, "--torch-mesh", path, "--tool", "120,0,300,0,45,0")
    assert "of the wire" not in done.stderr
    hulls = [ConvexHull(each["hull_mm"]) for each in record["torch_robot"]["torch"]]
    points = cell.T_flange_tool.inverse().apply(corners.reshape(-1, 3))
    off = np.array([(h.equations[:, :3] @ points.T + h.equations[:, 3:]).max(axis=0) for h in hulls]).min(axis=0)
    assert off.max() < 0.5  # every corner is in a hull, within the distance of samples
    volume = sum(np.abs(np.linalg.det(corners - corners.reshape(-1, 3).mean(axis=0))) / 6)
    assert sum(h.volume for h in hulls) < 1.6 * volume + 6e4  # slices overlap by 3 mm


@pytest.mark.parametrize(
    ("more", "says"),
    [
        (("--torch-mesh", "small.stl"), "it is probably in metres"),
        (("--torch", "robot-99"), "no shipped torch"),
        (("--torch", "robot-45", "--wire-mm", "12"), "robot-45 has its own sizes"),
        (("--torch-capsule", "0,0,0,0,0,200"), "expected 7 numbers"),
        (("--torch-capsule", "0,0,0,0,0,200,-5"), "a positive radius"),
        (("--torch-mesh", "small.stl", "--torch-capsule", "0,0,0,0,0,200,5"), "either"),
    ],
)
def test_a_torch_that_cannot_be_is_one_line(urdf, tmp_path, monkeypatch, more, says):
    monkeypatch.chdir(tmp_path)
    swept(tmp_path / "small.stl", [[0, 0, 0], [0, 0, 0.1], [0.05, 0, 0.3]], 0.02)
    _, done = new_cell(urdf, *more)
    assert done.returncode == 2
    assert says in done.stderr
    assert len(done.stderr.strip().splitlines()) == 1


@pytest.mark.parametrize(
    ("capsule", "says"),
    [("0,0,0,0,0,150,30", "begin 170 mm from the tip"), ("0,0,0,0,0,345,12", "7 mm inside torch 1")],
)
def test_a_torch_in_the_wrong_place_is_said(urdf, capsule, says):
    _, _, done = made(urdf, "--torch-capsule", capsule, "--tool", "0,0,350,0,0,0")
    assert says in done.stderr


def test_a_plan_with_another_torch_than_that_of_the_seams_says_so(urdf, tmp_path):
    cell, _ = new_cell(urdf, "--torch", "robot-22")
    shutil.copytree(TEE, tmp_path / "tee")
    seams = json.loads((tmp_path / "tee" / "seams.json").read_text())
    for name, other in (("robot-22", False), ("robot-45", True), (None, False)):
        seams.pop("torch", None)
        if name is not None:
            seams["torch"] = without_none(asdict(find_torch(name)))
        (tmp_path / "tee" / "seams.json").write_text(json.dumps(seams))
        given = read_sequence_input(tmp_path / "tee", read_one_robot(cell))
        said = given.other_torch(read_one_robot(cell))
        assert (said is not None) is other
        assert said is None or said.startswith("the seams were felt with robot-45")


def test_home_is_free_of_the_boxes(urdf):
    """A box where the torch would be at home: the arm goes elsewhere. Shut in, one line says that none is free."""
    _, open_cell, _ = made(urdf)
    tip = (open_cell.tool_places(open_cell.home[None])[0])[:3, 3]
    corners = ",".join(f"{v:.0f}" for v in [*(tip - 60), *(tip + 60)])
    _, cell, done = made(urdf, f"--box={corners}")
    assert "home" not in done.stderr
    assert CellClearance(cell, None).margins(cell.home[None]).is_clear[0]
    assert not CellClearance(cell, None).margins(open_cell.home[None]).is_clear[0]
    _, cell, done = made(urdf, "--box=-3000,-3000,0,3000,3000,3000")
    assert "no free home was found: home is in collision" in done.stderr
