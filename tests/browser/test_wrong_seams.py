"""A part with many wrong seams is set right on the page of seams, at the speed of a person, click by click."""

import json
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest

from tests.benchmarks.welds.lists import FOLDER, read_record, welds_of
from tests.benchmarks.welds.score import WeldScore, score
from tests.running import run_here

pytestmark = pytest.mark.usefixtures("kernel_here")

MOST_S = 120.0
CLICK_S, LETTER_S = 3.0, 1.0  #: A person finds the place of a click in 3 s, and types 60 letters a minute.


@dataclass
class Welder:
    """A person at the page of seams, who knows which seams are wrong once he has looked at them."""

    opened: Any
    done: list[str] = field(default_factory=list)
    seconds: float = 0.0

    def click(self, what: str, place: Any) -> None:
        place.click(timeout=10_000)
        self.done.append(what)
        self.seconds += CLICK_S

    def press(self, text: str, box: str = "#seam-editor") -> None:
        self.click(text, self.opened.page.locator(box).get_by_role("button", name=text, exact=True))

    def look_at(self, *names: str) -> None:
        """A click on a seam's line turns the view to it; the list stays where it is."""
        for name in names:
            self.click(f"line {name}", self.opened.page.locator(f"#seams tr[data-name='{name}'] .name"))
            self.opened.wait(f"document.querySelector('#seam-editor strong').textContent.startsWith('{name}:')")
            assert self.opened.page.locator(f"#seams tr[data-name='{name}']").is_visible()

    def tick(self, *names: str) -> None:
        for name in names:
            self.click(f"tick {name}", self.opened.page.get_by_label(f"tick {name}", exact=True))

    def search(self, text: str) -> None:
        field = self.opened.page.locator("#seams [name=words]")
        self.click(f"search field, types {text!r}", field)
        field.fill(text)
        self.seconds += LETTER_S * max(1, len(text))

    def shown(self) -> list[str]:
        rows = self.opened.page.locator("#seams tbody tr").all()
        return [row.get_attribute("data-name") for row in rows]

    def save(self, folder: Path) -> Path:
        with self.opened.page.expect_download() as caught:
            self.press("Save seams.json", "#tools")
        caught.value.save_as(folder / "seams.json")
        return folder / "seams.json"


def listed(part: Path, *more: str) -> dict[str, Any]:
    record: dict[str, Any] = json.loads(run_here("seams", part, "--json", *more).stdout)
    return record


def scored(name: str, seams: list[dict[str, Any]]) -> WeldScore:
    return score(name, welds_of(read_record(FOLDER / "lists" / f"{name}.json")), seams)


@pytest.mark.deep
def test_seams_of_a_gate_with_a_solid_mistaken_are_set_right_within_two_minutes(open_page: Any, tmp_path: Path) -> None:
    """One of 12 solids is taken for something that is not welded, and two short seams at a hinge are none."""
    part, mistaken = FOLDER / "parts" / "gate.step", ("--not", "rail low")
    page = tmp_path / "gate.html"
    before = listed(part, *mistaken, "--html", str(page))["seams"]
    wrong = [seam["name"] for seam in scored("gate", before).wrong_seams]
    assert len(before) > 100
    assert len(wrong) >= 2
    assert scored("gate", before).sure.found < scored("gate", before).sure.of

    welder = Welder(open_page(page))
    welder.click("not welded: rail low", welder.opened.page.locator("#members").get_by_role("button", name="rail low"))
    welder.press("refused", "#seams")
    shown = welder.shown()
    assert set(shown) == {seam["name"] for seam in before if "rail low" in seam["solids"]}
    unreached = [seam["name"] for seam in before if seam["name"] in shown and not seam["reachable"]]
    welder.tick("all that are shown", *unreached)
    welder.press("Accept ticked")
    welder.search("")
    welder.press("accepted", "#seams")
    welder.click("head length mm", welder.opened.page.locator("#seams [data-sort='length mm']"))
    assert set(welder.shown()[: len(wrong)]) == set(wrong)
    welder.look_at(*wrong)
    welder.tick(*wrong)
    welder.press("Refuse ticked")
    file = welder.save(tmp_path)

    assert welder.seconds <= MOST_S, (welder.seconds, welder.done)
    after = scored("gate", listed(part, *mistaken, "--seams", str(file))["seams"])
    assert (after.sure.found, after.wrong) == (after.sure.of, 0)
    assert welder.opened.said == []


@pytest.mark.deep
def test_a_refused_seam_leads_to_its_solid_and_several_are_decided_and_undone_at_once(
    open_page: Any, tmp_path: Path
) -> None:
    page = tmp_path / "tee.html"
    record = listed(FOLDER.parent / "tee" / "tee.step", "--not", "web", "--join-mm", "7", "--html", str(page))
    assert record["join_mm"] == 7.0
    opened = open_page(page)
    welder = Welder(opened)
    line = opened.page.locator("#seams tr.dim").first
    line.locator("a", has_text="web").click()
    opened.wait("document.activeElement.textContent.includes('not welded')")
    assert opened.page.locator("#members tr:focus").count() == 1
    names = welder.shown()
    welder.tick("all that are shown")
    welder.press("Accept ticked")
    assert opened.page.inner_text("[data-test=count]") == f"{len(names)} seams accepted, 0 candidates refused"
    assert not opened.page.locator("#seam-editor .ticked").count()
    welder.press("Undo")
    assert opened.page.inner_text("[data-test=count]") == f"0 seams accepted, {len(names)} candidates refused"
    assert opened.said == []
