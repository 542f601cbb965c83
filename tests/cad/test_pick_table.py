"""The table that all windows share: nothing typed is lost, whatever happens to windows, files and processes."""

from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from pick_tables import FOUR, kept, names, opened, saved, table_of

import cad.pick.shared_table as module
from cad.pick.draft import Draft, Keyed, draft_of, read_draft
from cad.pick.shared_table import ConflictError, FileChangedError
from cad.session.part import PickPart
from cad.session.rows import NEW_COLUMNS, Rows, read_rows
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import sha256_of
from wpcal.touch.advice import advise, template_csv

CONCURRENT_SAVES = 60


def test_what_was_saved_is_there_again_and_is_not_overwritten_by_one_row(out: Path) -> None:
    shared = opened(out)
    kept(shared, FOUR)
    assert saved(shared)["rows"] == 4
    assert (shared.kept, read_draft(draft_of(out)).table.rows.cells) == ("", ())
    again = opened(out)
    assert names(again.rows) == ["V2", "V4", "V6", "V8"]
    more = Keyed(Rows(again.rows.columns, (*again.rows.cells, table_of("H1 9 9 9").rows.cells[0])), tuple("abcde"))
    kept(again, more)
    assert saved(again)["rows"] == 5


def test_rows_without_coordinates_stay_in_the_draft_after_save(out: Path) -> None:
    shared = opened(out)
    kept(shared, table_of("V2 1 2 3", "V4"))
    assert saved(shared)["left_out"] == ["V4"]
    assert names(opened(out).rows) == ["V2", "V4"]
    assert names(read_rows(out.read_bytes(), path="")) == ["V2"]
    assert saved(opened(out))["rows"] == 1  # the file is that of the draft


def test_a_stale_change_is_refused_with_the_present_table(out: Path) -> None:
    shared = opened(out)
    first = shared.changes_since(-1)["revision"]
    shared.keep(table_of("V2 1 2 3"), revision=first, window="a", number=1)
    answer = shared.keep(table_of("V4 1 2 3"), revision=first, window="b", number=1)
    assert answer["is_stale"]
    assert [row[0] for row in answer["table"]["rows"]] == ["V2"]
    assert names(shared.rows) == ["V2"]
    stale = shared.save(revision=first)
    assert stale["is_stale"]
    assert not out.exists()


def test_a_save_says_when_it_holds_more_than_the_window_showed_at_the_click(out: Path) -> None:
    """Another window types between what the person saw and the click."""
    shared = opened(out)
    seen = kept(shared, FOUR, window="a")["revision"]
    theirs = kept(shared, table_of("V2 1 2 9", "V4 4 5 6"), window="b")["revision"]
    merged = table_of("V2 1 2 9", "V4 4 5 7")
    mine = shared.keep(merged, revision=theirs, window="a", number=99)["revision"]
    assert shared.save(revision=mine, shown=seen, window="a")["has_news"]
    own = shared.keep(table_of("V2 1 2 9", "V4 4 5 8"), revision=mine, window="a", number=100)["revision"]
    assert not shared.save(revision=own, shown=mine, window="a")["has_news"]  # only its own change came after


def test_consent_names_exactly_the_conflicts_that_were_shown(out: Path) -> None:
    """A click on Save in the instant in which a conflict appears is no consent to it."""
    shared = opened(out)
    revision = kept(shared, FOUR, window="b")["revision"]
    conflicts = ("V2, z_mm: 3 or 9", "V4, z_mm: 6 or 9")

    def mine(number: int, said: tuple[str, ...]) -> int:
        now = shared.changes_since(-1)["revision"]
        return int(shared.keep(FOUR, revision=now, window="a", number=number, conflicts=said)["revision"])

    revision = mine(1, conflicts[:1])
    with pytest.raises(ConflictError, match="choose between the texts"):
        shared.save(revision=revision, shown=revision, window="a")
    revision = mine(2, conflicts)  # a second conflict appears while the first is being answered
    with pytest.raises(ConflictError):
        shared.save(revision=revision, shown=revision, window="a", consent=conflicts[:1])
    assert not out.exists()
    assert shared.save(revision=revision, shown=revision, window="a", consent=conflicts)["rows"] == 4
    assert shared.save(revision=revision, shown=revision, window="a")["rows"] == 4  # it was answered
    other = mine(3, conflicts)
    assert shared.save(revision=other, shown=other, window="b")["rows"] == 4  # that window shows the text it saves


def test_the_last_words_of_a_window_count_and_come_in_any_order(out: Path) -> None:
    """A window that closes sends its last change without the answer to the one before."""
    shared = opened(out)
    revision = shared.changes_since(-1)["revision"]
    for number, row in ((1, "V2 1"), (3, "V2 1 2 3"), (2, "V2 1 2")):
        assert "is_stale" not in shared.keep(table_of(row), revision=revision, window="a", number=number)
    assert shared.rows.cells[0][1:4] == ("1", "2", "3")


def test_save_keeps_the_version_before(out: Path) -> None:
    shared = opened(out)
    kept(shared, FOUR)
    assert saved(shared)["backup"] == ""
    before = out.read_bytes()
    kept(shared, table_of("V2 1 2 3"))
    assert saved(shared)["backup"] == str(out) + ".bak"
    assert Path(f"{out}.bak").read_bytes() == before
    assert saved(shared)["backup"] == ""  # nothing changed, so the version before stays
    assert Path(f"{out}.bak").read_bytes() == before


@pytest.mark.parametrize("begins_with", [None, "name,x_mm,y_mm,z_mm\nV2,1,2,3\n"])
def test_a_file_of_another_program_is_replaced_only_by_consent(out: Path, begins_with: str | None) -> None:
    if begins_with:
        out.write_text(begins_with, encoding="utf-8")
    shared = opened(out)
    kept(shared, FOUR)
    out.write_text("precious", encoding="utf-8")
    with pytest.raises(FileChangedError) as caught:
        saved(shared)
    assert out.read_text(encoding="utf-8") == "precious"
    out.write_text("more precious", encoding="utf-8")
    with pytest.raises(FileChangedError):
        saved(shared, replaces=caught.value.sha256)  # consent was given for another content
    assert saved(shared, replaces=sha256_of(b"more precious"))["rows"] == 4
    assert Path(f"{out}.bak").read_text(encoding="utf-8") == "more precious"


def test_opening_the_file_takes_its_rows_and_keeps_those_before(out: Path) -> None:
    out.write_text("name,x_mm,y_mm,z_mm\nV2,1,2,3\n", encoding="utf-8")
    shared = opened(out)
    kept(shared, FOUR)
    out.write_text("name,x_mm,y_mm,z_mm\nH1,1,2,3\nH2,4,5,6\n", encoding="utf-8")
    shared.open_file()
    assert names(shared.rows) == ["H1", "H2"]
    assert saved(shared)["rows"] == 2
    assert names(read_draft(Path(f"{draft_of(out)}.bak")).table.rows) == names(FOUR.rows)


def test_save_as_takes_a_new_name_only(out: Path) -> None:
    shared = opened(out)
    kept(shared, table_of("V2 1 2 3", "V4"))
    out.with_name("there.csv").write_text("mine", encoding="utf-8")
    for name in ("there.csv", "../x.csv", "/tmp/x.csv", "", "..", "x.bak", "taught.csv.draft", "a\0b"):
        if name:
            with pytest.raises(InputError):
                saved(shared, name=name)
    assert saved(shared, name="new.csv")["file"] == str(out.with_name("new.csv"))
    assert sorted(path.name for path in out.parent.iterdir()) == ["new.csv", "new.csv.draft", "there.csv"]
    kept(shared, table_of("V2 1 2 3", "V4 4 5 6"))
    assert saved(shared)["file"] == str(out.with_name("new.csv"))
    assert shared.kept == ""


def test_what_cannot_be_read_is_not_saved(out: Path) -> None:
    shared = opened(out)
    with pytest.raises(InputError, match="nothing to save"):
        saved(shared)
    kept(shared, Keyed(table_of("V2 1 2 3", "V2 4 5 6").rows, ("a", "b")))
    with pytest.raises(FormatError, match="appears twice"):
        saved(shared)
    assert not out.exists()


def test_a_read_only_file_stays(out: Path) -> None:
    out.write_text("name,x_mm,y_mm,z_mm\nV2,1,2,3\n", encoding="utf-8")
    out.chmod(0o444)
    shared = opened(out)
    kept(shared, FOUR)
    with pytest.raises(InputError, match="is read-only") as caught:
        saved(shared)
    assert caught.value.code == "file-read-only"
    assert out.read_text(encoding="utf-8").endswith("V2,1,2,3\n")
    assert names(opened(out).rows) == names(FOUR.rows)


def test_a_full_disk_leaves_file_and_draft_as_they_were(out: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    shared = opened(out)
    kept(shared, FOUR)
    saved(shared)
    kept(shared, table_of("V2 1 2 4"))
    before = {path.name: path.read_bytes() for path in out.parent.iterdir()}

    def full(path: Path, data: Any, *, overwrite: bool) -> None:
        raise InputError(f"{path}: cannot be written: no space left on device")

    monkeypatch.setattr(module, "write_file", full)
    assert "no space left" in kept(shared, table_of("V2 5 5 5"))["warning"]
    with pytest.raises(InputError, match="no space left"):
        saved(shared)
    assert {path.name: path.read_bytes() for path in out.parent.iterdir()} == before
    monkeypatch.undo()
    assert saved(shared)["rows"] == 1  # the page kept what was typed
    assert shared.rows.cells[0][1] == "5"


def test_many_saves_at_once_leave_one_whole_file(out: Path) -> None:
    shared = opened(out)

    def one(number: int) -> None:
        for _ in range(1000):
            state = shared.changes_since(-1)
            have = Keyed.from_record(state["table"])
            row = table_of(f"T{number} {number} 0 0")
            rows = Rows(NEW_COLUMNS, (*have.rows.cells, *row.rows.cells))
            change = {"revision": state["revision"], "window": f"w{number}", "number": state["revision"]}
            if "is_stale" not in shared.keep(Keyed(rows, (*have.keys, *row.keys)), **change):
                break
        while saved(shared).get("is_stale"):
            pass

    with ThreadPoolExecutor(CONCURRENT_SAVES) as pool:
        list(pool.map(one, range(CONCURRENT_SAVES)))
    assert sorted(names(read_rows(out.read_bytes(), path=""))) == sorted(f"T{i}" for i in range(CONCURRENT_SAVES))
    assert sorted(path.name for path in out.parent.iterdir()) == ["taught.csv", "taught.csv.bak", "taught.csv.draft"]


def test_a_template_of_advise_opens_as_the_list_of_what_to_touch(tee_for_the_picker: PickPart, out: Path) -> None:
    part = tee_for_the_picker
    seams = [seam for seam in part.seams if seam.accepted]
    points = [item for item in part.touchables if item.feature.kind.is_point]
    out.write_text(template_csv(advise(points, seams, points=4, sigma_mm=0.3).template_rows()), encoding="utf-8")
    shared = opened(out, part)
    assert len(shared.rows.cells) == 4
    assert shared.rows.complete() == ()
    first, *others = (list(row) for row in shared.rows.cells)
    first[1:4] = ["1", "2", "3"]
    keys: Sequence[str] = shared.changes_since(-1)["table"]["keys"]
    cells = (tuple(first), *map(tuple, others))
    kept(shared, Keyed(replace(shared.rows, cells=cells), tuple(keys)))
    assert len(saved(shared)["left_out"]) == 3
    assert opened(out, part).rows.cells == cells
    assert isinstance(read_draft(draft_of(out)), Draft)
