"""Torches as files and as bodies: the shipped ones, a person's own, and what is refused."""

import json
import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from xml.etree import ElementTree as ET

import jsonschema
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull
from scipy.spatial.transform import Rotation

from tests.running import run_here
from wpcal.core.errors import InputError
from wpcal.core.schemas import schema_text
from wpcal.core.transform import RigidTransform
from wpcal.pages.draw.torches import torches_svg
from wpcal.robot.kinematics.urdf_bodies import capsule_around
from wpcal.robot.torch.attitude import (
    ToolAxis,
    TorchSettings,
    measure_torch,
    neck_directions,
    tool_rotations,
    wire_directions,
)
from wpcal.robot.torch.bodies import bodies_of_shape, mounted
from wpcal.robot.torch.file import find_torch, shipped_torches, torches_record
from wpcal.robot.torch.shape import CONE_STEP_MM, USUAL_TORCH, Neck, TorchShape
from wpcal.seam.judge.other_torches import core_of_all
from wpcal.seam.judge.torch_neck import bend_directions

FOLDER = Path(__file__).parents[3] / "wpcal" / "robot" / "torch" / "torches"
OWN = json.loads((FOLDER / "robot-45.json").read_text(encoding="utf-8"))


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.json")), ids=lambda path: path.stem)
def test_the_shipped_torches_follow_their_schema_and_say_where_their_sizes_are_from(path: Path) -> None:
    record = json.loads(path.read_text(encoding="utf-8"))
    jsonschema.Draft202012Validator(json.loads(schema_text("wpcal/torch/1"))).validate(record)
    assert record["source"]
    shape = find_torch(path.stem)
    assert shape.name == path.stem
    assert shape.wires_mm[0] == shape.wire_mm
    assert max(np.diff(shape.wires_mm)) <= 2.5


def test_the_first_shipped_torch_is_the_one_that_is_assumed() -> None:
    assert shipped_torches()[0].shape == USUAL_TORCH == find_torch("straight")
    assert len({torch.shape.name for torch in shipped_torches()}) == len(list(FOLDER.glob("*.json")))


def test_the_pieces_of_a_neck_follow_each_other_and_turn_by_its_angle() -> None:
    shape = find_torch("robot-45")
    assert shape.neck is not None
    ends = [(tube.start, tube.end) for tube in shape.tubes]
    np.testing.assert_allclose(ends[0][0], [0.0, 0.0, shape.front_mm], atol=1e-12)
    for (_, end), (start, _) in pairwise(ends):
        np.testing.assert_allclose(end, start, atol=1e-12)
    way = ends[-1][1] - ends[-1][0]
    assert math.degrees(math.atan2(way[0], way[2])) == pytest.approx(45.0, abs=1e-9)
    along = shape.front_mm + sum(float(np.linalg.norm(end - start)) for start, end in ends)
    assert shape.length_mm - shape.wire_mm - 1.0 < along <= shape.length_mm - shape.wire_mm  # chords of the bend


def test_the_core_is_inside_every_shipped_torch() -> None:
    core = core_of_all()
    for torch in shipped_torches():
        shape = torch.shape
        assert core.mouth_mm <= shape.mouth_mm
        assert core.nozzle_radius_mm <= shape.nozzle_radius_mm
        assert core.front_mm <= shape.front_mm
        for at in np.linspace(0.0, core.front_mm, 50):
            own, whole = (
                s.mouth_mm + (s.nozzle_radius_mm - s.mouth_mm) * (min(at / s.taper_mm, 1.0) if s.taper_mm else 1.0)
                for s in (core, shape)
            )
            assert own <= whole + 1e-9


def test_a_longer_wire_is_tried_in_steps_up_to_the_longest() -> None:
    assert replace(USUAL_TORCH, most_wire_mm=26.0).wires_mm == (20.0, 22.5, 25.0, 26.0)


def test_a_torch_of_ones_own_is_read_and_listed(tmp_path: Path) -> None:
    path = tmp_path / "mine.json"
    path.write_text(json.dumps({**OWN, "neck": {**OWN["neck"], "angle_deg": 30}}), encoding="utf-8")
    shape = find_torch(str(path))
    assert (shape.name, shape.neck.angle_deg if shape.neck else None) == ("mine", 30.0)
    done = run_here("torches", str(path), "straight", "-o", str(tmp_path / "t.svg"))
    assert done.returncode == 0
    assert "mine" in done.stdout
    assert "30 deg" in done.stdout
    words = [one.text for one in ET.parse(tmp_path / "t.svg").getroot().iter("{http://www.w3.org/2000/svg}text")]
    assert {"mine", "straight"} <= set(words)
    assert torches_svg([shape]) == torches_svg([shape])
    listed = json.loads(run_here("torches", "--json").stdout)
    assert [torch["name"] for torch in listed["torches"]] == [torch.shape.name for torch in shipped_torches()]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"length_mm": -1}, "length_mm: expected"),
        ({"nozzle": {}}, "diameter_mm"),
        ({"wire": {"usual_mm": 18, "most_mm": 10}}, "the longest wire (10 mm) is not between"),
        ({"nozzle": {"diameter_mm": 24, "mouth_diameter_mm": 30, "taper_mm": 20}}, "torch mouth: expected"),
        ({"nozzle": {"diameter_mm": 24, "mouth_diameter_mm": 20}}, "a conical nozzle needs"),
        ({"neck": {**OWN["neck"], "body_from_mm": 20}}, "before the end of the bend"),
        ({"neck": {**OWN["neck"], "body_from_mm": 900}}, "behind its end"),
        ({"schema": "wpcal/arm/1"}, "expected a record of schema wpcal/torch/1"),
    ],
)
def test_a_file_that_is_not_a_torch_is_refused_in_one_line(
    change: dict[str, object], words: str, tmp_path: Path
) -> None:
    path = tmp_path / "odd.json"
    path.write_text(json.dumps({**OWN, **change}), encoding="utf-8")
    with pytest.raises(InputError) as error:
        find_torch(str(path))
    assert words in str(error.value)
    assert "odd.json" in str(error.value)


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (("--torch", "robot-23"), "no shipped torch; shipped are straight, robot-22"),
        (("--work-range-deg", "5,15"), "expected a range around 0"),
        (("--travel-range-deg", "-10"), "--travel-range-deg: expected FROM,TO in degrees, got '-10'"),
        (("--neck-range-deg", "200"), "within 180 degrees"),
    ],
)
def test_a_wrong_option_is_one_line(options: tuple[str, ...], words: str) -> None:
    done = run_here("seams", "fixtures/tee/tee.step", *options)
    assert done.returncode == 2
    (line,) = done.stderr.splitlines()
    assert words in line


@pytest.mark.parametrize("wrong", [{"angle_deg": 200.0}, {"radius_mm": 0.0}, {"bend_mm": math.nan}])
def test_a_neck_that_is_no_neck_is_refused(wrong: dict[str, float]) -> None:
    sizes = {"angle_deg": 22.0, "from_mm": 70.0, "bend_mm": 60.0, "radius_mm": 11.0}
    with pytest.raises(InputError, match="torch neck"):
        TorchShape(neck=Neck(**{**sizes, "body_from_mm": 150.0, "body_radius_mm": 20.0, **wrong}))


SHAPES = pytest.mark.parametrize("shape", [each.shape for each in shipped_torches()], ids=lambda shape: shape.name)


@SHAPES
def test_the_pieces_of_a_nozzle_hold_its_cone_and_are_hardly_wider(shape, golden):
    z = np.linspace(0.0, shape.front_mm, 400)
    radius = np.interp(z, [0.0, max(shape.taper_mm, 1e-9)], [shape.mouth_mm, shape.nozzle_radius_mm])
    felt = [np.where((z >= t.start[2]) & (z <= t.end[2]), t.radius_mm, 0.0) for t in shape.nozzle_tubes]
    wider = np.max(felt, axis=0) - radius
    assert -1e-9 <= wider.min() <= wider.max() <= CONE_STEP_MM + 1e-9
    told, more, R = [shape], shape.with_more_wire(3.7), seam_frames(3)
    T_flange_tool = RigidTransform(R[0], [31.0, -12.0, 347.0], "flange", "tool")
    leans = np.array([[0.1, -0.2], [0.0, 0.0], [0.3, 0.05], [0.0, 0.1], [np.nan, 0.2]])
    for axis in ToolAxis:
        at = tool_rotations(R, TorchSettings(0.31, -0.17, 2.3, axis), leans, np.linspace(0.4, -0.6, 5))
        told += [at, neck_directions(at, axis), measure_torch(R, wire_directions(at, axis))]
    bodies = [each.get("hull_mm", each["capsules"]) for each in bodies_of_shape(more, T_flange_tool)]
    golden([*told, more, torches_record([more]), mounted(more, T_flange_tool), bodies])


def depth_in(body, points):
    """How deep points are inside a planned body, mm; negative outside, at least by so much."""
    if "hull_mm" in body:
        planes = ConvexHull(body["hull_mm"]).equations
        return -(points @ planes[:, :3].T + planes[:, 3]).max(axis=1)
    (capsule,) = body["capsules"]
    p, way = np.array(capsule["p_mm"]), np.subtract(capsule["q_mm"], capsule["p_mm"])
    share = np.clip((points - p) @ way / (way @ way), 0.0, 1.0)
    return capsule["radius_mm"] - np.linalg.norm(points - p - share[:, None] * way, axis=1)


def test_the_nozzle_of_a_short_tool_ends_at_its_flange():
    for length_mm in (80.0004, 110.0):
        T_flange_tool = RigidTransform(np.eye(3), [0.0, 0.0, length_mm], "flange", "tool")
        (nozzle,) = bodies_of_shape(USUAL_TORCH, T_flange_tool)
        assert np.min(nozzle["hull_mm"], axis=0)[2] == pytest.approx(-length_mm, abs=1e-3)
        assert 0.02 <= nozzle["capsules"][0]["radius_mm"] - capsule_around(nozzle["hull_mm"])[2] <= 0.03  # round-off


@SHAPES
@pytest.mark.parametrize("flange", [(120.0, 0.0, 300.0), (0.0, 0.0, 420.0)], ids=["beside the wire", "on the wire"])
def test_the_planned_bodies_of_a_torch_are_the_pieces_with_which_seams_are_judged(shape, flange):
    """Within 1 mm, at the edge of a body that is wider than its neck, too. Behind its end none are judged."""
    T_flange_tool = RigidTransform(np.eye(3), flange, "flange", "tool")
    felt, bodies = mounted(shape, T_flange_tool), bodies_of_shape(shape, T_flange_tool)
    ahead = np.array([0.0, 0.0, 1.0])
    rings = [(0.0 * ahead, ahead, felt.mouth_mm), (felt.taper_mm * ahead, ahead, felt.nozzle_radius_mm)]
    for before, tube in pairwise((felt.nozzle_tubes[-1], *felt.tubes)):
        way = (tube.end - tube.start) / np.linalg.norm(tube.end - tube.start)
        rings += [(at, way, tube.radius_mm) for at in (tube.start, (tube.start + tube.end) / 2)]
        if tube.radius_mm > before.radius_mm + 2.0:
            rings.append((tube.start - 0.1 * way, way, (before.radius_mm + tube.radius_mm) / 2))
    turn, side = np.arange(0.0, 2 * np.pi, 0.1)[:, None], np.array([0.0, 1.0, 0.0])
    for at, way, radius in rings:
        circle = np.cos(turn) * side + np.sin(turn) * np.cross(way, side)
        places = (at + (radius + np.array([[[-0.6]], [[1.0]]])) * circle) * -1.0 - [0.0, 0.0, felt.wire_mm]
        inside, outside = (np.max([depth_in(body, each) for body in bodies], axis=0) for each in places)
        assert inside.min() > -0.2
        assert outside.max() < 0.0


ROUND_OFF = 1e-12  #: A few products of rotations, entries at most 1.
ROUND_OFF_RAD = 1e-12

angles = st.floats(-0.7, 0.7)


def seam_frames(seed, n=5):
    return Rotation.random(n, rng=np.random.default_rng(seed)).as_matrix()


@given(work=angles, travel=angles, seed=st.integers(0, 100), axis=st.sampled_from(ToolAxis))
def test_the_angles_measured_back_are_those_asked_for(work, travel, seed, axis):
    R_seam = seam_frames(seed)
    torch = TorchSettings(work, travel, tool_axis=axis)
    R_tool = tool_rotations(R_seam, torch)
    np.testing.assert_allclose(np.linalg.det(R_tool), 1.0, rtol=0, atol=ROUND_OFF)
    found_work, found_travel = measure_torch(R_seam, wire_directions(R_tool, axis))
    np.testing.assert_allclose(found_work, work, rtol=0, atol=ROUND_OFF_RAD)
    np.testing.assert_allclose(found_travel, travel, rtol=0, atol=ROUND_OFF_RAD)


def test_push_points_the_wire_forward_and_work_turns_it_towards_y():
    torch = TorchSettings(work_rad=math.radians(10), travel_rad=math.radians(15))
    wire = wire_directions(tool_rotations(np.eye(3)[None], torch), ToolAxis.Z)[0]
    v, w = math.radians(15), math.radians(10)
    expected = [math.sin(v), math.cos(v) * math.sin(w), -math.cos(v) * math.cos(w)]
    np.testing.assert_allclose(wire, expected, rtol=0, atol=ROUND_OFF)


@pytest.mark.parametrize("settings", [{"work_rad": 1.2}, {"travel_rad": math.nan}, {"standoff_mm": -1.0}])
def test_impossible_torches_are_refused(settings):
    with pytest.raises(InputError):
        TorchSettings(**settings)


@given(seed=st.integers(0, 100), axis=st.sampled_from(ToolAxis))
def test_a_neck_in_the_program_bends_to_where_it_was_felt(seed: int, axis: ToolAxis) -> None:
    rng = np.random.default_rng(seed)
    R_seam, lean, spin = seam_frames(seed), rng.uniform(-0.6, 0.6, (5, 2)), rng.uniform(-3.1, 3.1, 5)
    R_tool = tool_rotations(R_seam, TorchSettings(tool_axis=axis), lean, spin)
    felt = bend_directions(-wire_directions(R_tool, axis), R_seam, spin)
    np.testing.assert_allclose(neck_directions(R_tool, axis), felt, rtol=0, atol=ROUND_OFF)
