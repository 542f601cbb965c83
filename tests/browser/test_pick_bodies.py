"""Bodies that may have moved, in the picker: switched on, with a tolerance, saved, and there again after a reload."""

import json
import shlex
import shutil
from pathlib import Path
from typing import Any

import pytest

from tests.running import run_here

pytestmark = pytest.mark.usefixtures("kernel_here")
UPRIGHTS = Path(__file__).parents[2] / "fixtures" / "uprights"


@pytest.mark.deep
def test_the_page_says_what_its_command_says(
    start: Any, open_page: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    shutil.copy(UPRIGHTS / "taught.csv", tmp_path / "taught.csv")
    picker = start(UPRIGHTS / "uprights.step", "taught.csv", "--sigma-mm", "0.2", "--criterion", "least_squares")
    opened = open_page(picker.url)
    page = opened.page
    opened.wait("document.getElementById('state').textContent.length > 10 && window.wpcal.idle")
    assert page.locator("#moving .sentence").count() == 0

    page.locator("[data-test='bodies']").check()
    opened.wait("document.querySelector('#moving .sentence') && window.wpcal.idle")
    assert "assumed" in page.inner_text("#moving .caption >> nth=0")
    assert "motions × " in page.inner_text("[data-test='factor']")
    assert page.locator("#moving table").nth(0).locator("tbody tr").count() == 5

    page.fill("input[name='tack_mm']", "-1")
    opened.wait("document.getElementById('points').textContent.includes('must be a positive number')")
    page.fill("input[name='tack_mm']", "0.6")
    opened.wait("document.getElementById('moving').textContent.includes('0.6 mm, 3 mrad') && window.wpcal.idle")
    said = page.inner_text("#moving .sentence")

    page.click("#save")
    opened.wait("document.getElementById('points').textContent.includes('wpcal calibrate')")
    command = shlex.split(page.locator("#points code").inner_text())
    assert command[4:7] == ["--bodies", "--tack-mm", "0.6"]
    assert "--criterion" not in command  # of rigid parts only
    monkeypatch.chdir(tmp_path)
    ended = run_here(*command[1:-1], "result")
    assert ended.returncode in (0, 1), ended.stderr
    assert ended.stdout.splitlines()[0] == said
    record = json.loads((tmp_path / "result" / "calibration.json").read_text(encoding="utf-8"))
    rows = page.locator("#moving table").nth(1).locator("tbody tr")
    for number, seam in enumerate(record["bodies"]["seams"]):
        assert f"{seam['u95_mm']:.3f}" in rows.nth(number).inner_text()

    again = open_page(picker.url)
    again.wait("document.querySelector('#moving .sentence') && window.wpcal.idle")
    assert again.page.locator("[data-test='bodies']").is_checked()
    assert again.page.input_value("input[name='tack_mm']") == "0.6"
