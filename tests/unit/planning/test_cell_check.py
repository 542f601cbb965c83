"""Cells as files; what is odd in a cell is told, with numbers, and a cell without oddities is not accused."""

import json

import jsonschema
import numpy as np
import pytest

from tests.saddle import CELL, CELLS
from wpcal.core.errors import FormatError, InputError
from wpcal.core.records import to_json
from wpcal.core.schemas import schema_text
from wpcal.planning.cell.cell_check import cell_check_record, check_cell, mounts
from wpcal.planning.cell.cell_file import cell_from_record, read_cell
from wpcal.robot.kinematics.urdf_bodies import capsule_around

BOX = [[x, y, z] for x in (-80, 80) for y in (-80, 80) for z in (50, 650)]


@pytest.fixture
def record():
    return json.loads(CELL.read_text(encoding="utf-8"))


@pytest.fixture
def told():
    def check(record):
        return {issue.code: issue for issue in check_cell(cell_from_record(record, path=CELLS / "cell.json"))}

    return check


def link(robot, name):
    return next(body for body in robot["links"] if body["name"] == name)


def test_the_shipped_cell_has_no_oddity(record, told):
    assert told(record) == {}


@pytest.mark.parametrize(("arm", "below"), [("ar2010", 505), ("ma2010", 505), ("m10ia", 450)])
@pytest.mark.parametrize("robot", ["torch_robot", "holder_robot"])
def test_a_base_frame_at_axis_2_puts_the_mounting_face_below_the_floor(record, told, robot, arm, below):
    record[robot]["arm"] = arm
    message = told(record)["mounting-face"].message
    assert f"z = -{below} mm, {below} mm below the floor (z = 0 mm)" in message
    place = record[robot]["T_world_base"]["xyz_mm"]
    assert f"write xyz_mm [{place[0]}, 0, {below}] in T_world_base of {robot}" in message
    assert f'"mounting_face_z_mm": -{below} in {robot}' in message
    place[2] = below
    assert told(record) == {}


def capsule_of(corners):
    p, q, radius = capsule_around(corners)
    return {"p_mm": p.tolist(), "q_mm": q.tolist(), "radius_mm": radius}


def moved(body, axis, by_mm):
    for capsule in body["capsules"]:
        for key in ("p_mm", "q_mm"):
            capsule[key][axis] += by_mm


def in_metres(body):
    for capsule in body["capsules"]:
        capsule |= {key: (np.array(capsule[key]) / 1000).tolist() for key in capsule}


LOW = [[x, y, z] for x in (-100, 100) for y in (-100, 100) for z in (-500, 100)]
PLATE = {"name": "plate", "link": 6, "capsules": [{"p_mm": [-50, 0, 300], "q_mm": [50, 0, 300], "radius_mm": 20}]}
AR2010 = {"arm": "ar2010"}
ODD = {
    "a stated height": (lambda _, t, h: t.update(AR2010, mounting_face_z_mm=-505), ""),
    "another height": (
        lambda _, t, h: t.update(AR2010, mounting_face_z_mm=300),
        "805 mm below its stated height (z = 300",
    ),
    "a stated floor": (lambda r, t, h: (t.update(AR2010), h.update(AR2010), r.update(floor_z_mm=-505)), ""),
    "a riser": (lambda _, t, h: h["T_world_base"]["xyz_mm"].__setitem__(2, 400), "400 mm above the floor"),
    "a pedestal": (
        lambda _, t, h: link(t, "pedestal").update(hull_mm=LOW, capsules=[capsule_of(LOW)]),
        "robot 1 pedestal reaches down to z = -500 mm, 500 mm below the floor",
    ),
    "no torch": (lambda _, t, h: t.update(torch=[]), "the torch has no bodies"),
    "no links": (lambda _, t, h: t.update(links=[]), "robot 1 has no bodies"),
    "no links 2": (lambda _, t, h: h.update(links=[]), "robot 2 has no bodies"),
    "no part": (lambda _, t, h: h.update(part=[]), "the part has no bodies"),
    "no bench": (lambda r, t, h: r.update(bench=[]), "no floor, table or other fixed body"),
    "a plate": (lambda _, t, h: (h["T_flange_part"].update(xyz_mm=[0, 0, 400]), h["links"].append(PLATE)), ""),
    "metres": (lambda _, t, h: in_metres(link(h, "forearm")), "robot 2 forearm is 0."),
    "hull in metres": (
        lambda _, t, h: link(h, "forearm").update(hull_mm=(np.array(BOX) / 1000).tolist()),
        "like metres",
    ),
    "far": (lambda _, t, h: moved(link(t, "upper arm"), 1, 600.0), "505 mm away from link 2 of robot 1"),
    "torch": (lambda _, t, h: moved(t["torch"][2], 2, 700.0), "robot 1 torch body is"),
    "near": (lambda r, t, h: (h["T_world_base"].update(xyz_mm=[250, 0, 0]), r.update(bench=[])), "bases 250 mm apart"),
    "base": (lambda r, t, h: (h["T_world_base"].update(xyz_mm=[1.5, 0, 0]), r.update(bench=[])), "metres?"),
}
"""Changes of a cell, its torch robot and its holder, and what is told of it; nothing where that is right."""


@pytest.mark.parametrize("name", ODD)
def test_what_is_odd_is_told_and_what_is_stated_is_not(record, told, name, golden):
    change, says = ODD[name]
    change(record, record["torch_robot"], record["holder_robot"])
    found = told(record)
    assert says in " ".join(issue.message for issue in found.values()) if says else found == {}
    golden(found)


def test_the_mounting_face_of_a_tilted_arm_turns_with_it(record):
    record["torch_robot"] |= {"arm": "ar2010", "T_world_base": {"xyz_mm": [0, 0, 1000], "rpy_deg": [90, 0, 0]}}
    faces = [mount.face for mount in mounts(cell_from_record(record, path=CELLS / "cell.json"))]
    np.testing.assert_allclose(faces[0], [0.0, 505.0, 1000.0], rtol=0, atol=1e-9)


def test_a_capsule_that_does_not_hold_its_hull_is_told_with_the_distance(record, told):
    body = link(record["torch_robot"], "forearm")
    body["hull_mm"] = BOX
    axis = body["capsules"][0]
    out = max(  # of the corners from the axis z = 100 … 640
        np.hypot(np.hypot(x, y), max(100 - z, z - 640, 0)) - axis["radius_mm"] for x, y, z in BOX
    )
    assert f"up to {out:.1f} mm outside its capsules" in told(record)["capsule-and-hull"].message
    body["capsules"] = [capsule_of(BOX)]
    assert told(record) == {}


def test_capsules_that_hold_all_corners_but_not_the_middle_are_told(record, told):
    body = link(record["torch_robot"], "forearm")
    body["hull_mm"] = BOX
    body["capsules"] = [{"p_mm": [0, 0, z], "q_mm": [0, 0, z], "radius_mm": 130} for z in (80, 620)]
    out = np.hypot(np.hypot(80, 80), 270) - 130  # the middle of a long edge
    found = float(told(record)["capsule-and-hull"].message.split("up to ")[1].split(" mm")[0])
    assert found == pytest.approx(out, rel=0.1)


def test_the_record_of_a_check_is_of_its_schema(record, golden):
    record["bench"] = []
    cell = cell_from_record(record, path=CELLS / "cell.json")
    found = json.loads(to_json(cell_check_record(cell, check_cell(cell))))
    jsonschema.Draft202012Validator(json.loads(schema_text("wpcal/cell-check/1"))).validate(found)
    jsonschema.Draft202012Validator(json.loads(schema_text("wpcal/cell/1"))).validate(record)
    golden(found)


ROUND_OFF = 1e-12


@pytest.fixture
def read(tmp_path):
    def write_and_read(record):
        file = tmp_path / "cell.json"
        file.write_text(json.dumps(record), encoding="utf-8")
        return read_cell(file)

    return write_and_read


def test_the_shipped_cell_is_of_its_schema(record):
    validator = jsonschema.Draft202012Validator(json.loads(schema_text("wpcal/cell/1")))
    validator.validate(record)
    del record["torch_robot"]["T_flange_tool"]
    assert not validator.is_valid(record)


def test_two_robots_face_each_other(cell):
    np.testing.assert_allclose(cell.T_base1_base2.t_mm, [1500.0, 0.0, 0.0], rtol=0, atol=ROUND_OFF)
    np.testing.assert_allclose(cell.T_base1_base2.R, np.diag([-1.0, -1.0, 1.0]), rtol=0, atol=ROUND_OFF)
    np.testing.assert_allclose(cell.T_world_middle.t_mm, [750.0, 0.0, 0.0], rtol=0, atol=ROUND_OFF)


def test_slow_joints_weigh_most_unless_the_file_says_otherwise(read, record):
    cell = read(record)
    speeds = np.array([joint.speed_rad_s for joint in cell.arm.joints])
    np.testing.assert_allclose(cell.joint_weights[:6] * speeds, np.full(6, speeds.min()), rtol=0, atol=ROUND_OFF)
    record["torch_robot"]["joint_weights"] = [6, 5, 4, 3, 2, 1]
    assert read(record).joint_weights[:6].tolist() == [6, 5, 4, 3, 2, 1]


def test_an_arm_may_stand_beside_the_cell(read, record, tmp_path):
    record["holder_robot"]["arm"] = "mine.json"
    with pytest.raises(InputError, match=r"mine.json: no such file"):
        read(record)


@pytest.mark.parametrize(
    ("change", "error", "says"),
    [
        (lambda r: r["holder_robot"].pop("T_flange_part"), InputError, "holder_robot: T_flange_part is missing"),
        (lambda r: r.pop("safety_distance_mm"), FormatError, "the field 'safety_distance_mm' is missing"),
        (lambda r: r.update(schema="wpcal/cell/2"), FormatError, "expected a record of schema wpcal/cell/1"),
        (lambda r: r.update(safety_distance_mm=-1), FormatError, "safety_distance_mm: expected a number from 0"),
        (
            lambda r: r["torch_robot"].update(joint_weights=[1, 2]),
            FormatError,
            "torch_robot.joint_weights: expected 6 entries, got 2",
        ),
        (lambda r: r["torch_robot"].update(links=3), FormatError, "torch_robot.links: expected a list, got 3"),
        (
            lambda r: r["torch_robot"]["T_world_base"].update(xyz_mm=[0, 0]),
            FormatError,
            "T_world_base.xyz_mm: expected 3 entries",
        ),
        (
            lambda r: r["bench"][0]["capsules"][0].update(radius_mm=0),
            FormatError,
            "radius_mm: expected a number above 0",
        ),
        (
            lambda r: r["torch_robot"]["links"][0].update(link=7),
            FormatError,
            "link: expected a whole number from 0 to 6, got 7",
        ),
    ],
)
def test_bad_cells_say_what_is_wrong(read, record, change, error, says):
    change(record)
    with pytest.raises(error, match=says):
        read(record)
