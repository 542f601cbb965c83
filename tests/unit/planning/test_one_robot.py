"""One robot on all seams, and where robots of two bases are to each other."""

import copy
import csv
import json
from dataclasses import replace

import jsonschema
import numpy as np
import pytest
from click.testing import CliRunner
from scipy.spatial.transform import Rotation

from tests.one_robot_cells import TEE, fixed_cell, one_robot_record, random_axes, with_positioner, write_cell
from tests.real_cells import bvh
from tests.saddle import CELL
from wpcal.cli.bases import bases
from wpcal.core.errors import FormatError, GeometryError, InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.schemas import schema_text
from wpcal.core.transform import RigidTransform
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_check import check_cell
from wpcal.planning.cell.cell_clearance import CellClearance
from wpcal.planning.cell.cell_file import read_cell, read_one_robot
from wpcal.planning.cell.distance_field import DistanceField
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.touch.grasp import BASE1_COLUMNS, BASE2_COLUMNS, measure_bases, read_base_points

fcl = pytest.importorskip("fcl", reason="python-fcl is not installed")

ROUND_OFF_MM = 1e-6
FCL_MM = 1e-3  #: FCL measures distances of capsules from triangles to about 1e-5 mm.


@pytest.fixture
def on_positioner(tmp_path):
    return read_one_robot(write_cell(tmp_path, with_positioner()))


def test_the_cells_are_of_the_schema():
    validator = jsonschema.Draft202012Validator(json.loads(schema_text("wpcal/cell/1")))
    for record in (one_robot_record(), with_positioner()):
        assert list(validator.iter_errors(record)) == []


def test_a_part_on_a_positioner_turns_about_its_axes(on_positioner):
    q = random_axes(on_positioner, 20)
    T = on_positioner.part_places(q)
    for row, (tilt, turn) in enumerate(q[:, 6:]):
        # axis 1 is x of world through (900, 0, 500); the table is 100 mm along axis 2, which stands up at zero
        R = Rotation.from_rotvec([tilt, 0, 0]).as_matrix() @ T_table() @ Rotation.from_rotvec([0, 0, turn]).as_matrix()
        assert np.allclose(T[row, :3, :3], R @ T_zero(on_positioner, T_table()), rtol=0, atol=1e-9)
    off = np.linalg.norm(T[:, :3, 3] - [900, 0, 500], axis=1)
    assert np.allclose(off, 100.0, rtol=0, atol=ROUND_OFF_MM)
    frames = on_positioner.frames(q)
    assert np.allclose(frames[on_positioner.part_row].matrices(), T, rtol=0, atol=ROUND_OFF_MM)


def T_table():
    """Axis 2 at zero: the base frame of the arm is turned by 90 degrees about y, and the link by -90 about x."""
    return rotation_from_zyx(0, np.pi / 2, 0) @ rotation_from_zyx(-np.pi / 2, 0, 0)


def T_zero(cell, R_table):
    zero = np.zeros((1, len(cell.axis_names)))
    return R_table.T @ cell.part_places(zero)[0, :3, :3]


def test_a_rail_moves_the_robot_and_not_the_part(tmp_path):
    rail = {"direction": [0, 2, 0], "min_mm": -500, "max_mm": 1500, "speed_mm_s": 700}
    record = one_robot_record(T_world_part={"xyz_mm": [800, 0, 200], "rpy_deg": [0, 0, 0]})
    record["torch_robot"]["rail"] = rail
    cell = read_one_robot(write_cell(tmp_path, record))
    assert cell.axis_names[6] == "rail"
    q = np.concatenate([cell.home[:6], [400.0]])[None]
    moved = cell.tool_places(q)[0] - cell.tool_places(cell.home[None])[0]
    assert np.allclose(moved[:3, 3], [0, 400, 0], rtol=0, atol=ROUND_OFF_MM)
    assert np.allclose(cell.frames(q)[7].matrices(), cell.tool_places(q), rtol=0, atol=ROUND_OFF_MM)


def test_a_touched_part_is_where_the_robot_found_it(on_positioner):
    T_base_part = RigidTransform(rotation_from_zyx(0.1, -0.2, 0.3), np.array([900.0, 50.0, 700.0]), "base", "part")
    cell = on_positioner.with_touched_part(T_base_part)
    q = np.concatenate([cell.home[:6], cell.touched_at])[None]
    expected = cell.T_world_base.matrix @ T_base_part.matrix
    assert np.allclose(cell.part_places(q)[0], expected, rtol=0, atol=ROUND_OFF_MM)


def test_the_field_is_a_lower_bound_of_the_distance():
    rng = np.random.default_rng(1)
    corners = rng.uniform(-200, 200, (30, 1, 3)) + rng.uniform(-60, 60, (30, 3, 3))
    field = DistanceField.of_triangles(corners)
    points = rng.uniform(-500, 500, (4000, 3))
    weights = rng.dirichlet([1, 1, 1], (30, 400))
    samples = np.einsum("tsk,tkx->tsx", weights, corners).reshape(-1, 3)
    distance = np.sqrt(((points[:, None] - samples[None, ::7]) ** 2).sum(axis=2)).min(axis=1)
    bound = field.least(points)
    assert (bound <= distance + ROUND_OFF_MM).all()
    near = distance < 100.0
    assert np.median((distance - bound)[near]) < 4 * field.cell_mm  # it is worth something


def test_margins_are_lower_bounds_of_what_fcl_measures(golden):
    """Another measurement of the same bodies: all capsules against the real triangles, without bounds or grids."""
    given = read_sequence_input(TEE, fixed_cell())
    cell = given.placed(fixed_cell())
    clearance = CellClearance(cell, given.part)
    q = random_axes(cell, 150)
    found, again = clearance.margins(q), clearance.margins(q[::-2])
    assert np.array_equal(again.by_carriers_mm, found.by_carriers_mm[::-2])
    lower = clearance.standing_as(replace(cell, floor_z_mm=cell.floor_z_mm - 50.0)).margins(q)
    assert (lower.margin_mm - found.margin_mm).max() > 1.0
    true = np.array([_fcl_margin(cell, given.part, row) for row in q])
    assert (found.margin_mm <= true + FCL_MM).all()
    compared = found.is_clear | [clearance.names(pair)[1] in ("part", "floor") for pair in found.pair]
    refused = ~found.is_clear & (true > FCL_MM) & compared
    assert refused.mean() < 0.03  # a bound that refuses everything is worth nothing
    assert 0.1 < found.is_clear.mean() < 0.95
    golden(found)


def _fcl_margin(cell, part, q):
    part_object = bvh(part.corners.reshape(-1, 3), np.arange(part.corners.size // 3).reshape(-1, 3))
    T = cell.part_places(q[None])[0]
    part_object.setTransform(fcl.Transform(T[:3, :3], T[:3, 3]))
    frames = [frame.matrices()[0] for frame in cell.frames(q[None])]
    least = np.inf
    for shape, frame in [(s, frames[s.link]) for s in cell.links if s.link] + [(s, frames[7]) for s in cell.torch]:
        needed = cell.d1_mm if shape.to_part_mm is None else shape.to_part_mm
        for p, r, radius in zip(shape.p, shape.q, shape.radius_mm, strict=True):
            a, b = (frame[:3, :3] @ x + frame[:3, 3] for x in (p, r))
            R, _ = Rotation.align_vectors([b - a + [0, 0, 1e-12]], [[0, 0, 1]])
            capsule = fcl.CollisionObject(
                fcl.Capsule(radius, np.linalg.norm(b - a)), fcl.Transform(R.as_matrix(), (a + b) / 2)
            )
            found = fcl.distance(capsule, part_object, fcl.DistanceRequest(), fcl.DistanceResult())
            least = min(least, max(found, 0.0) - needed)
    links = [(frames[s.link], s) for s in cell.links if s.link > 1]
    heights = [
        (T @ [*end, 1.0])[2] - r for T, s in links for e in (s.p, s.q) for end, r in zip(e, s.radius_mm, strict=True)
    ]
    return min([least, *(height - cell.d1_mm for height in heights)]) if least > 0 else least


def test_old_cells_are_two_robots_and_new_ones_are_one(on_positioner):
    assert isinstance(read_cell(CELL), Cell)
    with pytest.raises(InputError, match="expected a cell with one robot"):
        read_one_robot(CELL)
    assert on_positioner.axis_names[-2:] == ("tilt", "turn")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda r: r["torch_robot"].update(T_flange_tool=None), "T_flange_tool is missing: the tool, whose"),
        (lambda r: r["torch_robot"].update(home_deg=[0, 0, 900, 0, 0, 0]), "home: U is beyond its limits"),
        (lambda r: r["torch_robot"].update(home_deg=[0, 0]), "home_deg: expected 6 entries, got 2"),
        (lambda r: r["positioner"].update(arm="mh6"), "a positioner has one or two axes, this one has 6"),
        (lambda r: r["torch_robot"].update(rail={"direction": [0, 0, 0], "min_mm": 0, "max_mm": 1, "speed_mm_s": 1}),
         "rail: expected a direction"),
    ],
)  # fmt: skip
def test_a_wrong_cell_is_one_line(tmp_path, change, says):
    record = copy.deepcopy(with_positioner())
    change(record)
    with pytest.raises((InputError, FormatError), match=says) as error:
        read_one_robot(write_cell(tmp_path, record))
    assert "\n" not in str(error.value)


def test_a_home_in_collision_is_told(tmp_path, golden):
    record = one_robot_record()
    cell = fixed_cell()
    q = random_axes(cell, 50)
    bad = q[np.argmin(CellClearance(cell, None).margins(q).margin_mm)]
    record["torch_robot"]["home_deg"] = np.degrees(bad).tolist()
    issues = check_cell(read_one_robot(write_cell(tmp_path, record)))
    assert [issue.code for issue in issues if issue.code == "home"] == ["home"]
    golden(issues)


EXACT_MM = 1e-6  #: Exact points of two metres through the minimax fit.
EXACT_RAD = 1e-9


@pytest.fixture
def cell_json(tmp_path):
    """A cell without a grasp, whose robot 1 is not in the origin."""
    record = json.loads(CELL.read_text())
    record["torch_robot"]["T_world_base"] = {"xyz_mm": [-100, 40, 15], "rpy_deg": [0.5, -1, 30]}
    del record["holder_robot"]["T_flange_part"]
    path = tmp_path / "cell.json"
    path.write_text(json.dumps(record))
    return path


def write_touched(path, T_base1_base2, n=5, noise=0.0):
    rng = np.random.default_rng(4)
    p2 = rng.uniform(-700, 700, (n, 3))
    p1 = T_base1_base2.apply(p2) + noise * rng.normal(size=(n, 3))
    with path.open("w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["name", *BASE1_COLUMNS, *BASE2_COLUMNS])
        writer.writerows(
            [f"P{i}", *map(repr, one.tolist()), *map(repr, two.tolist())]
            for i, (one, two) in enumerate(zip(p1, p2, strict=True))
        )


TRUTH = RigidTransform(rotation_from_zyx(0.01, -0.02, 3.0), [1480, -22, 7], target="base1", source="base2")


def test_robot_2_is_where_the_points_say(cell_json, tmp_path, golden):
    write_touched(tmp_path / "touched.csv", TRUTH)
    done = CliRunner().invoke(
        bases, [str(cell_json), str(tmp_path / "touched.csv"), "-o", str(tmp_path / "out")], standalone_mode=False
    )
    assert done.return_value == 0, done.output
    assert "wrote cell.json" in done.output
    record = json.loads((tmp_path / "out" / "cell.json").read_text())
    assert "T_flange_part" not in record["holder_robot"]
    record["holder_robot"]["T_flange_part"] = {"xyz_mm": [0, 0, 0], "rpy_deg": [0, 0, 0]}
    (tmp_path / "whole.json").write_text(json.dumps(record))
    cell = read_cell(tmp_path / "whole.json")
    assert cell.T_base1_base2.is_close(TRUTH, atol_mm=EXACT_MM, atol_rad=EXACT_RAD)
    golden(record)


def test_points_that_do_not_agree_miss_the_tolerance_and_are_written(cell_json, tmp_path):
    write_touched(tmp_path / "touched.csv", TRUTH, n=8, noise=2.0)
    arguments = [str(cell_json), str(tmp_path / "touched.csv"), "-o", str(tmp_path / "out"), "--json"]
    done = CliRunner().invoke(bases, arguments, standalone_mode=False)
    assert done.return_value == 1
    assert json.loads(done.output)["verdict"] == "FAIL"
    assert (tmp_path / "out" / "cell.json").exists()


def test_points_in_a_line_two_points_and_a_missing_column_are_refused(cell_json, tmp_path):
    line = "\n".join(f"P{i},{i},0,0,{i},0,0" for i in range(1, 5))
    (tmp_path / "touched.csv").write_text(",".join(["name", *BASE1_COLUMNS, *BASE2_COLUMNS]) + "\n" + line + "\n")
    with pytest.raises(GeometryError):
        measure_bases(cell_json, read_base_points(tmp_path / "touched.csv"), tolerance_mm=0.5)
    write_touched(tmp_path / "touched.csv", TRUTH, n=2)
    with pytest.raises(FormatError, match="at least 3 points that both robots touched, got 2"):
        read_base_points(tmp_path / "touched.csv")
    (tmp_path / "touched.csv").write_text("name,base1_x_mm\nP1,1\n")
    with pytest.raises(FormatError, match="base1_y_mm"):
        read_base_points(tmp_path / "touched.csv")
