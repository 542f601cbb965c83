"""The moved STEP file of a weldment whose bodies moved: every solid where its own motion puts it, and nothing lost."""

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest
from OCP.TDataStd import TDataStd_Name
from OCP.XCAFDoc import XCAFDoc_DocumentTool

from cad.kernel.geometry import to_location, vertex_points
from cad.kernel.xcaf import to_extended_string
from cad.step import write as write_step
from cad.step.read import StepPart, read_step
from cad.step.write import write_moved_step
from cad.workpiece.bodies import BodiesOptions
from cad.workpiece.calibrate import calibrate_files
from cad.workpiece.fit_taught import CalibrateOptions
from tests.running import run_command
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform

ATOL_MM = 1e-9  #: As in `test_write_step`; 1e-6 mm is promised.

T_BASE_PART = RigidTransform.from_six_tuple([812.3, -455.1, 277.7, 0.3, -0.7, 2.1], target="base", source="part")
SEAMS = (("S1", [[0, 0, 0], [10, 0, 0]], (1.0, 0.5, 0.0)),)
UPRIGHTS = Path(__file__).parents[2] / "fixtures" / "uprights"


def motions(count: int, *, alike: tuple[int, ...] = ()) -> FloatArray:
    """Motions of so many solids; those of `alike` move as one, and the last solid stays."""
    rng = np.random.default_rng(count)
    T = np.tile(np.eye(4), (count, 1, 1))
    T[:, :3, :3], T[:, :3, 3] = exp_rotation(rng.normal(size=(count, 3)) * 0.02), rng.normal(size=(count, 3)) * 3.0
    T[list(alike)] = T[alike[0]] if alike else T[list(alike)]
    T[-1] = np.eye(4)
    return T


def assert_apart(part: StepPart, T_part_moved: FloatArray, path: Path) -> None:
    """Every solid has its name, colour and layers, and every vertex where T M puts it."""
    again = read_step(path)
    for number, (a, b, motion) in enumerate(zip(part.solids, again.solids, T_part_moved, strict=True), 1):
        assert (b.color_rgb, b.layers) == (a.color_rgb, a.layers)
        assert a.name in (b.name, f"S{number}")
        expected = T_BASE_PART.apply(vertex_points(a.shape) @ motion[:3, :3].T + motion[:3, 3])
        np.testing.assert_allclose(vertex_points(b.shape), expected, rtol=0, atol=ATOL_MM)


def written(part: StepPart, T_part_moved: FloatArray, path: Path, **options: object) -> list[str]:
    issues = write_moved_step(part, T_BASE_PART, path, T_part_moved=T_part_moved, **options)
    return [issue.code for issue in issues]


def nested(path: Path, unit: str = "MM") -> StepPart:
    """Write a frame that holds a rail twice; a rail holds a beam twice and a pin of two solids."""
    from step_samples import add_part, box, cylinder, new_document, write_document

    from cad.kernel.topology import compound

    document = new_document()
    tool = XCAFDoc_DocumentTool.ShapeTool_s(document.Main())
    beam = add_part(document, box(), "beam", (1.0, 0.5, 0.25))
    pair = add_part(document, compound([cylinder(), box((20.0, 0.0, 0.0))]), "pair", (0.0, 0.5, 1.0))

    def assembly(name: str, children: list[tuple[object, str, list[float]]]) -> object:
        label = tool.NewShape()
        TDataStd_Name.Set_s(label, to_extended_string(name))
        for child, use, six in children:
            place = RigidTransform.from_six_tuple(six, target="part", source="product")
            component = tool.AddComponent(label, child, to_location(place))
            TDataStd_Name.Set_s(component, to_extended_string(use))
        return label

    first, second = [0.0] * 6, [10.0, 200.0, 5.0, 0.1, 0.2, 0.3]
    rail = assembly("rail", [(beam, "b1", first), (beam, "b2", [80, 0, 9, 0.3, 0, 0]), (pair, "p", second)])
    assembly("frame", [(rail, "left", [5, 6, 7, 0, 0, 0.5]), (rail, "right", [-300, 40, 0, 0, 0.4, 0])])
    tool.UpdateAssemblies()
    return read_step(write_document(document, path, unit))


@pytest.mark.parametrize("bake", [False, True])
@pytest.mark.parametrize("unit", ["MM", "INCH"])
def test_every_use_of_a_shared_product_moves_by_itself(tmp_path: Path, unit: str, bake: bool) -> None:
    part = nested(tmp_path / "nested.step", unit)
    assert len(part.solids) == 8
    for alike in ((), (0, 1, 2, 3), (0, 1), (2, 3, 6)):
        T = motions(8, alike=alike)
        assert written(part, T, tmp_path / "moved.step", bake=bake, seams=SEAMS) == []
        assert_apart(part, T, tmp_path / "moved.step")


def test_what_moves_as_one_keeps_its_structure_and_no_geometry_changes(tmp_path: Path) -> None:
    part = nested(tmp_path / "nested.step")
    written(part, motions(8, alike=(0, 1, 2, 3)), tmp_path / "moved.step")
    again = read_step(tmp_path / "moved.step")
    assert again.solids[0].path == ("nested calibrated", "frame", "left", "b1")
    uses = [solid.path[:3] for solid in again.solids]
    assert [path[-1] for path in uses] == ["left"] * 4 + ["right"] * 4
    geometry = re.compile(rb"#\d+ ?= ?(?:ADVANCED_FACE|EDGE_CURVE|PLANE|CYLINDRICAL_SURFACE|STYLED_ITEM)[^;]*;")
    assert geometry.findall(part.text) == geometry.findall(again.text)


def test_solids_of_one_product_and_what_belongs_to_none(tmp_path: Path) -> None:
    from step_samples import box, cylinder, write_part

    from cad.kernel.topology import EDGE, compound, sub_shapes

    lines = sub_shapes(box((0.0, 0.0, 90.0)), EDGE)[:2]
    shape = compound([box(), cylinder(), box((50.0, 0.0, 0.0)), *lines])
    part = read_step(write_part(tmp_path / "plate.step", shape))
    T = motions(3)
    assert written(part, T, tmp_path / "moved.step") == []
    assert_apart(part, T, tmp_path / "moved.step")


@pytest.mark.parametrize("name", ["as1-oc-214.stp", "red_cube_blue_cylinder.step"])
def test_real_assemblies(shared_step: Path, tmp_path: Path, name: str) -> None:
    part = read_step(shared_step / name)
    T = motions(len(part.solids), alike=(0, 1))
    assert written(part, T, tmp_path / "moved.step") == []
    assert_apart(part, T, tmp_path / "moved.step")


def test_where_the_text_defeats_us_the_kernel_places_each_solid(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def defeated(*_arguments: object) -> None:
        raise FormatError("not today")

    part, T = nested(tmp_path / "nested.step"), motions(8)
    monkeypatch.setattr(write_step, "move_solids", defeated)
    assert written(part, T, tmp_path / "moved.step", seams=SEAMS) == ["moved-other-way", "moved-products-differ"]
    assert_apart(part, T, tmp_path / "moved.step")


def test_a_wrong_place_of_one_solid_is_seen(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    part, T, move = nested(tmp_path / "nested.step"), motions(8), write_step.move_solids

    def wrong(file: object, leaves: object, T_part_moved: FloatArray) -> object:
        off = T_part_moved.copy()
        off[5, 2, 3] += 1e-5
        return move(file, leaves, off)  # type: ignore[arg-type]

    monkeypatch.setattr(write_step, "move_solids", wrong)
    issues = write_moved_step(part, T_BASE_PART, tmp_path / "moved.step", T_part_moved=T)
    assert "has solid beam#4 off by 1e-05 mm" in issues[0].message
    assert_apart(part, T, tmp_path / "moved.step")


@pytest.fixture(scope="module")
def uprights(tmp_path_factory: pytest.TempPathFactory) -> Path:
    out = tmp_path_factory.mktemp("uprights") / "out"
    options = CalibrateOptions(bodies=BodiesOptions())
    calibrate_files(UPRIGHTS / "uprights.step", UPRIGHTS / "taught_six.csv", out, overwrite=False, options=options)
    return out


def _expected(out: Path) -> list[FloatArray]:
    """Vertices of each body at T_base_part @ T_part_moved of the record."""
    record = json.loads((out / "calibration.json").read_text())
    assert [issue for issue in record["issues"] if issue["code"].startswith(("moved", "bodies-not", "solid"))] == []
    motion = {body["name"]: np.array(body["T_part_moved"]) for body in record["bodies"]["bodies"]}
    found = []
    for solid in read_step(UPRIGHTS / "uprights.step").solids:
        T = np.array(record["T_base_part"]) @ motion[solid.name]
        found.append(vertex_points(solid.shape) @ T[:3, :3].T + T[:3, 3])
    return found


def test_the_command_places_every_body(uprights: Path) -> None:
    again = read_step(uprights / "uprights.calibrated.step").solids
    for solid, expected in zip(again, _expected(uprights), strict=True):
        np.testing.assert_allclose(vertex_points(solid.shape), expected, rtol=0, atol=1e-6)


@pytest.mark.skipif(shutil.which("freecadcmd") is None, reason="FreeCAD is not installed")
def test_freecad_reads_every_body_at_its_place(uprights: Path, tmp_path: Path) -> None:
    """By its own kernel, an older one: `Import` crashes in FreeCAD 0.20 without a window, also for the model itself."""
    script = tmp_path / "read.py"
    script.write_text(
        "import json, os, Part\n"
        "shape = Part.Shape()\n"
        "shape.read(os.environ['STEP_FILE'])\n"
        "points = [[tuple(v.Point) for v in solid.Vertexes] for solid in shape.Solids]\n"
        "open(os.environ['JSON_FILE'], 'w').write(json.dumps(points))\n"
    )
    files = {
        "STEP_FILE": str(uprights / "uprights.calibrated.step"),
        "JSON_FILE": str(tmp_path / "points.json"),
        "HOME": str(tmp_path),
    }
    run_command("freecadcmd", script, **files)
    found = [np.array(points) for points in json.loads((tmp_path / "points.json").read_text())]
    for own, expected in zip(found, _expected(uprights), strict=True):
        off = np.linalg.norm(own[:, None] - expected[None], axis=2)
        assert max(off.min(axis=0).max(), off.min(axis=1).max()) < 1e-6


def test_members_of_one_solid_stay_together_and_it_is_said(tmp_path: Path) -> None:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
    from step_samples import box, write_part

    plate, upright = box((-100.0, -50.0, -5.0), (200.0, 100.0, 10.0)), box((-90.0, -4.0, 5.0), (180.0, 8.0, 55.0))
    write_part(tmp_path / "fused.step", BRepAlgoAPI_Fuse(plate, upright).Shape())
    rows = [
        ("a", -90, -40, 5), ("b", 90, -40, 5), ("c", 90, 40, 5), ("d", -90, -50, 0), ("e", 90, -50, 0),
        ("f", -100, -30, 0), ("g", -80, 4, 40), ("h", 80, 4, 40), ("i", 0, 4, 50), ("j", -90, 0, 50),
    ]  # fmt: skip
    lines = [f"{n},plane,{x + 500},{y},{z},{x},{y},{z}" for n, x, y, z in rows]
    taught = tmp_path / "taught.csv"
    taught.write_text("name,kind,x_mm,y_mm,z_mm,model_x_mm,model_y_mm,model_z_mm\n" + "\n".join(lines) + "\n")
    options = CalibrateOptions(bodies=BodiesOptions())
    result = calibrate_files(tmp_path / "fused.step", taught, tmp_path / "out", overwrite=False, options=options)
    (note,) = [issue for issue in result.notes if issue.code == "solid-of-several-bodies"]
    assert "cannot be drawn apart" in note.message
    assert len(json.loads((tmp_path / "out" / "seams.json").read_text())["seams"]) >= 2
