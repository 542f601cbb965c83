"""The report of a weldment whose bodies moved: what the page says and draws of them."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.running import run_here
from wpcal.core.arrays import FloatArray

pytestmark = pytest.mark.usefixtures("kernel_here")
UPRIGHTS = Path(__file__).parents[2] / "fixtures" / "uprights"
ARROW = (20, 24, 29)  #: Of a body that is shown to have moved (`MOVED` in bodies.js).
GHOST = (199, 125, 10)  #: Of the edges of the model (`GHOST` in report/scene.js).
NEAR = 30.0
BEYOND = (122, 31, 162)
DRAWN_MM = 0.02  #: A step of the mesh is 0.003 mm; the rest is 32-bit numbers in the browser.


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The result for six touches on every plate; with a robot that is known they tell which plates moved."""
    out, known = tmp_path_factory.mktemp("bodies") / "out", ("--bodies", "--robot-mm", "0.1,500")
    ended = run_here("calibrate", UPRIGHTS / "uprights.step", UPRIGHTS / "taught_six.csv", *known, "-o", out)
    assert ended.returncode in (0, 1), ended.stderr
    return out


def count(pixels: FloatArray, colour: tuple[int, int, int]) -> int:
    return int(np.sum(np.linalg.norm(pixels - colour, axis=2) < NEAR))


@pytest.mark.deep
def test_page_says_and_draws_what_moved(folder: Path, open_page: Any) -> None:
    record = json.loads((folder / "calibration.json").read_text(encoding="utf-8"))["bodies"]
    found = open_page(folder / "report.html")
    assert found.said == []
    page = found.page
    assert page.locator("#bodies .sentence").inner_text().lower() == f"{record['sentence']}.".lower()
    tables = page.locator("#bodies table")
    assert tables.nth(0).locator("tbody tr").count() == len(record["bodies"])
    assert tables.nth(1).locator("tbody tr").count() == len(record["seams"])
    assert page.evaluate("document.documentElement.scrollWidth") == page.viewport_size["width"]

    page.locator("input[data-layer='names']").click()
    page.locator("input[data-layer='part edges']").click()
    page.locator("input[data-layer='residuals']").click()
    with_arrows = count(found.pixels(), ARROW)
    factor = page.locator("[data-test='motion-factor']").inner_text()
    assert factor.startswith("× ")
    page.locator("input[data-layer='motions drawn']").click()
    assert count(found.pixels(), ARROW) < 0.2 * with_arrows

    assert count(found.pixels(), GHOST) < 50
    page.locator("input[data-layer='model edges']").click()
    assert count(found.pixels(), GHOST) > 500
    page.locator("input[data-layer='model edges']").click()

    by_error = count(found.pixels(), BEYOND)
    page.locator("[data-test='colour']").select_option("gap")
    assert "gap between the bodies" in page.locator(".legend:visible").inner_text()
    assert count(found.pixels(), BEYOND) < by_error


def test_bodies_are_drawn_where_they_are(folder: Path, open_page: Any) -> None:
    """A face of a moved plate is drawn in the plane in which the calibration has it, and not where the model has it."""
    calibration = json.loads((folder / "calibration.json").read_text(encoding="utf-8"))
    body = next(row for row in calibration["bodies"]["bodies"] if row["name"] == "U1")
    T, M = np.array(calibration["T_base_part"]), np.array(body["T_part_moved"])
    found = open_page(folder / "report.html")
    on_face = np.append(np.add(body["centre_part_mm"], [30.0, -4.0, 20.0]), 1.0)
    normal = T[:3, :3] @ M[:3, :3] @ [0.0, -1.0, 0.0]
    p = (T @ M @ on_face)[:3]
    x, y = found.page.evaluate("p => { const at = wpcal.viewer.project(p); return [at.x, at.y]; }", p.tolist())
    hit = found.page.evaluate("([x, y]) => wpcal.viewer.surfaceAt(x, y)", [x, y])
    assert hit["solid"] == "U1"
    assert abs((np.array(hit["p"]) - p) @ normal) < DRAWN_MM
    still = (T @ on_face)[:3]
    assert abs((np.array(hit["p"]) - still) @ normal) > 5.0 * DRAWN_MM
