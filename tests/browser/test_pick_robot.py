"""The picker with a robot: one key fills the selected row, and what must not be a row stays out of the table."""

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.robot_servers import Robot
from tests.running import FINISHED, run_here
from wpcal.core.transform import RigidTransform

pytestmark = pytest.mark.usefixtures("kernel_here")
TEE = Path(__file__).parents[2] / "fixtures" / "tee"
T_BASE_PART = RigidTransform.from_six_tuple([812.34, -45.67, 501.02, 0.4, -0.2, 2.5], target="base", source="part")
NAMES = ("V2", "V4", "V14", "V12")
ROWS = (
    "[...document.querySelectorAll('#points tbody tr')].filter((row) => row.querySelector('[aria-label=x_mm]').value)"
)


@pytest.mark.deep
def test_one_key_per_row_and_the_report_is_that_of_the_positions(start: Any, open_page: Any, tmp_path: Path) -> None:
    found = json.loads(run_here("features", TEE / "tee.step", "--json").stdout)["features"]
    places = {feature["name"]: feature["p_mm"] for feature in found}
    robot = Robot(delay_s=0.02)

    def touch(name: str) -> None:
        p = np.round(T_BASE_PART.apply(np.array(places[name])), 2)
        robot.T_base_tool = RigidTransform(T_BASE_PART.R, p, "base", "tool")

    with robot.serve("kuka") as port:
        picker = start(TEE / "tee.step", "--tolerance-mm", "0.4", "--robot", f"kuka:127.0.0.1:{port}")
        opened = open_page(picker.url)
        for count, name in enumerate(NAMES, 1):
            touch(name)
            opened.page.mouse.click(*opened.project(places[name]))
            opened.page.keyboard.press("F2") if count % 2 else opened.page.click("#robot")
            opened.wait(f"{ROWS}.length === {count}")
        opened.wait("window.wpcal.idle && document.querySelector('#state').textContent.startsWith('PASS')")
        robot.tool = "8"
        opened.page.click("#robot")
        opened.wait("document.querySelector('#save-state').textContent.includes('refused')")
        assert "tool 8 is active, the row before was touched with tool 7" in opened.page.inner_text("#save-state")
        assert opened.page.evaluate(f"{ROWS}.length") == len(NAMES)
        opened.page.click("#save")
        opened.wait("document.querySelector('#save-state').textContent.startsWith('saved 4 rows to taught.csv')")
        assert opened.said == []
        picker.end()
    saved = list(csv.DictReader((tmp_path / "taught.csv").read_text(encoding="utf-8").splitlines()))
    for row in saved:
        expected = T_BASE_PART.apply(np.array(places[row["feature"]]))
        read = [float(row[key]) for key in ("x_mm", "y_mm", "z_mm")]
        np.testing.assert_allclose(read, expected, rtol=0, atol=0.01)
    assert [row["feature"] for row in saved] == list(NAMES)
    done = run_here("calibrate", TEE / "tee.step", "taught.csv", "-o", "out", "--tolerance-mm", "0.4", cwd=tmp_path)
    assert done.returncode in FINISHED
