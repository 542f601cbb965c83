from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cad.kernel.geometry import edge_length, vertex_points
from cad.step import write as write_step
from cad.step.append_seams import SEAMS_NAME
from cad.step.compare import compare_inventories, take_inventory
from cad.step.read import StepPart, read_step
from cad.step.write import know_part, write_moved_step
from cad.workpiece.calibrate import calibrate_files
from tests.few import few
from wpcal.core.errors import FormatError, InputError
from wpcal.core.transform import RigidTransform

MOVED_ATOL_MM = 1e-9
"""Coordinates of up to 2 m in 64 bit, through one product of matrices and the kernel's own: 4e-12 mm was measured."""

T_BASE_PART = RigidTransform.from_six_tuple([812.3, -455.1, 277.7, 0.3, -0.7, 2.1], target="base", source="part")

TURN = np.linspace(0, 2 * np.pi, 33)
CIRCLE = 50.0 * np.column_stack([np.cos(TURN), np.sin(TURN), np.zeros(33)])
SEAMS = (("S1 Kehlnaht ä", [[0, 0, 0], [10, 0, 0], [10, 5, 0]], (1.0, 0.5, 0.0)), ("S2", CIRCLE, (0.0, 0.5, 1.0)))

REAL = [
    "as1-oc-214.stp", "M6-countersunk-screw.step", "ANC101-ill.stp", "box_sides.STEP", "colored.step",
    "control_arm.step", "dm1-id-214.stp", "featuretype.STEP", "house_walls.stp", "nist_ctc_02_asme1_ap242-e2.stp",
    "nist_ctc_05_asme1_ap242-e1.stp", "nist_ftc_06_asme1_ap242-e2.stp", "nist_ftc_08_asme1_ap242-e1-tg.stp",
    "red_cube_blue_cylinder.step", "tail_section_asm.stp",
]  # fmt: skip


@pytest.fixture
def frame(tmp_path: Path) -> StepPart:
    from step_samples import write_assembly

    return read_step(write_assembly(tmp_path / "frame.step"))


def assert_moved(part: StepPart, path: Path) -> None:
    """The strongest statement: every solid has its name, its colour, and every vertex where T puts it."""
    moved = read_step(path)
    assert (moved.unit, moved.schema) == (part.unit, part.schema)
    for a, b in zip(part.solids, moved.solids, strict=True):
        assert (a.name, a.color_rgb, a.layers) == (b.name, b.color_rgb, b.layers)
        np.testing.assert_allclose(
            vertex_points(b.shape), T_BASE_PART.apply(vertex_points(a.shape)), rtol=0, atol=MOVED_ATOL_MM
        )


@pytest.mark.parametrize("bake", [False, True])
@pytest.mark.parametrize("unit", ["MM", "INCH", "M"])
def test_a_moved_assembly_is_where_it_should_be_with_all_its_names(tmp_path: Path, unit: str, bake: bool) -> None:
    from step_samples import write_assembly

    part = read_step(write_assembly(tmp_path / "frame.step", unit))
    assert write_moved_step(part, T_BASE_PART, tmp_path / "moved.step", bake=bake) == ()
    assert_moved(part, tmp_path / "moved.step")


@pytest.mark.parametrize("bake", [False, True])
def test_a_moved_part_is_where_it_should_be(tmp_path: Path, bake: bool) -> None:
    from step_samples import cylinder, write_part

    part = read_step(write_part(tmp_path / "pin.step", cylinder()))
    assert write_moved_step(part, T_BASE_PART, tmp_path / "moved.step", bake=bake) == ()
    assert_moved(part, tmp_path / "moved.step")


def test_appending_changes_nothing_that_was_there(frame: StepPart, tmp_path: Path) -> None:
    write_moved_step(frame, T_BASE_PART, tmp_path / "moved.step")
    written, at = (tmp_path / "moved.step").read_bytes(), frame.source.data_end
    assert written.startswith(frame.text[:at])
    assert written.endswith(frame.text[at:])


def test_the_new_assembly_is_named_after_the_file(frame: StepPart, tmp_path: Path) -> None:
    write_moved_step(frame, T_BASE_PART, tmp_path / "moved.step")
    assert read_step(tmp_path / "moved.step").solids[0].path == ("frame calibrated", "frame", "left")


def test_baking_adds_no_level(frame: StepPart, tmp_path: Path) -> None:
    write_moved_step(frame, T_BASE_PART, tmp_path / "moved.step", bake=True)
    assert read_step(tmp_path / "moved.step").solids[0].path == ("frame", "left")


@pytest.mark.parametrize("bake", [False, True])
def test_the_same_input_gives_the_same_bytes(frame: StepPart, tmp_path: Path, bake: bool) -> None:
    for name in ("one.step", "two.step"):
        write_moved_step(frame, T_BASE_PART, tmp_path / name, bake=bake, seams=SEAMS)
    assert (tmp_path / "one.step").read_bytes() == (tmp_path / "two.step").read_bytes()


@pytest.mark.parametrize("bake", [False, True])
def test_seams_are_named_coloured_edges_in_a_group(tmp_path: Path, bake: bool) -> None:
    from step_samples import write_assembly

    part = read_step(write_assembly(tmp_path / "frame.step", "INCH"))
    assert write_moved_step(part, T_BASE_PART, tmp_path / "moved.step", bake=bake, seams=SEAMS) == ()
    marks = [mark for mark in read_step(tmp_path / "moved.step").marks if SEAMS_NAME in mark.path]
    assert [(mark.kind, mark.name, mark.color_rgb, mark.layers) for mark in marks] == [
        ("edge", "S1 Kehlnaht ä", (1.0, 0.5, 0.0), (SEAMS_NAME,)),
        ("edge", "S2", (0.0, 0.5, 1.0), (SEAMS_NAME,)),
    ]
    ends = T_BASE_PART.apply([[0, 0, 0], [10, 5, 0]])
    np.testing.assert_allclose(vertex_points(marks[0].shape), ends, rtol=0, atol=MOVED_ATOL_MM)
    assert len(vertex_points(marks[1].shape)) == 1  # closed: it ends in the vertex it starts from
    assert edge_length(marks[0].shape) == pytest.approx(15.0, rel=0, abs=MOVED_ATOL_MM)


def test_a_seam_of_one_point_is_refused(frame: StepPart, tmp_path: Path) -> None:
    with pytest.raises(InputError, match="S9"):
        write_moved_step(frame, T_BASE_PART, tmp_path / "moved.step", seams=[("S9", [[1, 2, 3], [1, 2, 3]], (1, 0, 0))])
    assert not (tmp_path / "moved.step").exists()


def defeated(*_arguments: object, **_options: object) -> None:
    raise FormatError("no product with a shape is found in its text")


def test_where_the_text_defeats_us_the_kernel_writes_and_it_is_said(
    frame: StepPart, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(write_step, "append_placement", defeated)
    issues = write_moved_step(frame, T_BASE_PART, tmp_path / "moved.step")
    assert [issue.code for issue in issues] == ["moved-other-way"]
    assert "no product with a shape" in issues[0].message
    assert_moved(frame, tmp_path / "moved.step")


@pytest.mark.parametrize("unit", ["INCH", "CM"])
def test_the_kernels_writer_keeps_the_unit_and_the_time_stamp(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, unit: str
) -> None:
    from step_samples import write_assembly

    path = write_assembly(tmp_path / "frame.step", unit)
    stamped = read_step(path).source.time_stamp.encode("ascii")
    path.write_bytes(path.read_bytes().replace(stamped, b"2001-02-03T04:05:06"))
    part = read_step(path)
    monkeypatch.setattr(write_step, "append_placement", defeated)
    write_moved_step(part, T_BASE_PART, tmp_path / "moved.step")
    moved = read_step(tmp_path / "moved.step")
    assert (moved.unit, moved.source.time_stamp) == (part.unit, "2001-02-03T04:05:06")


@pytest.fixture
def outlined(monkeypatch: pytest.MonkeyPatch) -> list[int]:
    """Check outlines of small files, too; the list gets the number of faces of every document that is counted."""
    faces, take = list[int](), write_step.take_inventory

    def counted(*arguments: Any, **options: Any) -> Any:
        found = take(*arguments, **options)
        faces.append(found.surfaces.total())
        return found

    monkeypatch.setattr(write_step, "MANY_FACES", 1)
    monkeypatch.setattr(write_step, "take_inventory", counted)
    return faces


@pytest.mark.parametrize("unit", ["MM", "INCH"])
def test_of_a_large_file_one_face_of_each_solid_is_read_again(tmp_path: Path, outlined: list[int], unit: str) -> None:
    from step_samples import write_assembly

    part = read_step(write_assembly(tmp_path / "frame.step", unit))
    assert write_moved_step(part, T_BASE_PART, tmp_path / "moved.step") == ()
    assert_moved(part, tmp_path / "moved.step")
    assert write_moved_step(part, T_BASE_PART, tmp_path / "seams.step", seams=SEAMS) == ()
    whole, moved, *with_seams = outlined
    assert 0 < moved < whole / 2
    assert with_seams == [whole, moved]


def test_moves_of_one_part_cut_its_outline_once(
    frame: StepPart, tmp_path: Path, outlined: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    known = know_part(frame)
    monkeypatch.setattr(write_step, "outline", None)
    outlined.clear()
    for name in ("one.step", "other.step"):
        assert write_moved_step(frame, T_BASE_PART, tmp_path / name, known=known) == ()
    assert outlined == 2 * [known.outlined[1].surfaces.total()]


def test_a_shell_without_a_face_can_be_moved(frame: StepPart, tmp_path: Path, outlined: list[int]) -> None:
    shell = b"#90001=OPEN_SHELL('',());#90002=SHELL_BASED_SURFACE_MODEL('',(#90001));"
    path, at, items = tmp_path / "shell.step", frame.source.data_end, b"BREP_SHAPE_REPRESENTATION('',("
    path.write_bytes(frame.text[:at].replace(items, items + b"#90002,") + shell + frame.text[at:])
    part = read_step(path)
    assert write_moved_step(part, T_BASE_PART, tmp_path / "moved.step", known=know_part(part)) == ()


def test_a_wrong_place_in_a_large_file_is_seen(
    frame: StepPart, tmp_path: Path, outlined: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    append = write_step.append_placement
    off = RigidTransform.from_six_tuple([0, 0, 1e-5, 0, 0, 0], target="base", source="base")

    def wrong(file: Any, T_base_part: RigidTransform, **more: Any) -> Any:
        return append(file, off @ T_base_part, **more)

    monkeypatch.setattr(write_step, "append_placement", wrong)
    (issue,) = write_moved_step(frame, T_BASE_PART, tmp_path / "moved.step")
    said = "appending to the text failed: the written file's vertices are off the moved ones by 1e-05 mm"
    assert said in issue.message
    assert_moved(frame, tmp_path / "moved.step")


def test_a_digit_that_the_disk_lost_in_a_large_file_is_seen(
    frame: StepPart, tmp_path: Path, outlined: list[int], monkeypatch: pytest.MonkeyPatch
) -> None:
    write = write_step.write_file
    at = frame.source.text.rindex(b"CARTESIAN_POINT", 0, frame.source.data_end)

    def damaged(path: Path, text: bytes, **options: Any) -> None:
        lost = text[:at] + text[at:].replace(b"0.", b"1.", 1)
        write(path, lost if text.startswith(frame.source.text[:at]) else text, **options)

    monkeypatch.setattr(write_step, "write_file", damaged)
    (issue,) = write_moved_step(frame, T_BASE_PART, tmp_path / "moved.step")
    assert "does not hold the text of the file that was read" in issue.message
    assert_moved(frame, tmp_path / "moved.step")


def test_a_wrong_pose_a_lost_name_and_a_lost_colour_are_seen(frame: StepPart) -> None:
    before = take_inventory(frame.document)
    identity = RigidTransform.identity(target="base", source="part")
    assert compare_inventories(before, before, identity, added=before.names - before.names) == []
    off = RigidTransform.from_six_tuple([2e-6, 0, 0, 0, 0, 0], target="base", source="part")
    found = compare_inventories(before, before, off, added=before.names - before.names)
    assert [issue.code for issue in found] == ["moved-vertices-differ"]
    before.names["right"] -= 1
    before.colors.clear()
    found = compare_inventories(before, take_inventory(frame.document), identity, added=before.names - before.names)
    assert [issue.code for issue in found] == ["moved-names-differ", "moved-colors-differ"]
    assert "right: 0 before, 1 after" in found[0].message


@pytest.mark.parametrize("name", few(REAL, 2))
def test_real_files_lose_nothing(shared_step: Path, tmp_path: Path, name: str) -> None:
    part = read_step(shared_step / name)
    assert write_moved_step(part, T_BASE_PART, tmp_path / "moved.step", seams=SEAMS) == ()
    assert_moved(part, tmp_path / "moved.step")


@pytest.mark.parametrize(
    "name", few(["red_cube_blue_cylinder.step", "control_arm.step", "as1-oc-214.stp", "box_sides.STEP"], 1)
)
def test_real_files_are_baked(shared_step: Path, tmp_path: Path, name: str) -> None:
    part = read_step(shared_step / name)
    assert write_moved_step(part, T_BASE_PART, tmp_path / "moved.step", bake=True) == ()
    assert_moved(part, tmp_path / "moved.step")


def test_where_baking_is_defeated_the_text_is_appended_to_and_it_is_said(shared_step: Path, tmp_path: Path) -> None:
    part = read_step(shared_step / "nist_ftc_06_asme1_ap242-e2.stp")
    issues = write_moved_step(part, T_BASE_PART, tmp_path / "moved.step", bake=True)
    assert [issue.code for issue in issues] == ["moved-other-way"]
    assert "COORDINATES_LIST" in issues[0].message
    assert_moved(part, tmp_path / "moved.step")


@pytest.mark.parametrize(("bake", "more"), few([(True, 0), (False, 1)], 1))
def test_calibrate_bakes_on_request(tmp_path: Path, bake: bool, more: int) -> None:
    tee = Path(__file__).parents[2] / "fixtures" / "tee"
    calibrate_files(tee / "tee.step", tee / "taught_exact.csv", tmp_path / "out", overwrite=False, bake=bake)
    paths = tee / "tee.step", tmp_path / "out" / "tee.calibrated.step"
    uses = [path.read_bytes().count(b"NEXT_ASSEMBLY_USAGE_OCCURRENCE(") for path in paths]
    assert uses[1] - uses[0] == more
