import pickle

import pytest

from wpcal.core import errors
from wpcal.core.errors import ConvergenceError, ErrorCode, FormatError, GeometryError, WpcalError, blamed_on


def _classes(base: type[WpcalError] = WpcalError) -> list[type[WpcalError]]:
    return [
        base,
        *(c for child in base.__subclasses__() if child.__module__ == errors.__name__ for c in _classes(child)),
    ]


@pytest.mark.parametrize("kind", _classes())
def test_every_error_has_the_code_of_its_class_unless_told_otherwise(kind: type[WpcalError]) -> None:
    assert kind("what").code == kind.code in set(ErrorCode)
    assert kind("what", code=ErrorCode.EXISTS).code == "exists"


@pytest.mark.parametrize("kind", _classes())
def test_a_code_survives_the_way_out_of_a_child_process(kind: type[WpcalError]) -> None:
    back = pickle.loads(pickle.dumps(kind("what", code=ErrorCode.USER_FRAME_MISSING)))
    assert (type(back), str(back), back.code) == (kind, "what", "user-frame-missing")


def test_the_place_and_the_best_answer_survive_too() -> None:
    back = pickle.loads(pickle.dumps(FormatError("what", path="a.csv", line=3, column="x_mm")))
    assert (str(back), back.what, back.line) == ("a.csv, line 3, column x_mm: what", "what", 3)
    assert pickle.loads(pickle.dumps(ConvergenceError("what", best=2.5))).best == 2.5


def test_naming_the_file_keeps_the_code() -> None:
    with pytest.raises(GeometryError, match=r"^part\.step: collinear$") as caught, blamed_on("part.step"):
        raise GeometryError("collinear", code="on-a-line")
    assert caught.value.code == "on-a-line"
