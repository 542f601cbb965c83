"""The picker forgets nothing: after a reload, in a second window, after its server was killed, and in its files."""

import csv
import json
import shutil
from pathlib import Path
from typing import Any

import pytest

from tests.running import run_here

pytestmark = pytest.mark.usefixtures("kernel_here")
TEE = Path(__file__).parents[2] / "fixtures" / "tee"
PLACE = ("x_mm", "y_mm", "z_mm")
SAVED = "document.querySelector('#save-state').textContent.startsWith('saved')"
SECONDS_UNTIL_SEEN = 20  #: A window asks for the changes of others every second; the machine may be busy.


def rows_on(opened: Any) -> dict[str, tuple[str, ...]]:
    """The coordinates on the page, by the row's name."""
    opened.wait("window.wpcal.idle")
    return {
        line.get_attribute("data-name"): tuple(
            line.locator(f"input[aria-label={name}]").input_value() for name in PLACE
        )
        for line in opened.page.locator("#points tbody tr").all()
    }


def cell(opened: Any, row: str, column: str) -> Any:
    return opened.page.locator(f"tr[data-name='{row}'] [aria-label={column}]")


def said(opened: Any) -> str:
    return str(opened.page.inner_text("#save-state"))


def type_into(opened: Any, row: str, column: str, text: str) -> None:
    cell(opened, row, column).fill(text)
    opened.wait("window.wpcal.idle")


def save(opened: Any) -> None:
    opened.page.click("#save")
    opened.wait(SAVED)


def written(path: Path) -> dict[str, str]:
    """The x coordinates of a saved table, by name."""
    with path.open(encoding="utf-8", newline="") as file:
        return {row["name"]: row["x_mm"] for row in csv.DictReader(file)}


def appears(opened: Any, row: str, column: str, text: str) -> None:
    for _ in range(10 * SECONDS_UNTIL_SEEN):
        if cell(opened, row, column).input_value() == text:
            return
        opened.page.wait_for_timeout(100)
    raise AssertionError(f"{row}, {column} is {cell(opened, row, column).input_value()}, expected {text}")


@pytest.fixture
def taught(tmp_path: Path) -> Path:
    """A copy of the fixture's six rows, where the picker saves by default."""
    return Path(shutil.copy(TEE / "taught.csv", tmp_path / "taught.csv"))


@pytest.mark.deep
def test_an_existing_table_is_opened_and_saved_back(start: Any, open_page: Any, taught: Path) -> None:
    before = taught.read_bytes()
    opened = open_page(start(TEE / "tee.step").url)
    assert list(rows_on(opened)) == ["V2", "V4", "V16", "V12", "V6", "H1"]
    assert not taught.with_name("taught.csv.draft").exists()
    type_into(opened, "V4", "x_mm", "744.99")
    save(opened)
    assert "The version before is taught.csv.bak." in said(opened)
    assert written(taught)["V4"] == "744.99"
    assert len(written(taught)) == 6
    assert taught.with_name("taught.csv.bak").read_bytes() == before
    assert json.loads(taught.with_name("taught.csv.draft").read_text(encoding="utf-8"))["table"]["rows"] == []
    assert opened.said == []


@pytest.mark.deep
def test_a_reload_shows_what_was_typed_and_asks_nothing(start: Any, open_page: Any, taught: Path) -> None:
    opened = open_page(start(TEE / "tee.step").url)
    asked: list[str] = []
    opened.page.on("dialog", lambda dialog: (asked.append(dialog.type), dialog.accept()))
    opened.wait("window.wpcal.idle")
    cell(opened, "V4", "x_mm").fill("744.98")
    opened.page.reload()  # at once
    opened.wait("Boolean(window.wpcal && window.wpcal.ready)")
    appears(opened, "V4", "x_mm", "744.98")
    save(opened)
    opened.page.reload()
    opened.wait("Boolean(window.wpcal && window.wpcal.ready)")
    assert rows_on(opened)["V4"][0] == "744.98"
    save(opened)  # 4 rows became 1 here
    assert len(written(taught)) == 6
    assert asked == []


def test_a_killed_server_loses_nothing(start: Any, open_page: Any, tmp_path: Path) -> None:
    picker = start(TEE / "tee.step")
    opened = open_page(picker.url)
    for name, x in (("V2", "812.29"), ("V4", "")):
        opened.page.click("#add")
        opened.page.mouse.move(5, 5)  # away from the names that the browser offers: Enter takes the one below the mouse
        opened.page.keyboard.press("Shift+Tab")
        opened.page.keyboard.type(name)
        opened.page.keyboard.press("Enter")
        opened.page.keyboard.type(x)
        opened.page.keyboard.press("Tab")
    expected = rows_on(opened)
    assert expected == {"V2": ("812.29", "", ""), "V4": ("", "", "")}
    picker.kill()
    assert not (tmp_path / "taught.csv").exists()
    again = open_page(start(TEE / "tee.step").url)
    assert rows_on(again) == expected
    assert "taught.csv.draft: the page shows its rows" in again.page.inner_text("#notes")


def test_two_windows_show_each_other_and_revert_nothing(start: Any, open_page: Any, taught: Path) -> None:
    url = start(TEE / "tee.step").url
    first, second = open_page(url), open_page(url)
    type_into(first, "V4", "x_mm", "744.99")
    appears(second, "V4", "x_mm", "744.99")
    assert said(second) == "Changed in another window: V4."
    type_into(second, "V2", "z_mm", "165.99")
    save(second)
    appears(first, "V2", "z_mm", "165.99")
    save(first)
    assert rows_on(first) == rows_on(second)
    assert written(taught)["V4"] == "744.99"
    assert first.said == second.said == []


@pytest.mark.deep
def test_a_window_that_slept_takes_nothing_back(start: Any, open_page: Any, taught: Path) -> None:
    """The second window hears of nothing until it saves."""
    url = start(TEE / "tee.step").url
    first, second = open_page(url), open_page(url)
    first.wait("window.wpcal.idle")
    second.page.route("**/table", lambda route: route.abort())
    second.page.route("**/keep", lambda route: route.abort())
    cell(second, "V2", "x_mm").fill("812.99")
    type_into(first, "V4", "x_mm", "744.99")
    save(first)
    second.page.unroute("**/keep")
    save(second)
    assert {name: written(taught)[name] for name in ("V2", "V4")} == {"V2": "812.99", "V4": "744.99"}


@pytest.mark.deep
def test_one_cell_typed_in_two_windows_is_shown_with_both_texts(start: Any, open_page: Any, taught: Path) -> None:
    url = start(TEE / "tee.step").url
    first, second = open_page(url), open_page(url)
    second.wait("window.wpcal.idle")
    for name in ("**/table", "**/keep"):
        second.page.route(name, lambda route: route.abort())
    cell(second, "V4", "x_mm").fill("744.11")
    type_into(first, "V4", "x_mm", "744.99")
    save(first)
    for name in ("**/table", "**/keep"):
        second.page.unroute(name)
    for _ in range(3):  # whatever comes first, a Save is no choice between two texts
        second.page.click("#save")
        second.wait("document.querySelector('#save-state').textContent.includes('Two windows changed 1 cell')")
    assert "this window has 744.11, another window 744.99" in said(second)
    assert written(taught)["V4"] == "744.99"
    second.page.click("#save-state button >> text=Take the others")
    assert rows_on(second)["V4"][0] == "744.99"
    cell(second, "V4", "x_mm").fill("744.22")
    save(second)
    assert written(taught)["V4"] == "744.22"


def test_a_file_that_another_program_changed_is_opened_or_left_alone(start: Any, open_page: Any, taught: Path) -> None:
    opened = open_page(start(TEE / "tee.step").url)
    type_into(opened, "V4", "x_mm", "744.99")
    other = taught.read_text(encoding="utf-8").replace("812.29", "812.55")
    taught.write_text(other, encoding="utf-8")
    opened.page.click("#save")
    opened.wait("document.querySelector('#save-state').textContent.includes('was changed by another program')")
    assert taught.read_text(encoding="utf-8") == other
    opened.page.click("#save-state button >> text=Save as")
    assert opened.page.input_value("#save-as input") == "taught-2.csv"
    opened.page.keyboard.press("Enter")
    opened.wait(SAVED)
    assert written(taught.with_name("taught-2.csv"))["V4"] == "744.99"
    assert taught.read_text(encoding="utf-8") == other
    assert opened.page.inner_text("#save") == "Save taught-2.csv"
    assert "taught-2.csv" in opened.page.inner_text("#save-state code")


@pytest.mark.deep
def test_the_changed_file_is_opened_and_what_was_typed_comes_back(start: Any, open_page: Any, taught: Path) -> None:
    opened = open_page(start(TEE / "tee.step").url)
    type_into(opened, "V4", "x_mm", "744.99")
    taught.write_text(taught.read_text(encoding="utf-8").replace("812.29", "812.55"), encoding="utf-8")
    opened.page.click("#save")
    opened.page.click("#save-state button >> text=Open it")
    appears(opened, "V2", "x_mm", "812.55")
    assert rows_on(opened)["V4"][0] != "744.99"
    opened.page.click("#save-state button >> text=Undo")
    assert rows_on(opened)["V4"][0] == "744.99"
    save(opened)
    assert "812.55" in taught.with_name("taught.csv.bak").read_text(encoding="utf-8")


@pytest.mark.deep
def test_the_advised_template_is_a_list_of_what_to_touch_until_all_is_touched(
    start: Any, open_page: Any, tmp_path: Path
) -> None:
    assert run_here("advise", TEE / "tee.step", "--count", "4", "-o", "taught.csv", cwd=tmp_path).returncode == 0
    picker = start(TEE / "tee.step")
    opened = open_page(picker.url)
    names = list(rows_on(opened))
    assert len(names) == 4
    for column, text in zip(PLACE, ("812.29", "-240.62", "165.80"), strict=True):
        type_into(opened, names[0], column, text)
    save(opened)
    assert f"because coordinates are missing: {', '.join(names[1:])}." in said(opened)
    assert list(written(tmp_path / "taught.csv")) == names[:1]
    code, out, _ = picker.end()
    assert (code, "kept in taught.csv.draft" in out) == (0, True)
    again = open_page(start(TEE / "tee.step", "taught.csv").url)
    assert list(rows_on(again)) == names


@pytest.mark.deep
def test_when_the_disk_cannot_be_written_the_page_says_so(start: Any, open_page: Any, taught: Path) -> None:
    """A folder where the draft goes: writing fails, for any user."""
    opened = open_page(start(TEE / "tee.step").url)
    opened.wait("window.wpcal.idle")
    taught.with_name("taught.csv.draft").mkdir()
    type_into(opened, "V4", "x_mm", "744.99")
    opened.wait("document.querySelector('#save-state').textContent.startsWith('This change is not kept on disk')")
    opened.page.reload()
    opened.wait("Boolean(window.wpcal && window.wpcal.ready)")
    assert rows_on(opened)["V4"][0] == "744.99"
