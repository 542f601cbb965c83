"""The kinds of taught rows: one list that the reader of tables, the page and its documentation share."""

from pathlib import Path

import pytest

from wpcal.calibrate.observe.targets import TargetKind
from wpcal.core.errors import FormatError
from wpcal.taught.kinds import KINDS, TouchKind
from wpcal.taught.table import read_taught

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
