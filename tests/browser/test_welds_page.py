"""The page of `wpcal welds --html` in a browser: values are set by keyboard, and what it saves loses nothing."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from tests.running import run_here
from tests.unit.conftest import write_finished_folder
from wpcal.core.transform import RigidTransform

FILE = "welds-edited.json"


def cell(seam: str, value: str) -> str:
    return f'[data-cell="{seam} {value}"]'


def said(opened: Any, text: str) -> None:
    opened.wait(f"document.querySelector('.said').textContent.includes({json.dumps(text)})")


def stated(record: Any) -> dict[str, dict[str, Any]]:
    """Return what a person stated, by seam."""
    return {
        weld["name"]: {
            name: weld["values"][name] for name, origin in weld["origin"].items() if origin["from"] == "user"
        }
        for weld in record["welds"]
    }


def welds(*words: str | Path) -> Any:
    done = run_here("welds", *words, "--json")
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_values_are_set_by_keyboard_and_the_saved_file_loses_nothing(open_page: Any, tmp_path: Path) -> None:
    T = RigidTransform(np.eye(3), np.array([900.0, -200.0, 400.0]), "base", "part")
    seams = {"names": ("W1", "W2", "W3", "W4"), "accepted": (True, True, True, False), "spacing_mm": 10.0}
    folder = write_finished_folder(tmp_path / "calibrated", T, **seams)
    file, page = tmp_path / "welds.json", tmp_path / "welds.html"
    given = ["--set", "W1:leg_mm=5", "--set", "W1:weave=null", "--set", "W4:job=7"]
    welds(folder, "-o", file, *given, "--html", page)
    opened = open_page(page)
    assert (opened.said, opened.asked) == ([], [page.as_uri()])
    keys = opened.page.keyboard

    def press(*pressed: str) -> None:
        for key in pressed:
            keys.press(key)

    opened.page.click(cell("W1", "leg_mm"))
    assert "you" in opened.page.inner_text("#value")
    press("Delete")
    said(opened, "leg goes back to the rules in W1")
    press("ArrowDown", "6", "Comma", "5", "Enter")
    said(opened, "leg is 6.5 mm in W2")
    press("ArrowLeft", "4", "Enter")  # a throat instead of the leg: one of the two
    said(opened, "throat is 4 mm in W2")
    assert opened.page.inner_text(cell("W2", "leg_mm")) == ""
    press("5", "0", "0", "Enter")
    said(opened, "throat: expected above 0 to 100 mm, got 500")
    press("Escape", "Space", "ArrowDown", "Space")  # two seams at once
    opened.page.click(cell("W3", "stitch"))
    press("Enter")
    keys.type("20")
    press("Tab")
    keys.type("50")
    press("Enter")
    said(opened, "stitch is 20 / 50 in W2, W3")
    opened.page.click(cell("W3", "job"))
    press("9", "Enter")
    said(opened, "job is 9 in W2, W3")
    press("Control+z")
    assert opened.page.inner_text(cell("W2", "job")) == ""
    press("Control+y")
    with opened.page.expect_download() as saved:
        opened.page.click("#download")
    assert "--values" in opened.page.inner_text("[data-test=command]")
    taken = tmp_path / FILE
    saved.value.save_as(taken)
    assert opened.said == []

    record = welds(folder, "-o", file, "--values", taken)
    stitch = {"length_mm": 20, "pitch_mm": 50}
    assert stated(record) == {
        "W1": {"weave": None},
        "W2": {"throat_mm": 4, "stitch": stitch, "job": 9},
        "W3": {"stitch": stitch, "job": 9},
    }
    (kept,) = record["without_seam"]
    assert (kept["name"], kept["values"]) == ("W4", {"job": 7})
    assert "W1: leg_mm 5 goes back to the rules" in record["notes"]
