"""The page of a plan of touches in a browser: the searches in their order, where they begin, and their way."""

from pathlib import Path
from typing import Any

import numpy as np

from tests.unit.conftest import plate
from wpcal.brep.mesh_glb import write_part_glb
from wpcal.pages.touches import build_touches_page
from wpcal.touch.searches.record import read_touch_plan

TEE = Path(__file__).parents[2] / "fixtures" / "tee"
SEARCH_RED = (179, 32, 46)
NEAR = 40.0


def test_a_plan_of_touches_is_shown_and_played(open_page: Any, tmp_path: Path) -> None:
    plan = read_touch_plan(TEE / "touches_plan")
    seam = np.array([[25.0, 56.0, 10.0], [175.0, 56.0, 10.0]])
    borders = {search.name: 5.0 for search in plan.searches}
    text = build_touches_page(plan, part_glb=write_part_glb(plate()), seams={"W1": seam}, border_mm=borders)
    page = tmp_path / "touches.html"
    page.write_text(text, encoding="utf-8")
    opened = open_page(page)
    rows = opened.page.locator("#searches tbody tr").all_inner_texts()
    assert [row.split("\t")[1] for row in rows] == [search.name for search in plan.searches]
    assert [row.split("\t")[4] for row in rows] == [f"{search.stroke_mm:.1f}" for search in plan.searches]
    red = np.linalg.norm(opened.pixels() - SEARCH_RED, axis=2) < NEAR
    assert int(red.sum()) > 50
    opened.page.locator("tr[data-name=T4]").focus()
    opened.page.keyboard.press("Enter")
    opened.wait("document.querySelector('tr[data-name=T4]').classList.contains('chosen')")
    assert opened.page.inner_text("[data-test=place]") == "T4 searches"
    opened.page.mouse.move(*opened.project(plan.searches[2].planned.tolist()))
    opened.wait("!document.querySelector('.tooltip').hidden")
    assert "end of the wire" in opened.page.inner_text(".tooltip")
    opened.page.click("[data-test=play]")
    opened.wait("document.querySelector('tr[data-name=T5]').classList.contains('chosen')")
    assert (opened.said, opened.asked) == ([], [page.as_uri()])
