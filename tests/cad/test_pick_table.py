"""The table that all windows share: nothing typed is lost, whatever happens to windows, files and processes."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest

import cad.pick.shared_table as module
from cad.pick.draft import Draft, Keyed, draft_of, read_draft
from cad.pick.opening import find_table, start_table
from cad.pick.part import PickPart
from cad.pick.rows import NEW_COLUMNS, Rows, read_rows
from cad.pick.shared_table import FileChangedError, SharedTable
from wpcal.advise import advise
from wpcal.advise.advice import template_csv
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import sha256_of

PART = cast(PickPart, SimpleNamespace(file_name="tee.step", sha256="a" * 64))
CONCURRENT_SAVES = 60
KILLS = 4


def table_of(*rows: str) -> Keyed:
    """Rows such as ``V2 1 2 3``; a name alone is a row without coordinates. The keys are the names."""
    cells = [(*row.split(), "", "", "")[:4] for row in rows]
    return Keyed(Rows(NEW_COLUMNS, tuple((*row, row[0], "yes") for row in cells)), tuple(row[0] for row in cells))


def opened(out: Path, part: PickPart = PART, **more: Any) -> SharedTable:
    return start_table(find_table(out), part, part_step=Path("none.step"), **more)[0]


def notes_of(out: Path, part: PickPart = PART, **more: Any) -> str:
    return "\n".join(start_table(find_table(out), part, part_step=Path("none.step"), **more)[1])


def kept(shared: SharedTable, table: Keyed, *, window: str = "w") -> dict[str, Any]:
    revision = shared.changes_since(-1)["revision"]
    return shared.keep(table, revision=revision, window=window, number=revision)


def saved(shared: SharedTable, **more: Any) -> dict[str, Any]:
    return shared.save(revision=shared.changes_since(-1)["revision"], **more)


def names(rows: Rows) -> list[str]:
    return [row[0] for row in rows.cells]


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "taught.csv"


FOUR = table_of("V2 1 2 3", "V4 4 5 6", "V6 7 8 9", "V8 1 1 1")


def test_what_was_saved_is_there_again_and_is_not_overwritten_by_one_row(out: Path) -> None:
    shared = opened(out)
    kept(shared, FOUR)
    assert saved(shared)["rows"] == 4
    assert not draft_of(out).exists()
    again = opened(out)
    assert names(again.rows) == ["V2", "V4", "V6", "V8"]
    more = Keyed(Rows(again.rows.columns, (*again.rows.cells, table_of("H1 9 9 9").rows.cells[0])), tuple("abcde"))
    kept(again, more)
    assert saved(again)["rows"] == 5


def test_every_change_is_on_disk_when_it_is_kept(out: Path) -> None:
    kept(opened(out), table_of("V2 1 2 3", "V4", "V6 7"))
    assert names(opened(out).rows) == ["V2", "V4", "V6"]
    assert opened(out).rows.cells[2][1:4] == ("7", "", "")
    assert not out.exists()


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
    assert not out.with_name("new.csv.draft").exists()


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


def test_a_draft_that_cannot_be_written_leaves_the_rows_in_memory(out: Path) -> None:
    shared = opened(out)
    draft_of(out).mkdir()
    assert "is a directory" in kept(shared, FOUR)["warning"]
    assert shared.changes_since(-1)["table"]["keys"] == list(FOUR.keys)
    answer = saved(shared)
    assert (answer["rows"], "is a directory" in answer["warning"]) == (4, True)
    draft_of(out).rmdir()
    assert names(opened(out).rows) == names(FOUR.rows)


DAMAGE: dict[str, Any] = {
    "half": lambda text: text[: len(text) // 2],
    "empty": lambda text: "",
    "binary": lambda text: "\x00\x01",
    "list": lambda text: "[]",
    "schema": lambda text: text.replace("pick-draft/1", "pick-draft/9"),
    "keys": lambda text: text.replace('"keys"', '"locks"'),
    "numbers": lambda text: json.dumps({**json.loads(text), "part": {"file": 1, "sha256": 2}}),
    "table": lambda text: json.dumps({**json.loads(text), "table": None}),
}


@pytest.mark.parametrize("kind", DAMAGE)
def test_a_damaged_draft_is_kept_aside(out: Path, kind: str) -> None:
    shared = opened(out)
    kept(shared, FOUR)
    saved(shared)
    kept(shared, table_of("V2 1 2 4"))
    text = DAMAGE[kind](draft_of(out).read_text(encoding="utf-8"))
    draft_of(out).write_text(text, encoding="utf-8")
    for ending in (".damaged", ".damaged1"):
        (note,) = start_table(find_table(out), PART, part_step=Path("none.step"))[1]
        assert note.count("\n") == 0
        assert note.endswith(f"the damaged draft was renamed to {draft_of(out)}{ending}")
        assert Path(f"{draft_of(out)}{ending}").read_text(encoding="utf-8") == text
        draft_of(out).write_text(text, encoding="utf-8")
    draft_of(out).unlink()
    assert names(opened(out).rows) == names(FOUR.rows)


def test_a_draft_that_is_damaged_meanwhile_is_kept_aside_and_written_again(out: Path) -> None:
    shared = opened(out)
    kept(shared, FOUR)
    draft_of(out).write_text("{", encoding="utf-8")
    shared.changes_since(-1)
    assert names(opened(out).rows) == names(FOUR.rows)
    assert Path(f"{draft_of(out)}.damaged").read_text(encoding="utf-8") == "{"


def test_the_draft_of_another_part_is_told(out: Path) -> None:
    kept(opened(out), FOUR)
    before = draft_of(out).read_bytes()
    other = cast(PickPart, SimpleNamespace(file_name="other.step", sha256="b" * 64))
    with pytest.raises(InputError, match=r"holds rows for another part, tee.step; give -o"):
        opened(out, other)
    assert "taught on another part, tee.step" in notes_of(out, other, force=True)
    newer = cast(PickPart, SimpleNamespace(file_name="tee.step", sha256="b" * 64))
    assert "tee.step was changed after the draft was made" in notes_of(out, newer)
    assert draft_of(out).read_bytes() == before


def test_a_picker_of_another_part_does_not_touch_the_draft(out: Path) -> None:
    """Both were started when there was no draft yet."""
    first, other = opened(out), opened(out, cast(PickPart, SimpleNamespace(file_name="b.step", sha256="b" * 64)))
    kept(first, FOUR)
    before = draft_of(out).read_bytes()
    assert "belongs to another part" in kept(other, table_of("H1 1 2 3"))["warning"]
    saved(other, name="other.csv")
    assert draft_of(out).read_bytes() == before
    assert saved(first)["rows"] == 4


def test_two_pickers_of_one_table_see_each_other(out: Path) -> None:
    first, second = opened(out), opened(out)
    revision = second.changes_since(-1)["revision"]
    kept(first, FOUR)
    assert second.changes_since(revision)["table"]["keys"] == list(FOUR.keys)
    assert second.keep(table_of("H1 1 2 3"), revision=revision, window="b", number=1)["is_stale"]
    saved(first)
    kept(second, table_of("H1 1 2 3"))
    with pytest.raises(FileChangedError):
        saved(second)
    assert names(read_rows(out.read_bytes(), path="")) == names(FOUR.rows)


def test_a_crash_between_file_and_draft_is_no_change_by_another_program(out: Path) -> None:
    shared = opened(out)
    kept(shared, table_of("V2 1 2 3", "V4"))
    before = draft_of(out).read_bytes()
    saved(shared)
    draft_of(out).write_bytes(before)  # as it was when the file was renamed
    again = opened(out)
    assert names(again.rows) == ["V2", "V4"]
    assert notes_of(out) == ""
    kept(again, table_of("V2 1 2 4", "V4"))
    assert saved(again)["rows"] == 1


def test_a_draft_whose_file_was_changed_meanwhile_is_told_and_asks(out: Path) -> None:
    shared = opened(out)
    kept(shared, FOUR)
    saved(shared)
    kept(shared, table_of("V2 1 2 4"))
    assert "the page shows its rows" in notes_of(out)
    out.write_text("name,x_mm,y_mm,z_mm\nH1,1,2,3\n", encoding="utf-8")
    assert "was changed by another program after the draft was made" in notes_of(out)
    with pytest.raises(FileChangedError):
        saved(opened(out))
    out.unlink()
    assert "was removed after the draft was made" in notes_of(out)
    assert saved(opened(out))["rows"] == 1


def test_an_empty_draft_does_not_hide_the_file(out: Path) -> None:
    shared = opened(out)
    kept(shared, FOUR)
    saved(shared)
    kept(shared, table_of())
    assert names(opened(out).rows) == names(FOUR.rows)


def test_other_rows_do_not_hide_a_draft_nor_overwrite_a_file(out: Path) -> None:
    given = table_of("H1 1 2 3").rows
    out.write_text("name,x_mm,y_mm,z_mm\nV2,1,2,3\n", encoding="utf-8")
    shared = opened(out, given=given, given_name="points.csv")
    assert names(shared.rows) == ["H1"]
    assert "exists and is not shown here" in notes_of(out, given=given, given_name="points.csv")
    with pytest.raises(FileChangedError, match="exists, and its rows are not shown here"):
        saved(shared)
    kept(shared, FOUR)
    assert names(opened(out, given=given, given_name="points.csv").rows) == names(FOUR.rows)
    assert "points.csv was not read" in notes_of(out, given=given, given_name="points.csv")


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
    assert sorted(path.name for path in out.parent.iterdir()) == ["taught.csv", "taught.csv.bak"]


LOOP = """
import sys
from pathlib import Path
from types import SimpleNamespace
from cad.pick.draft import Keyed
from cad.pick.opening import find_table, start_table
from cad.pick.rows import NEW_COLUMNS, Rows
part = SimpleNamespace(file_name="tee.step", sha256="a" * 64)
table, _ = start_table(find_table(Path(sys.argv[1])), part, part_step=Path("none.step"))
for count in range(1, 1_000_000):
    cells = tuple((f"T{i}", str(count), "0", "0", "", "yes") for i in range(200)) + (("W", "", "", "", "", "yes"),)
    revision = table.changes_since(-1)["revision"]
    rows = Keyed(Rows(NEW_COLUMNS, cells), tuple(str(i) for i in range(201)))
    kept = table.keep(rows, revision=revision, window="w", number=count)
    print(count, flush=True)
    table.save(revision=kept["revision"])
"""


@pytest.mark.parametrize("step", range(KILLS))
def test_a_server_killed_at_any_moment_leaves_whole_files(out: Path, step: int) -> None:
    """What was kept last, or the change that was on its way, is what the next start shows; it can be saved."""
    with subprocess.Popen([sys.executable, "-c", LOOP, str(out)], stdout=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None
        for _ in range(7 * step + 1):
            process.stdout.readline()
        os.kill(process.pid, signal.SIGKILL)
        acknowledged = [int(line) for line in process.stdout.read().split()]
    again = opened(out)
    values = {row[1] for row in again.rows.cells[:200]}
    assert len(again.rows.cells) == 201
    assert len(values) == 1
    last = acknowledged[-1] if acknowledged else 7 * step + 1
    assert int(values.pop()) in (last, last + 1)
    assert saved(again)["left_out"] == ["W"]


def test_a_template_of_advise_opens_as_the_list_of_what_to_touch(tee_for_the_picker: PickPart, out: Path) -> None:
    part = tee_for_the_picker
    seams = [seam for seam in part.seams if seam.accepted]
    points = [item for item in part.touchables if item.feature.kind.is_point]
    out.write_text(template_csv(advise(points, seams, points=4, sigma_mm=0.3)), encoding="utf-8")
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
