"""Typing and pasting in the picker's table: positions are read correctly, and the caret stays where it is.

A push runs what only a browser does; `numbers.test.js` and `rows.test.js` test what is read from a text.
"""

import json
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

import pytest

from tests.browser.conftest import OpenPage

TEE = Path(__file__).parents[2] / "fixtures" / "tee"
PLACE = ("x_mm", "y_mm", "z_mm")
FANUC = """\
P[1]{
   GP1:
\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX =   812.31  mm,\tY =  -240.64  mm,\tZ =   165.82  mm,
\tW =   180.000 deg,\tP =     0.000 deg,\tR =    90.000 deg
};
"""


@pytest.fixture(scope="module")
def address(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Address of a picker of the T-joint with its taught points."""
    folder = tmp_path_factory.mktemp("typing")
    shutil.copy(TEE / "taught.csv", folder)
    command = [sys.executable, "-m", "wpcal", "pick", str(TEE / "tee.step"), "--no-browser"]
    process = subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    said = process.stdout.readline()
    try:
        yield next(word for word in said.split() if word.startswith("http://127.0.0.1:"))
    finally:
        process.send_signal(signal.SIGINT)
        process.communicate(timeout=60)


@pytest.fixture(scope="module")
def window(address: str, browser: Any) -> Iterator[OpenPage]:
    """One window of the browser, which every test opens anew."""
    context = browser.new_context(viewport={"width": 1280, "height": 900})
    yield OpenPage(context.new_page())
    context.close()


@pytest.fixture
def table(address: str, window: OpenPage) -> Any:
    """The page with six complete rows: those of the file, whatever the test before typed and its page still sends."""
    window.wait("!window.wpcal || window.wpcal.idle")
    window.page.goto("about:blank")
    headers = {"Origin": address.rsplit("/", 2)[0], "Content-Type": "application/json"}
    assert "answer" in json.load(urlopen(Request(f"{address}open", b"{}", headers), timeout=60))
    window.page.goto(address)
    window.wait("Boolean(window.wpcal && window.wpcal.ready && window.wpcal.idle)")
    return window


def cell(opened: Any, row: str, column: str) -> Any:
    return opened.page.locator(f"tr[data-name='{row}'] [aria-label={column}]")


def place(opened: Any, row: str) -> tuple[str, ...]:
    return tuple(cell(opened, row, column).input_value() for column in PLACE)


def places(opened: Any) -> dict[str, tuple[str, ...]]:
    """All rows, read by one call."""
    found = opened.page.evaluate(
        """names => [...document.querySelectorAll("#points tbody tr")].map((row) => [
          row.dataset.name, names.map((name) => row.querySelector(`[aria-label=${name}]`).value),
        ])""",
        PLACE,
    )
    return {name: tuple(values) for name, values in found}


def names(opened: Any) -> list[str]:
    return list(places(opened))


def state(opened: Any) -> str:
    opened.wait("window.wpcal.idle")
    return str(opened.page.inner_text("#state"))


def paste(opened: Any, text: str) -> None:
    """Paste at the caret, as a keyboard does: first the page gets the event, then the browser pastes."""
    opened.page.evaluate(
        """text => {
          const clipboardData = new DataTransfer();
          clipboardData.setData("text/plain", text);
          const event = new ClipboardEvent("paste", { clipboardData, bubbles: true, cancelable: true });
          if (document.activeElement.dispatchEvent(event)) document.execCommand("insertText", false, text);
        }""",
        text,
    )
    opened.wait("window.wpcal.idle")


def undo(opened: Any) -> None:
    opened.page.locator("#save-state button").click()
    opened.wait("window.wpcal.idle")


POSITIONS = {
    "spreadsheet": "812.31\t-240.64\t165.82\r\n",
    "decimal commas": "812,31;-240,64;165,82",
    "one below the other": "812.31\n-240.64\n165.82\n",
    "FANUC": FANUC,
}
"""How the browser hands on what was pasted; `numbers.test.js` has all ways to write a position."""


def test_a_position_fills_its_row_however_it_is_written(table: Any) -> None:
    before = places(table)
    for kind, text in POSITIONS.items():
        cell(table, "V2", "y_mm").focus()
        paste(table, text)
        assert places(table) == {**before, "V2": ("812.31", "-240.64", "165.82")}, kind
        undo(table)
    assert places(table) == before
    assert table.said == []


@pytest.mark.deep
def test_thousands_are_no_further_numbers(table: Any) -> None:
    for text in ("1.812,29 -240,62 165,80", "1,812.29 -240.62 165.80"):
        cell(table, "V2", "x_mm").focus()
        paste(table, text)
        assert place(table, "V2") == ("1812.29", "-240.62", "165.80")
        undo(table)


@pytest.mark.deep
def test_named_positions_go_to_their_rows_and_others_down_the_table(table: Any) -> None:
    cell(table, "V2", "x_mm").focus()
    paste(table, "V12 1 2 3\nV4 4 5 6\nV14 7 8 9")
    assert [place(table, name) for name in ("V12", "V4", "V14")] == [("1", "2", "3"), ("4", "5", "6"), ("7", "8", "9")]
    assert place(table, "V2") == ("812.29", "-240.62", "165.80")
    assert cell(table, "V14", "feature").input_value() == "V14"
    undo(table)
    assert len(names(table)) == 6
    cell(table, "V4", "x_mm").focus()
    paste(table, "1 2 3\n4 5 6")
    assert [place(table, name) for name in ("V4", "V16")] == [("1", "2", "3"), ("4", "5", "6")]


def test_a_copied_table_is_pasted_into_an_empty_page(table: Any) -> None:
    before = places(table)
    text = (TEE / "taught.csv").read_text(encoding="utf-8")
    while names(table):
        table.page.locator(".remove").first.click()
    table.page.evaluate("document.activeElement.blur()")
    paste(table, text)
    table.wait("document.querySelectorAll('#points tbody tr').length === 6")
    assert places(table) == before


def test_answers_leave_caret_text_and_undo_alone(table: Any) -> None:
    """Each key is answered before the next one, so that a redraw that moved the caret would show."""
    x = cell(table, "V2", "x_mm")
    x.press("Home")
    for key in "-12":
        table.page.keyboard.type(key)
        table.wait("window.wpcal.idle")
    where = "[document.activeElement.value, document.activeElement.selectionStart]"
    assert table.page.evaluate(where) == ["-12812.29", 3]
    for _ in range(3):
        table.page.keyboard.press("Control+z")
    table.wait("window.wpcal.idle")
    assert x.input_value() == "812.29"


def test_a_decimal_comma_becomes_a_point_when_the_hand_leaves(table: Any) -> None:
    x = cell(table, "V2", "x_mm")
    x.fill("")
    table.page.keyboard.type("812,29")
    assert "within" in state(table)
    assert x.input_value() == "812,29"
    x.press("Tab")
    assert x.input_value() == "812.29"


def test_a_row_that_comes_or_goes_leaves_the_others_as_they_are(table: Any) -> None:
    """The browser's own undo of a cell lives as long as its element."""
    y = cell(table, "V12", "y_mm")
    y.focus()
    table.page.keyboard.press("End")
    table.page.keyboard.type("7")
    table.wait("window.wpcal.idle")
    text = b"name,x_mm,y_mm,z_mm\nV14,977.41,-127.90,172.75\n"
    table.page.locator("#file").set_input_files({"name": "more.csv", "mimeType": "text/csv", "buffer": text})
    table.wait("document.querySelectorAll('#points tbody tr').length === 7")
    table.page.keyboard.press("Control+z")
    table.wait("window.wpcal.idle")
    assert y.input_value() == "-92.01"


@pytest.mark.deep
def test_reading_a_table_leaves_the_caret_where_it_is(table: Any) -> None:
    """Further columns build the table anew."""
    y = cell(table, "V12", "y_mm")
    y.fill("-92.015")
    table.page.evaluate("document.activeElement.setSelectionRange(2, 2)")
    text = "name,x_mm,y_mm,z_mm,sigma_mm\nV14,977.41,-127.90,172.75,0.1\n"
    table.page.locator("#file").set_input_files({"name": "more.csv", "mimeType": "text/csv", "buffer": text.encode()})
    table.wait("document.querySelectorAll('#points tbody tr').length === 7")
    found = "(({ ariaLabel, value, selectionStart }) => [ariaLabel, value, selectionStart])(document.activeElement)"
    assert table.page.evaluate(found) == ["y_mm", "-92.015", 2]
    assert table.page.evaluate("document.activeElement.closest('tr').dataset.name") == "V12"


@pytest.mark.deep
@pytest.mark.parametrize("begun", ["12,", "-", "1e"])
def test_a_number_that_is_begun_waits_until_the_hand_leaves(table: Any, begun: str) -> None:
    y = cell(table, "V4", "y_mm")
    y.fill("")
    table.page.keyboard.type(begun)
    assert "1 row has no coordinates yet" in state(table)
    y.press("Tab")
    assert state(table).startswith("V4, y_mm: ")
    assert y.get_attribute("aria-invalid") == "true"


@pytest.mark.deep
def test_a_row_that_was_taken_away_comes_back(table: Any) -> None:
    before = places(table)
    table.page.locator(".remove").nth(1).press("Enter")
    assert names(table) == [name for name in before if name != "V4"]
    assert table.page.evaluate("document.activeElement.getAttribute('aria-label')") == "remove V16"
    table.page.keyboard.press("Control+z")
    table.wait("window.wpcal.idle")
    assert places(table) == before


@pytest.mark.deep
def test_a_file_read_again_replaces_its_points_and_keeps_what_they_are_for(table: Any) -> None:
    text = "name,x_mm,y_mm,z_mm\nV2,812.29,-240.62,165.80\nV6,799.97,-183.30,247.66\n"
    file = {"name": "again.csv", "mimeType": "text/csv", "buffer": text.encode()}
    for said in ("again.csv: 2 points, 1 replaced.", "again.csv: 2 points, all in the table already."):
        table.page.locator("#file").set_input_files(file)
        table.wait(f"document.querySelector('#save-state').textContent.startsWith({json.dumps(said)})")
    assert place(table, "V6") == ("799.97", "-183.30", "247.66")
    assert cell(table, "V6", "use").input_value() == "check"
    assert len(names(table)) == 6


@pytest.mark.deep
def test_a_row_without_a_feature_is_called_like_the_one_typed_into_it(table: Any) -> None:
    keyboard = table.page.keyboard
    table.page.click("#add")
    keyboard.press("Shift+Tab")
    keyboard.type("v14")
    keyboard.press("Enter")
    for value in ("977.41", "-127.90", "172.75"):
        keyboard.type(value)
        keyboard.press("Enter")
    assert "within" in state(table)
    assert names(table)[-1] == "V14"
    assert cell(table, "V14", "feature").input_value() == "V14"


def test_what_was_saved_stays_said_when_the_caret_leaves_the_cell(table: Any) -> None:
    answer = {
        "rows": 6,
        "file": "taught.csv",
        "left_out": [],
        "command": "",
        "backup": "",
        "warning": "",
        "revision": 9,
    }
    table.page.route("**/save", lambda route: route.fulfill(json={"answer": answer}))
    y = cell(table, "V4", "y_mm")
    y.fill("-141.5")
    y.press("Control+s")
    table.wait("document.querySelector('#save-state').textContent.startsWith('saved 6 rows')")
    y.press("Tab")
    table.wait("window.wpcal.idle")
    assert table.page.inner_text("#save-state").startswith("saved 6 rows")


@pytest.mark.deep
def test_a_row_touched_on_the_neighbouring_corner_takes_its_name_with_one_click(table: Any) -> None:
    cell(table, "V2", "y_mm").focus()
    paste(table, "812.50 -240.25 155.75")  # V1, the corner 10 mm below V2
    assert state(table).startswith("FAIL: V1 instead of V2 leaves")
    top, points = (table.page.locator(name).bounding_box()["y"] for name in ("#notes", "#points"))
    assert top < points  # the notes are directly under the verdict
    table.page.locator("#notes button.exchange").click()
    table.wait("window.wpcal.idle")
    assert "V1 instead of V2" not in state(table)
    assert table.page.locator("#notes button.exchange").count() == 0
    undo(table)
    assert "V1 instead of V2" in state(table)
