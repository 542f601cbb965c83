import hashlib
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from cad.kernel.geometry import vertex_points
from cad.kernel.topology import EDGE, FACE, SHELL, SOLID, compound, sub_shapes
from cad.step.open_text import read_step_text
from cad.step.read import _issues_of, read_step
from cad.step.solids import LeafShapes
from cad.workpiece.workpiece import open_workpiece
from tests.few import few
from wpcal.core.errors import FormatError, InputError
from wpcal.core.issue import Issue

WRITER_ATOL_MM = 1e-9  #: The kernel writes and reads coordinates with 15 digits; samples are at most 150 mm long.

BOX = [(0, 0, 0), (30, 0, 0), (0, 20, 0), (30, 20, 0), (0, 0, 10), (30, 0, 10), (0, 20, 10), (30, 20, 10)]


def sorted_rows(points: np.ndarray) -> np.ndarray:
    rows = np.round(points, 6)
    return points[np.lexsort(rows.T[::-1])]


def test_a_part_has_its_name_colour_unit_and_hash(tmp_path: Path) -> None:
    from step_samples import box, write_part

    path = write_part(tmp_path / "part.step", box())
    part = read_step(path)
    (solid,) = part.solids
    assert (solid.name, solid.path, solid.color_rgb) == ("plate", ("plate",), (1.0, 0.5, 0.25))
    assert (part.file_name, part.unit, part.issues) == ("part.step", "mm", ())
    assert part.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()
    assert part.text == path.read_bytes()


def test_uses_of_a_part_are_placed_and_numbered(tmp_path: Path) -> None:
    from step_samples import SECOND_USE, write_assembly

    part = read_step(write_assembly(tmp_path / "frame.step"))
    assert [solid.name for solid in part.solids[:2]] == ["Träger 'A'", "Träger 'A'#2"]
    assert [solid.path for solid in part.solids] == [("frame", "left"), ("frame", "right"), ("frame", "pin")]
    first, second = (sorted_rows(vertex_points(solid.shape)) for solid in part.solids[:2])
    np.testing.assert_allclose(first, sorted_rows(np.array(BOX, dtype=float)), rtol=0, atol=WRITER_ATOL_MM)
    np.testing.assert_allclose(
        second, sorted_rows(SECOND_USE.apply(np.array(BOX, dtype=float))), rtol=0, atol=WRITER_ATOL_MM
    )


@pytest.mark.parametrize(
    ("mm", "said"), [(0.5, "0.87 mm"), (2.0, ""), (20_000.0, ""), (30_000.0, "52 m"), (25_000.0, "43.3 m")]
)
def test_a_part_that_is_too_large_or_too_small_may_be_in_another_unit(tmp_path: Path, mm: float, said: str) -> None:
    from step_samples import box, write_part

    part = open_workpiece(write_part(tmp_path / "part.step", box(size=(mm, mm, mm))))
    told = [issue.message for issue in part.issues if issue.code == "size"]
    assert [f"the part is {said} from corner to corner; its file says mm" in one for one in told] == [True] * bool(said)


@pytest.mark.parametrize(("unit", "name"), [("INCH", "inch"), ("M", "m"), ("CM", "cm")])
def test_another_unit_is_an_issue_and_the_geometry_is_in_mm(tmp_path: Path, unit: str, name: str) -> None:
    from step_samples import box, write_part

    part = read_step(write_part(tmp_path / "part.step", box(), unit=unit))
    assert part.unit == name
    assert [issue.code for issue in part.issues] == ["unit-not-mm"]
    np.testing.assert_allclose(
        sorted_rows(vertex_points(part.solids[0].shape)),
        sorted_rows(np.array(BOX, dtype=float)),
        rtol=0,
        atol=WRITER_ATOL_MM,
    )


def test_unsewn_faces_become_a_solid_with_its_material_inside(tmp_path: Path) -> None:
    from OCP.BRepGProp import BRepGProp
    from OCP.GProp import GProp_GProps
    from step_samples import unsewn_box, write_part

    part = read_step(write_part(tmp_path / "part.step", unsewn_box()))
    (solid,) = part.solids
    assert solid.shape.ShapeType() == SOLID
    assert [issue.code for issue in part.issues] == ["unsewn-faces"]
    assert "0.01 mm: 24 open edges before, 0 after" in part.issues[0].message
    properties = GProp_GProps()
    BRepGProp.VolumeProperties_s(solid.shape, properties)
    assert properties.Mass() == pytest.approx(6000.0, rel=0, abs=1e-6)  # 30 x 20 x 10; inside out it is negative


def test_an_open_surface_is_given_as_a_shell(tmp_path: Path) -> None:
    from step_samples import open_box, write_part

    part = read_step(write_part(tmp_path / "part.step", open_box()))
    assert [solid.shape.ShapeType() for solid in part.solids] == [SHELL]
    assert [issue.code for issue in part.issues] == ["unsewn-faces"]


def test_faces_beside_a_solid_are_an_issue(tmp_path: Path) -> None:
    from step_samples import box, write_part

    extra = sub_shapes(box((100.0, 0.0, 0.0)), FACE)[0]
    part = read_step(write_part(tmp_path / "part.step", compound([box(), extra])))
    assert len(part.solids) == 1
    assert [issue.code for issue in part.issues] == ["loose-faces"]


def test_wires_alone_are_refused(tmp_path: Path) -> None:
    from step_samples import box, write_part

    path = write_part(tmp_path / "wires.step", compound(sub_shapes(box(), EDGE)))
    with pytest.raises(InputError, match="holds no face"):
        read_step(path)


def test_an_empty_part_is_told_of_unless_another_of_its_name_has_the_faces() -> None:
    leaves = [
        SimpleNamespace(entry=entry, use=SimpleNamespace(name=name))
        for entry, name in (("1", "plate"), ("2", "plate"), ("3", "bolt"))
    ]
    prepared = {
        entry: LeafShapes((), (Issue("empty-part", f"{name} has no shape", (name,)),) * empty, has_faces=not empty)
        for entry, name, empty in (("1", "plate", False), ("2", "plate", True), ("3", "bolt", True))
    }
    assert [issue.ids for issue in _issues_of(leaves, prepared)] == [("bolt",)]


def test_two_runs_give_the_same(tmp_path: Path) -> None:
    from step_samples import write_assembly

    path = write_assembly(tmp_path / "frame.step")
    first, second = read_step(path), read_step(path)
    for a, b in zip(first.solids, second.solids, strict=True):
        assert (a.name, a.path, a.color_rgb, a.layers) == (b.name, b.path, b.color_rgb, b.layers)
        np.testing.assert_array_equal(vertex_points(a.shape), vertex_points(b.shape))


def test_build123d_gets_named_coloured_shapes(tmp_path: Path) -> None:
    from step_samples import box, write_part

    (shape,) = read_step(write_part(tmp_path / "part.step", box())).build123d_shapes()
    assert shape.label == "plate"
    assert shape.volume == pytest.approx(6000.0, rel=0, abs=1e-6)


# Input that is refused before the kernel is asked --------------------------------------------------------------------


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"", "is empty"),
        (b" \n\n", "is empty"),
        (b"version https://git-lfs.github.com/spec/v1\noid sha256:1\n", "Git LFS pointer"),
        (b"%PDF-1.7\n", "is a PDF"),
        (b"PK\x03\x04abc", "zip archive"),
        (b"solid part\nfacet normal 0 0 1\n", "STL mesh"),
        (b"name,x_mm,y_mm\n", "not STEP text"),
        (b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n", "data section is empty"),
        (b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=A('x", "does not end"),
        (b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=A(1);", "cut off"),
        (b"ISO-10303-21;\nHEADER;\n", "cut off"),
    ],
)
def test_what_is_no_step_file_is_one_line(tmp_path: Path, content: bytes, message: str) -> None:
    path = tmp_path / "part.step"
    path.write_bytes(content)
    with pytest.raises(InputError, match=message) as caught:
        read_step(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_missing_file_and_a_folder_are_one_line(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no such file"):
        read_step(tmp_path / "missing.step")
    with pytest.raises(InputError, match="is a folder"):
        read_step(tmp_path)


def test_text_that_only_looks_like_step_is_refused_by_the_kernel_in_one_line(tmp_path: Path) -> None:
    path = tmp_path / "part.step"
    path.write_bytes(b"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n#1=NOTHING_KNOWN(1);\nENDSEC;\nEND-ISO-10303-21;\n")
    with pytest.raises(InputError) as caught:
        read_step(path)
    assert "\n" not in str(caught.value)


# Real files ----------------------------------------------------------------------------------------------------------


def test_an_assembly_of_others(shared_step: Path) -> None:
    part = read_step(shared_step / "as1-oc-214.stp")
    names = [solid.name for solid in part.solids]
    assert len(names) == len(set(names)) == 18
    assert names[:3] == ["nut", "nut#2", "rod"]
    assert part.solids[3].path == ("as1", "l-bracket-assembly_1", "nut-bolt-assembly_1", "bolt_1")
    assert {solid.layers for solid in part.solids} == {("256",)}
    assert part.solids[2].color_rgb == (1.0, 0.5, 0.0)


@pytest.mark.parametrize(
    ("name", "solids", "unit", "codes"),
    few(
        [
            ("house_walls.stp", 1, "cm", ["unit-not-mm"]),
            ("nist_ctc_05_asme1_ap242-e1.stp", 1, "inch", ["unit-not-mm", "free-edges"]),
            ("nist_ftc_08_asme1_ap242-e1-tg.stp", 0, "mm", ["tessellated-faces", "tessellated-faces", "no-solid"]),
            ("red_cube_blue_cylinder.step", 2, "m", ["unit-not-mm"]),
            ("dm1-id-214.stp", 7, "inch", ["unit-not-mm"]),
            ("ANC101-ill.stp", 1, "mm", ["unsewn-faces"]),
            ("tail_section_asm.stp", 5, "mm", []),
        ],
        5,
    ),
)
def test_oddities_of_real_files_are_issues(
    shared_step: Path, name: str, solids: int, unit: str, codes: list[str]
) -> None:
    part = read_step(shared_step / name)
    assert (len(part.solids), part.unit, [issue.code for issue in part.issues]) == (solids, unit, codes)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("odd_lfs_pointer.stp", "Git LFS pointer"),
        ("odd_truncated_nist_ctc_01.stp", "cut off"),
        ("s1-c5-214.stp", "TAIL, HEAD, MAINBODY, FOOT"),
    ],
)
def test_odd_files_are_one_line(shared_step: Path, name: str, message: str) -> None:
    with pytest.raises((InputError, FormatError), match=message):
        read_step(shared_step / name)


def test_a_byte_order_mark_before_the_text(tmp_path: Path) -> None:
    plain = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"
    marked = tmp_path / "tee.step"
    marked.write_bytes(b"\xef\xbb\xbf" + plain.read_bytes())
    part, expected = read_step(marked), read_step(plain)
    assert [solid.name for solid in part.solids] == [solid.name for solid in expected.solids]
    assert part.text == expected.text
    assert part.sha256 == hashlib.sha256(marked.read_bytes()).hexdigest()


@pytest.mark.parametrize(
    ("data", "says"),
    [
        ("#" + "1" * 5000 + "=A();", "an instance number has more than 18 digits"),
        ("#1=SHAPE_DEFINITION_REPRESENTATION(#" + "1" * 5000 + ",#2);", "a reference has more than 18 digits"),
        ("#1=SHAPE_DEFINITION_REPRESENTATION(" + "1" * 5000 + ",#2);", "an integer has more than 18 digits"),
    ],
    ids=["instance", "reference", "integer"],
)
def test_numbers_of_thousands_of_digits_are_refused(data: str, says: str, tmp_path: Path) -> None:
    path = tmp_path / "part.step"
    path.write_text(f"ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\n{data}\nENDSEC;\nEND-ISO-10303-21;\n")
    with pytest.raises(FormatError, match=f"line 5: {says}"):
        list(read_step_text(path).instances("SHAPE_DEFINITION_REPRESENTATION"))


def with_copy(text: str, y: float, scale: str, *, is_complex: bool = False) -> str:
    """Return the text of a single part in which an operator places its shape; `y` is that of the second axis."""
    axis, ref = re.search(r"ADVANCED_BREP_SHAPE_REPRESENTATION\('[^']*',\((#\d+),(#\d+)\)", text).groups()
    context = re.search(r"ADVANCED_BREP_SHAPE_REPRESENTATION\([^;]*,(#\d+)\);", text)[1]
    simple = f"CARTESIAN_TRANSFORMATION_OPERATOR_3D('','','',#90001,#90002,#90004,{scale},#90003)"
    parts = (
        f"(CARTESIAN_TRANSFORMATION_OPERATOR(#90001,#90002,#90004,{scale})CARTESIAN_TRANSFORMATION_OPERATOR_3D(#90003)"
        "FUNCTIONALLY_DEFINED_TRANSFORMATION('','')GEOMETRIC_REPRESENTATION_ITEM()REPRESENTATION_ITEM(''))"
    )
    added = [
        "#90001=DIRECTION('',(1.,0.,0.));",
        f"#90002=DIRECTION('',(0.,{y},0.));",
        "#90003=DIRECTION('',(0.,0.,1.));",
        "#90004=CARTESIAN_POINT('',(0.,0.,50.));",
        f"#90005=ADVANCED_BREP_SHAPE_REPRESENTATION('',({axis},{ref}),{context});",
        f"#90006=REPRESENTATION_MAP({axis},#90005);",
        f"#90007={parts if is_complex else simple};",
        "#90008=MAPPED_ITEM('',#90006,#90007);",
    ]
    placed = text.replace(f"({axis},{ref})", f"({axis},{ref},#90008)", 1)
    begin, end, rest = placed.rpartition("ENDSEC;")
    return begin + "\n".join(added) + "\n" + end + rest


@pytest.mark.parametrize(
    ("y", "scale", "is_complex", "says"),
    [
        (-1.0, "1.", False, "#90008 places a copy of a shape mirrored, which"),
        (1.0, "1.5", False, "#90008 places a copy of a shape scaled by 1.5, which"),
        (-1.0, "$", True, "#90008 places a copy of a shape mirrored, which"),
        (1.0, "1.", False, ""),
    ],
)
def test_a_copy_that_the_kernel_reads_wrongly_is_refused(
    tmp_path: Path, y: float, scale: str, is_complex: bool, says: str
) -> None:
    from step_samples import box, write_part

    path = write_part(tmp_path / "part.step", box())
    path.write_text(with_copy(" ".join(path.read_text().split("\n")), y, scale, is_complex=is_complex))
    if says:
        with pytest.raises(InputError, match=says):
            read_step(path)
        return
    _, copy = read_step(path).solids  # a copy that is only moved is where the operator has it
    places = vertex_points(copy.shape)
    assert np.allclose(sorted_rows(places), sorted_rows(np.add(BOX, (0, 0, 50.0))), rtol=0, atol=WRITER_ATOL_MM)
