"""What the programs of all controllers have in common."""

import numpy as np
import pytest

from wpcal.controllers.user_frames import ProgramReading, parse_uframes, points_in_base, usable_points
from wpcal.core.arrays import frozen
from wpcal.core.errors import ErrorCode, FormatError, InputError
from wpcal.taught import programs
from wpcal.taught.features import FeatureKind, ReferenceFeature
from wpcal.taught.table import TaughtPoints

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
