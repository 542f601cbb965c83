"""A technician sets a wrong part right by hand: click by click, in the picker and on the page of seams."""

import json
import time
from pathlib import Path
from typing import Any

import pytest

from tests.running import run_here

pytestmark = pytest.mark.usefixtures("kernel_here")
TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"
MOST_S = 120.0  #: A person has two minutes. The walk below has his clicks; a machine's test must not need longer.


def seams_on(opened: Any) -> dict[str, bool]:
    """Whether the seams of the page are accepted, by name."""
    rows = opened.page.locator("#seams tbody tr").all()
    refused = opened.page.locator("#seams .refused tbody tr, #seams tr.dim").all()
    out = {row.get_attribute("data-name") for row in refused}
    return {name: name not in out for name in (row.get_attribute("data-name") for row in rows)}


def choose(opened: Any, name: str) -> None:
    opened.page.locator(f"#seams tr[data-name='{name}'] .name").click()


def click(opened: Any, text: str) -> None:
    opened.page.locator("#seam-editor").get_by_role("button", name=text, exact=True).click()


def said(opened: Any, text: str) -> None:
    opened.wait(f"document.querySelector('.seam-said').textContent.includes({json.dumps(text)})")


def walk(opened: Any) -> None:
    """A short end accepted and refused, a seam turned and cut, two joined round a corner, one named; a slip undone."""
    choose(opened, "W4")
    click(opened, "Accept")
    said(opened, "W4 is welded")
    click(opened, "Refuse")
    said(opened, "W4 is not welded")
    choose(opened, "W3")
    click(opened, "Turn")
    said(opened, "W3 runs the other way")
    opened.page.fill("#seam-editor [name=cut]", "60")
    click(opened, "Cut")
    said(opened, "W3 is cut")
    choose(opened, "W3b")
    click(opened, "Refuse")
    said(opened, "W3b is not welded")
    choose(opened, "W2")
    opened.page.select_option("#seam-editor [name=join]", label="W1")
    click(opened, "Join")
    said(opened, "W2 and W1 are one seam")
    opened.page.fill("#seam-editor [name=name]", "front and end")
    click(opened, "Rename")
    said(opened, "renamed to front and end")
    click(opened, "Refuse")
    said(opened, "front and end is not welded")
    click(opened, "Undo")
    said(opened, "undone")


def listed(folder: Path, file: Path) -> dict[str, Any]:
    done = run_here("seams", TEE, "--seams", file, "--json", cwd=folder)
    return {seam["name"]: seam for seam in json.loads(done.stdout)["seams"]}


def check_walked(seams: dict[str, Any]) -> None:
    """What wpcal made of the walk on the part."""
    accepted = {name: seam["accepted"] for name, seam in seams.items()}
    assert accepted == {"front and end": True, "W3a": True, "W3b": False, "W4": False}
    assert seams["front and end"]["length_mm"] == pytest.approx(158.0)
    assert seams["W3a"]["length_mm"] == pytest.approx(60.0)
    first, last = seams["W3a"]["frames"][0]["p_mm"], seams["W3a"]["frames"][-1]["p_mm"]
    assert (first, last) == (pytest.approx([175, 64, 10]), pytest.approx([115, 64, 10]))


@pytest.mark.deep
def test_a_wrong_part_is_set_right_in_the_picker(start: Any, open_page: Any, tmp_path: Path) -> None:
    picker = start(TEE)
    opened = open_page(picker.url)
    second = open_page(picker.url)
    begun = time.monotonic()
    walk(opened)
    assert time.monotonic() - begun < MOST_S
    expected = {"front and end": True, "W3a": True, "W3b": False, "W4": False}
    assert seams_on(opened) == expected
    assert "refused by hand" in opened.page.inner_text(".refused tr[data-name='W4']")
    second.wait("Boolean(document.querySelector('tr[data-name=\"front and end\"]'))")
    opened.page.reload()
    opened.wait("Boolean(document.querySelector('tr[data-name=\"front and end\"]'))")
    assert seams_on(opened) == expected
    check_walked(listed(tmp_path, tmp_path / "tee.seams.json"))
    choose(opened, "W3a")
    click(opened, "Other side")  # the torch would come through the plate
    opened.wait("document.querySelector('.refused tr[data-name=W3a]') !== null")
    assert "inside" in opened.page.inner_text(".refused tr[data-name='W3a']")
    assert opened.said == second.said == []


@pytest.mark.deep
def test_the_errors_follow_the_seams_that_were_decided(start: Any, open_page: Any, tmp_path: Path) -> None:
    opened = open_page(start(TEE, TEE.parent / "taught.csv", "-o", "t.csv").url)
    opened.wait("window.wpcal.idle && document.querySelectorAll('#seams .bar').length === 2")
    choose(opened, "W4")
    click(opened, "Accept")
    opened.wait("window.wpcal.idle && document.querySelectorAll('#seams .bar').length === 3")
    click(opened, "Undo")
    opened.wait("window.wpcal.idle && document.querySelectorAll('#seams .bar').length === 2")
    click(opened, "Redo")
    opened.wait("window.wpcal.idle && document.querySelectorAll('#seams .bar').length === 3")
    opened.page.click("#save")
    opened.wait("document.querySelector('#save-state').textContent.startsWith('saved')")
    assert "--seams tee.seams.json" in opened.page.inner_text("#save-state code")
    assert opened.said == []


@pytest.mark.deep
def test_a_click_on_the_chosen_seam_is_the_place_of_the_cut(start: Any, open_page: Any) -> None:
    """Also between its frames, and beside a feature, whose row a click would add otherwise."""
    opened = open_page(start(TEE).url)
    choose(opened, "W2")
    opened.page.evaluate("() => window.wpcal.viewer.draw()")  # the view has turned to the seam
    for s in (44.0, 73.0):
        opened.page.mouse.click(*opened.project([25.0 + s, 56.0, 10.0]))
        opened.wait(f"Math.abs(document.querySelector('#seam-editor [name=cut]').value - {s}) < 3")
    click(opened, "Cut")
    said(opened, "W2 is cut")
    assert opened.page.locator("#points tbody tr").count() == 0
    assert opened.said == []


def test_a_wrong_part_is_set_right_on_the_page_of_seams(open_page: Any, tmp_path: Path) -> None:
    page = tmp_path / "seams.html"
    assert run_here("seams", TEE, "--html", page).returncode == 0
    opened = open_page(page)
    assert not opened.page.locator("#download").is_visible()
    walk(opened)
    assert seams_on(opened) == {"front and end": True, "W3a": True, "W3b": False, "W4": False}
    assert opened.page.inner_text("[data-test=count]") == "2 seams accepted, 2 candidates refused"
    with opened.page.expect_download() as caught:
        opened.page.click("#download")
    file = tmp_path / caught.value.suggested_filename
    caught.value.save_as(file)
    assert file.name == "seams.json"
    check_walked(listed(tmp_path, file))
    assert opened.asked == [page.as_uri()] or all(one.startswith(("file:", "blob:")) for one in opened.asked)
    assert opened.said == []


def test_the_picker_finds_ticks_and_decides_several_and_shows_the_solids(start: Any, open_page: Any) -> None:
    opened = open_page(start(TEE, "--not", "web").url)
    page = opened.page
    assert page.locator("#all-seams").count() == 0  # not before somebody opens it
    page.click("#seams .all summary")
    opened.wait("document.querySelectorAll('#all-seams tbody tr').length > 0")
    names = [row.get_attribute("data-name") for row in page.locator("#all-seams tbody tr").all()]
    assert len(names) == 4
    assert page.locator("#all-seams tr.dim").count() == 4
    solids = page.locator("#members tbody tr").all_inner_texts()
    assert any("web" in row and "you said so" in row for row in solids)
    page.locator("#members .find", has_text="web").click()
    assert page.input_value("#all-seams [name=words]") == "web"
    page.check(f"#all-seams [aria-label='tick {names[0]}']")
    assert "1 seam ticked" in page.inner_text("#seam-editor")
    page.check("#all-seams [aria-label='tick all that are shown']")
    click(opened, "Accept ticked")
    said(opened, "4 seams are welded")
    opened.wait("document.querySelectorAll('#all-seams tr.dim').length === 0")
    click(opened, "Undo")
    opened.wait("document.querySelectorAll('#all-seams tr.dim').length === 4")
    assert opened.said == []


@pytest.mark.deep
def test_a_solid_is_said_to_be_welded_or_not_in_the_picker(start: Any, open_page: Any, tmp_path: Path) -> None:
    """Said in one window, seen in both, kept for the next session, and told by the command that repeats it."""
    picker = start(TEE, TEE.parent / "taught.csv", "-o", "t.csv")
    opened, second = open_page(picker.url), open_page(picker.url)
    page = opened.page
    page.click("#seams .all summary")
    page.select_option("[aria-label='web is']", "not")
    said(opened, "web: not welded")
    opened.wait("document.querySelectorAll('#all-seams tr.dim').length === 4")
    assert "you said so" in page.inner_text("#members tbody")
    for name in ("web", "base plate"):
        page.check(f"[aria-label='tick {name}']")
    page.click("text=These two are one")
    said(opened, "web: base plate")
    assert "--member web=base plate" in page.inner_text("#all-seams")
    page.locator("#members .find", has_text="web").click()
    opened.wait("window.wpcal.viewer.isShown('member')")
    second.wait("document.querySelectorAll('#seams .refused tbody tr').length === 4")
    page.click("#save")
    opened.wait("document.querySelector('#save-state').textContent.startsWith('saved')")
    assert "--seams tee.seams.json" in page.inner_text("#save-state code")
    again = open_page(start(TEE, "-o", "t.csv").url)
    again.page.click("#seams .all summary")
    assert again.page.input_value("[aria-label='web is']") == "base plate"
    again.page.select_option("[aria-label='web is']", "rules")
    said(again, "web: the rules decide")
    again.wait("document.querySelectorAll('#all-seams tr.dim').length === 2")
    assert opened.said == second.said == again.said == []
