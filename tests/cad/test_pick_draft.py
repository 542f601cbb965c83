"""The draft beside the table: damaged, of another part, of another picker, of a killed server."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import pytest
from pick_tables import FOUR, PART, kept, names, notes_of, opened, saved, table_of

from cad.pick.draft import draft_of
from cad.pick.opening import find_table, start_table
from cad.pick.shared_table import FileChangedError
from cad.session.part import PickPart
from cad.session.rows import read_rows
from tests.few import few
from wpcal.core.errors import InputError

KILLS = 4


def test_every_change_is_on_disk_when_it_is_kept(out: Path) -> None:
    kept(opened(out), table_of("V2 1 2 3", "V4", "V6 7"))
    assert names(opened(out).rows) == ["V2", "V4", "V6"]
    assert opened(out).rows.cells[2][1:4] == ("7", "", "")
    assert not out.exists()


def test_a_draft_that_cannot_be_written_leaves_the_rows_in_memory(out: Path) -> None:
    shared = opened(out)
    draft_of(out).mkdir()
    assert "is a folder" in kept(shared, FOUR)["warning"]
    assert shared.changes_since(-1)["table"]["keys"] == list(FOUR.keys)
    answer = saved(shared)
    assert (answer["rows"], "is a folder" in answer["warning"]) == (4, True)
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
    assert "tee.step was changed after these rows were typed" in notes_of(out, newer)
    assert draft_of(out).read_bytes() == before


def test_a_saved_table_names_its_part(out: Path) -> None:
    shared = opened(out)
    kept(shared, FOUR)
    saved(shared)
    saved(shared, name="copy.csv")
    other = cast(PickPart, SimpleNamespace(file_name="other.step", sha256="b" * 64))
    newer = cast(PickPart, SimpleNamespace(file_name="tee.step", sha256="b" * 64))
    for table in (out, out.with_name("copy.csv")):
        assert notes_of(table) == ""
        with pytest.raises(InputError, match=r"csv: holds rows for another part, tee.step; give -o"):
            opened(table, other)
        assert notes_of(table, other, force=True) == "the rows were taught on another part, tee.step"
        assert notes_of(table, newer) == "tee.step was changed after these rows were typed; check their features"
    out.unlink()
    assert notes_of(out, other) == ""


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


LOOP = """
import sys
from pathlib import Path
from types import SimpleNamespace
from cad.pick.draft import Keyed
from cad.pick.opening import find_table, start_table
from cad.session.rows import NEW_COLUMNS, Rows
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


@pytest.mark.parametrize("step", few(range(KILLS), 1))
def test_a_server_killed_at_any_moment_leaves_whole_files(out: Path, step: int) -> None:
    """What was kept last, or the change that was on its way, is what the next start shows; it can be saved."""
    with subprocess.Popen([sys.executable, "-c", LOOP, str(out)], stdout=subprocess.PIPE, text=True) as process:
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
