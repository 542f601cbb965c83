"""What the programs of all controllers have in common; kinds of taught rows, and faces that were touched."""

from pathlib import Path

import numpy as np
import pytest

from wpcal.brep.graph_file import read_graph
from wpcal.brep.trim import TrimmedFaces
from wpcal.calibrate.observe.targets import TargetKind
from wpcal.controllers.user_frames import ProgramReading, parse_uframes, points_in_base, usable_points
from wpcal.core.arrays import frozen
from wpcal.core.errors import ErrorCode, FormatError, InputError
from wpcal.taught import programs
from wpcal.taught.features import FeatureKind, ReferenceFeature
from wpcal.taught.kinds import KINDS, TouchKind
from wpcal.taught.table import TaughtPoints, read_taught
from wpcal.taught.touched_face import touched_face

READER = programs.ProgramReader(lambda *_: programs.ProgramPoints(()), programs.frame_from_angles, "X,Y,Z,RX,RY,RZ")


def feature(name: str, kind: FeatureKind) -> ReferenceFeature:
    return ReferenceFeature(name, kind, frozen(np.zeros(3)), None, None, "S1")


def program(*points: programs.ProgramPoint, **frames) -> programs.TaughtProgram:
    return programs.TaughtProgram("t.prog", READER, programs.ProgramPoints(points, frames))


def point(name: str, frame: str | None = programs.BASE, line: int = 1) -> programs.ProgramPoint:
    return programs.ProgramPoint(name, line, np.array([1.0, 2.0, 3.0]), np.eye(3), frame)


def test_only_names_of_point_features_are_kept() -> None:
    features = [feature("V1", FeatureKind.VERTEX), feature("P1", FeatureKind.PLANE)]
    read = points_in_base(program(point("v1"), point("P1"), point("C00003")), ProgramReading())
    assert read.features == ("v1", "P1", "C00003")
    assert programs.names_as_features(read, features).features == ("v1", "", "")


def test_names_of_a_table_are_left_as_they_are() -> None:
    table = TaughtPoints.of_features(["V1", "home"], np.zeros((2, 3)))
    assert programs.names_as_features(table, [feature("V1", FeatureKind.VERTEX)]) is table


def test_a_frame_given_by_its_name_goes_before_the_frame_of_the_file() -> None:
    carried = programs.frame_from_angles([100, 0, 0, 0, 0, 0])
    one = program(point("a", "f"), point("b", None), f=carried)
    read = points_in_base(one, ProgramReading({"": "f"}))
    np.testing.assert_array_equal(read.p_base, [[101, 2, 3], [101, 2, 3]])
    read = points_in_base(one, ProgramReading({"f": [0, 0, 10, 0, 0, 0], "": "base"}))
    np.testing.assert_array_equal(read.p_base, [[1, 2, 13], [1, 2, 3]])


def test_what_is_missing_has_a_code_and_no_flag() -> None:
    joints = programs.joint_values([0, 0, 0, 0, 0, 0])
    cases = {
        ErrorCode.USER_FRAME_MISSING: point("a", "7"),
        ErrorCode.TOOL_MISSING: programs.ProgramPoint("a", 1, np.zeros(3), np.eye(3), programs.BASE, at_flange=True),
        ErrorCode.ARM_MISSING: programs.unusable_point("a", 1, "is stored as joint angles", joints),
        ErrorCode.POINT_UNUSABLE: programs.unusable_point("a", 1, "was never taught"),
    }
    for code, one in cases.items():
        with pytest.raises(FormatError, match=r"t\.prog, line 1: point a: ") as refused:
            points_in_base(program(one), ProgramReading())
        assert refused.value.code == code
        assert "--" not in str(refused.value)


def test_usable_points_leave_out_faults_and_double_names() -> None:
    joints = programs.unusable_point("j", 3, "is stored as joint angles", programs.joint_values([0] * 6))
    one = program(point("a"), point("b"), point("b"), joints)
    assert usable_points(one) == (("a",), {"b": "appears 2 times", "j": "is stored as joint angles"})


def test_user_frames_are_typed_with_or_without_a_name() -> None:
    frames = parse_uframes(["3=1,2,3,0,0,90", "base", "wobj7=fixture"])
    assert frames == {"3": [1, 2, 3, 0, 0, 90], "": "base", "wobj7": "fixture"}
    with pytest.raises(InputError, match="3 is given twice"):
        parse_uframes(["3=base", "3=base"])


def test_a_line_that_was_cut_has_no_joint_values() -> None:
    for more in ([], ["****"], ["nan"]):
        assert programs.joint_values(["1", "2", "3", *more]) is None


TOUCHES_PAGE = Path(__file__).parents[3] / "docs" / "how-to" / "touches.md"


def written(tmp_path: Path, kind: str, radius: str) -> Path:
    path = tmp_path / "touches.csv"
    path.write_text(f"name,kind,x_mm,y_mm,z_mm,feature,radius_mm\na,{kind},1,2,3,F1,{radius}\n")
    return path


def test_every_kind_has_a_target_and_faces_have_surfaces() -> None:
    assert {kind.target for kind in TouchKind} == set(TargetKind)
    for kind in TouchKind:
        assert bool(kind.surfaces) is (kind.target is TargetKind.FACE)
        assert kind.takes_radius is (kind.target is TargetKind.FACE)
    assert [kind for kind in TouchKind if kind.is_inside] == [TouchKind.HOLE]


@pytest.mark.parametrize("word", KINDS)
def test_every_word_is_read_as_its_kind(tmp_path: Path, word: str) -> None:
    taught = read_taught(written(tmp_path, word.upper(), ""))
    assert taught.kinds == (KINDS[word],)
    assert taught.has_touches is (KINDS[word] is not TouchKind.POINT)
    assert taught.with_ball(2.0).radius_mm[0] == (2.0 if KINDS[word].takes_radius else 0.0)


@pytest.mark.parametrize("word", KINDS)
def test_a_ball_is_refused_where_its_centre_is_not_known(tmp_path: Path, word: str) -> None:
    path = written(tmp_path, word, "1.5")
    if KINDS[word].takes_radius:
        assert read_taught(path).radius_mm.tolist() == [1.5]
    else:
        with pytest.raises(FormatError, match=f"line 2, column radius_mm: a ball has no radius at a {word}"):
            read_taught(path)


def test_an_empty_cell_is_a_point_and_an_unknown_word_is_refused(tmp_path: Path) -> None:
    assert read_taught(written(tmp_path, "", "")).kinds == (TouchKind.POINT,)
    with pytest.raises(FormatError, match=r"line 2, column kind: .*'corner'"):
        read_taught(written(tmp_path, "corner", ""))


def test_the_page_about_touches_lists_every_kind() -> None:
    row = next(line for line in TOUCHES_PAGE.read_text(encoding="utf-8").splitlines() if line.startswith("| `kind` |"))
    assert [word for word in row.split("`") if word in KINDS] == list(KINDS)


GRAPHS = Path(__file__).parents[3] / "fixtures" / "graphs"
ROUND_OFF_MM = 1e-6
CHORD_MM = 1e-3  #: Borders are polylines: on a round face they are this near to the edge.


def test_at_an_edge_the_normal_says_which_face_is_meant():
    block = TrimmedFaces.of(read_graph(GRAPHS / "plain-block.npz"))
    corner = block.face_box[1].max(axis=0)
    for axis, normal in enumerate(np.eye(3)):
        beside = corner - 0.1 * np.eye(3)[axis - 1] - 5.0 * np.eye(3)[axis - 2]
        found = touched_face(block, beside, normal)
        assert found.normal_part @ normal > 1.0 - ROUND_OFF_MM
        assert abs(found.border_mm - 0.1) <= ROUND_OFF_MM


@pytest.mark.parametrize(
    ("p", "kind", "border_mm"), [([40.0, 0.0, 5.0], TouchKind.PLANE, 5.0), ([20.0, 25.0, 5.0], TouchKind.HOLE, 5.0)]
)
def test_faces_of_the_tee_have_the_words_of_a_taught_table(p, kind, border_mm):
    tee = TrimmedFaces.of(read_graph(GRAPHS / "tee.npz"))
    found = touched_face(tee, np.array(p))
    assert found.kind is kind
    assert abs(found.border_mm - border_mm) <= CHORD_MM
