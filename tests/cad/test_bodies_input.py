"""Files and options about bodies that cannot be used: one line that says what is wrong, where, and what is expected."""

import json
from pathlib import Path
from typing import Any

import pytest

from cad.workpiece.bodies import BodiesOptions, BodyGroup, find_bodies, read_bodies
from cad.workpiece.workpiece import Workpiece, open_workpiece
from tests.running import run_here
from wpcal.core.errors import FormatError, InputError

UPRIGHTS = Path(__file__).parents[2] / "fixtures" / "uprights"
pytestmark = pytest.mark.usefixtures("kernel_here")
HEAD = '{"schema": "wpcal/bodies/1"'


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("{", "is not JSON"),
        ("[]", "expected a record of schema wpcal/bodies/1"),
        ('{"schema": "wpcal/bodies/2", "bodies": []}', "found wpcal/bodies/2"),
        (HEAD + "}", "names no body"),
        (HEAD + ', "bodies": []}', "names no body"),
        (HEAD + ', "bodies": {}}', "expected a list"),
        (HEAD + ', "bodies": [1]}', "expected an object"),
        (HEAD + ', "bodies": [{}]}', "body 1 has no name"),
        (HEAD + ', "bodies": [{"name": 5}]}', "expected a text, got 5"),
        (HEAD + ', "bodies": [{"name": "U1", "solids": "U1"}]}', "body U1: solids: expected a list"),
        (HEAD + ', "bodies": [{"name": "U1", "solids": []}]}', "expected at least 1"),
        (HEAD + ', "bodies": [{"name": "U1", "tack_mm": "a"}]}', "expected a number"),
        (HEAD + ', "bodies": [{"name": "U1", "tack_mm": 0}]}', "must be a positive number, got 0"),
        (HEAD + ', "bodies": [{"name": "U1", "tack_mrad": -3}]}', "must be a positive number, got -3"),
        (HEAD + ', "bodies": [{"name": "U1", "tack_mm": NaN}]}', "expected a number"),
        (HEAD + ', "bodies": [{"name": "U1", "tak_mm": 1}]}', "body U1 has tak_mm; expected name, solids, tack_mm"),
        (HEAD + ', "bodys": []}', "the file has bodys; expected schema, bodies"),
        (HEAD + ', "bodies": [{"name": "A", "solids": ["U1"]}, {"name": "A"}]}', "body A is there twice"),
    ],
)
def test_a_broken_file(tmp_path: Path, text: str, what: str) -> None:
    path = tmp_path / "bodies.json"
    path.write_text(text)
    with pytest.raises(FormatError) as caught:
        read_bodies(path)
    assert what in str(caught.value)
    assert "\n" not in str(caught.value)


@pytest.fixture(scope="module")
def uprights() -> Workpiece:
    return open_workpiece(UPRIGHTS / "uprights.step")


@pytest.mark.parametrize(
    ("groups", "what"),
    [
        ([("U9", ["U9"])], "body U9: the part has no solid U9; it has base, U1, U2, U3, U4"),
        ([("A", ["U1"]), ("B", ["U?"])], "solid U1 is in two bodies: A and B"),
        ([("base", ["U1"])], "body base does not hold the solid base, which is in no body"),
        ([("all", ["*"])], "the part is one body: nothing can have moved in it; put its solids into two bodies"),
    ],
)
def test_groups_that_the_part_does_not_have(uprights: Workpiece, groups: list[Any], what: str) -> None:
    options = BodiesOptions(groups=tuple(BodyGroup(name, tuple(solids)) for name, solids in groups))
    with pytest.raises(InputError) as caught:
        find_bodies(uprights.trimmed, options)
    assert what in str(caught.value)


def test_a_bracket_in_a_name_is_a_bracket(tmp_path: Path) -> None:
    from step_samples import add_part, box, new_document, write_document

    document = new_document()
    add_part(document, box(), "rib [1]")
    add_part(document, box((50.0, 0.0, 0.0)), "rib 1")
    workpiece = open_workpiece(write_document(document, tmp_path / "ribs.step"))
    found = find_bodies(workpiece.trimmed, BodiesOptions(groups=(BodyGroup("left", ("rib [1]",)),)))
    assert found.bodies.names == ("left", "rib 1")


def test_members_are_grouped_by_their_names(tmp_path: Path) -> None:
    from OCP.BRepAlgoAPI import BRepAlgoAPI_Fuse
    from step_samples import box, write_part

    shape = box((0.0, 0.0, 0.0), (200.0, 100.0, 10.0))
    for x in (20.0, 80.0, 140.0):
        shape = BRepAlgoAPI_Fuse(shape, box((x, 20.0, 10.0), (8.0, 60.0, 40.0))).Shape()
    workpiece = open_workpiece(write_part(tmp_path / "fused.step", shape))
    assert find_bodies(workpiece.trimmed, BodiesOptions()).bodies.names == tuple(f"member {i}" for i in range(1, 5))
    pair = BodiesOptions(groups=(BodyGroup("pair", ("member 2", "member 3")),))
    assert find_bodies(workpiece.trimmed, pair).bodies.names == ("member 1", "pair", "member 4")


PART, TAUGHT = str(UPRIGHTS / "uprights.step"), str(UPRIGHTS / "taught.csv")


@pytest.mark.parametrize(
    ("arguments", "what"),
    [
        ([PART, TAUGHT, "--tack-mm", "1"], "--tack-mm and --tack-mrad are for --bodies"),
        ([PART, TAUGHT, "--contacts"], "--contacts is for --bodies"),
        ([PART, TAUGHT, "--bending"], "--bending is for --bodies"),
        ([PART, TAUGHT, "--bodies", "--bending", "0"], "must be a positive number of mm, got 0"),
        ([PART, TAUGHT, "--bodies", "--contacts", "x"], "--contacts: expected a number of mm, got 'x'"),
        ([PART, TAUGHT, "--bodies", "--contacts", "0"], "must be a positive number of mm, got 0"),
        ([PART, TAUGHT, "--bodies", "--tack-mrad", "0"], "the tack tolerance in mrad must be a positive number"),
        ([PART, TAUGHT, "--bodies", "--certify"], "--certify cannot be used with --bodies"),
        ([PART, TAUGHT, "--bodies", "--rigid"], "--rigid cannot be used with --bodies"),
        ([PART, TAUGHT, "--bodies", "--criterion", "minimax"], "--criterion minimax cannot be used with --bodies"),
        ([PART, "--bodies", TAUGHT], "--bodies: expected a JSON file of bodies"),
        ([PART, TAUGHT, "--bodies", "none.json"], "none.json: no such file"),
    ],
)
def test_options_that_do_not_go_together(tmp_path: Path, arguments: list[str], what: str) -> None:
    found = run_here("calibrate", *arguments, "-o", str(tmp_path / "out"))
    assert found.returncode == 2
    assert what in found.stderr
    assert found.stderr.count("\n") == 1
    assert not (tmp_path / "out").exists()


def test_the_file_that_is_written_says_what_no_file_says(uprights: Workpiece, tmp_path: Path) -> None:
    path = tmp_path / "bodies.json"
    assert run_here("bodies", PART, "-o", str(path)).returncode == 0
    usual = find_bodies(uprights.trimmed, BodiesOptions())
    read = find_bodies(uprights.trimmed, BodiesOptions(groups=read_bodies(path)))
    assert (read.bodies.names, read.bodies.tolerances) == (usual.bodies.names, usual.bodies.tolerances)
    assert (read.face_body == usual.face_body).all()
    again = run_here("bodies", PART, "-o", str(path))
    assert again.returncode == 2
    assert "exists" in again.stderr


def test_the_fixture_is_what_it_says() -> None:
    record = json.loads((UPRIGHTS / "bodies.json").read_text())
    assert [group.name for group in read_bodies(UPRIGHTS / "bodies.json")] == [b["name"] for b in record["bodies"]]
