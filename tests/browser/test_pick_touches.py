"""Touches in the picker: clicks on faces and edges add rows, arrows and a prediction; typed, they are fitted."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from wpcal.core.transform import RigidTransform
from wpcal.taught.table import read_taught

TEE = Path(__file__).parents[2] / "fixtures" / "tee"
FACES = [[30, 40, 10], [170, 30, 10], [100, 40, 10], [50, 0, 5], [160, 0, 5], [0, 60, 5]]
"""3-2-1, on faces that the first view shows."""
EDGE = [100, 0, 10]
NORMALS = np.array([[0, 0, 1]] * 3 + [[0, -1, 0]] * 2 + [[-1, 0, 0]], dtype=np.float64)
NEAR_MM = 1.0  #: A pixel of the view is 0.3 mm.
RED, NEAR = (179, 32, 46), 40.0
WIRE_MM = 0.6


def click(opened: Any, place: list[float], rows: int) -> None:
    """Click on the part, and wait until the table has so many rows and the server has answered."""
    opened.page.mouse.click(*opened.project(place))
    opened.wait(f"document.querySelectorAll('#points tbody tr').length === {rows} && window.wpcal.idle")


def cells(opened: Any, row: int, name: str) -> Any:
    return opened.page.locator("#points tbody tr").nth(row).locator(f".cell-{name} :is(input, select)")


@pytest.fixture
def truth() -> RigidTransform:
    T = np.array(json.loads((TEE / "truth.json").read_text(encoding="utf-8"))["T_base_part"])
    return RigidTransform(T[:3, :3], T[:3, 3], "base", "part")


@pytest.mark.deep
def test_touches_are_picked_on_faces_and_fitted(
    start: Any, open_page: Any, tmp_path: Path, truth: RigidTransform
) -> None:
    picker = start(TEE / "tee.step", "-o", "touched.csv", "--sigma-mm", "0.01")
    opened = open_page(picker.url)
    opened.page.get_by_text("add touches").click()
    opened.page.fill("input[name=radius]", str(WIRE_MM))
    for number, place in enumerate(FACES, 1):
        click(opened, place, number)
        if number == 1:
            assert "They hold 1 of six freedoms" in opened.page.inner_text("#promise")
    assert "predicted 95 % error: at most" in opened.page.inner_text("#promise")
    assert int((np.linalg.norm(opened.pixels() - RED, axis=2) < NEAR).sum()) > 50
    model = np.array(
        [[float(cells(opened, row, f"model_{axis}_mm").input_value()) for axis in "xyz"] for row in range(len(FACES))]
    )
    assert np.linalg.norm(model - FACES, axis=1).max() < NEAR_MM
    assert {cells(opened, row, "kind").input_value() for row in range(len(FACES))} == {"plane"}

    touched = truth.apply(model + WIRE_MM * NORMALS)
    for row, p in enumerate(touched):
        for axis, value in zip("xyz", p, strict=True):
            cells(opened, row, f"{axis}_mm").fill(f"{value:.4f}")
    opened.wait("window.wpcal.idle")
    assert "UNSURE: Nothing tests" in opened.page.inner_text("#state")  # six touches of six freedoms
    opened.page.click("#save")
    opened.wait("document.getElementById('points').textContent.includes('wpcal calibrate')")
    saved = read_taught(tmp_path / "touched.csv")
    assert saved.has_touches
    assert np.allclose(saved.p_base, touched, rtol=0, atol=1e-4)

    click(opened, EDGE, len(FACES) + 1)
    assert cells(opened, len(FACES), "kind").input_value() == "edge"
    opened.page.get_by_role("button", name="Undo").first.click()
    opened.wait(f"document.querySelectorAll('#points tbody tr').length === {len(FACES)}")
    assert opened.said == []
