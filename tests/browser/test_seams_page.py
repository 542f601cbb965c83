"""The page of `wpcal seams --html` in a browser: it needs no other file, lists every seam, and shows names as text."""

import json
from pathlib import Path
from typing import Any

import pytest

from tests.running import run_here
from wpcal.pages.seams import build_seams_page

TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"
HOSTILE = "</script><img src=x onerror=window.hacked=1>"


@pytest.fixture(scope="module")
def written(kernel_here: None, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Any]:
    page = tmp_path_factory.mktemp("seams") / "seams.html"
    return page, json.loads(run_here("seams", TEE, "--html", page, "--json").stdout)


def test_the_page_stands_alone_and_lists_the_seams(open_page: Any, written: tuple[Path, Any]) -> None:
    page, record = written
    opened = open_page(page)
    assert opened.said == []
    assert opened.asked == [page.as_uri()]
    taken = sum(seam["accepted"] for seam in record["seams"])
    assert f"{taken} seams accepted" in opened.page.inner_text("[data-test=count]")
    rows = opened.page.locator("#seams tbody tr").all_inner_texts()
    assert [row.split("\t")[1] for row in rows] == [seam["name"] for seam in record["seams"]]


@pytest.mark.deep
def test_the_pointer_on_a_seam_says_which_it_is(open_page: Any, written: tuple[Path, Any]) -> None:
    page, record = written
    opened = open_page(page)
    (seam,) = (seam for seam in record["seams"] if seam["name"] == "W2")  # its side faces the first view
    middle = seam["frames"][len(seam["frames"]) // 2]["p_mm"]
    opened.page.mouse.move(*opened.project(middle))
    opened.wait("!document.querySelector('.tooltip').hidden")
    said = opened.page.inner_text(".tooltip")
    assert "W2" in said
    assert f"{seam['length_mm']:.3f} mm" in said


@pytest.mark.deep
def test_a_name_that_looks_like_markup_stays_a_name(open_page: Any, written: tuple[Path, Any], tmp_path: Path) -> None:
    record = json.loads(json.dumps(written[1]))
    record["seams"][0]["solids"] = [HOSTILE, HOSTILE]
    page = tmp_path / "hostile.html"
    page.write_text(build_seams_page(record, None, file_name=HOSTILE), encoding="utf-8")
    opened = open_page(page)
    assert opened.page.evaluate("window.hacked") is None
    assert HOSTILE in opened.page.inner_text("h1")
    assert HOSTILE in opened.page.inner_text("#seams")
