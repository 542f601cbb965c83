"""The page of a weld sequence in a browser: all seams, what is left out, play, the time line and the clearance."""

import dataclasses
from pathlib import Path

import numpy as np
import pytest

from tests.one_robot_cells import TEE, fixed_cell
from wpcal.pages.sequence import build_sequence_page
from wpcal.planning.sequence.cuts import Unwelded
from wpcal.planning.sequence.plan_sequence import plan_sequence
from wpcal.planning.sequence.sequence_input import read_sequence_input
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.planning.sequence.timeline import build_timeline

pytest.importorskip("fcl", reason="python-fcl is not installed")


@pytest.fixture(scope="module")
def planned():
    given = read_sequence_input(TEE, fixed_cell(), ["W2", "W3"])
    choice = plan_sequence(given.placed(fixed_cell()), given.part, given.seams, SequenceTargets())
    gap = Unwelded("W9", 10.0, 40.0, "out of reach of <img src=x>, by 90 mm at least")
    choice = dataclasses.replace(choice, sequence=dataclasses.replace(choice.sequence, unwelded=(gap,)))
    return choice, build_timeline(choice.sequence), given.part_glb


@pytest.fixture
def page(planned, tmp_path: Path, open_page):
    choice, line, part_glb = planned
    path = tmp_path / "plan.html"
    path.write_text(build_sequence_page(choice, line, part_glb=part_glb), encoding="utf-8")
    return open_page(path)


def test_all_seams_are_listed_and_what_is_not_welded_is_told(planned, page):
    rows = page.page.locator("#front table").first.locator("tbody tr").all_inner_texts()
    names = [piece.name for piece in planned[0].sequence.pieces]
    assert [row.split()[0] for row in rows] == names
    told = page.page.locator('[data-test="unwelded"]').inner_text()
    assert "seam W9 from 10 to 40 mm is not welded: out of reach of <img src=x>" in told
    assert page.page.locator('[data-test="freedom"]').inner_text() == "NOT WELDED"
    assert "NOT WELDED: 30 of" in page.page.locator('[data-test="open"]').inner_text()
    charts = page.page.locator("#page").inner_text()
    assert "Joints of the arm, deg" in charts
    assert "Clearance beyond the safety distance, mm" in charts
    assert not [said for said in page.said if said.startswith(("error", "warning"))]
    assert len(page.asked) == 1  # the page needs no other file


@pytest.mark.deep
def test_a_click_goes_to_a_seam_and_the_arm_moves_with_the_time(planned, page):
    _, line, _ = planned
    start = page.pixels()
    rows = page.page.locator("#front table").first.locator("tbody tr")
    rows.nth(1).click()
    page.wait("document.querySelectorAll('#front tbody tr')[1].className.includes('chosen')")
    there = page.pixels()
    assert np.abs(there - start).max() > 40.0
    page.page.evaluate("t => window.wpcal.seek(t)", float(line.t_s[-1]))
    assert np.abs(page.pixels() - there).max() > 40.0  # at home again


@pytest.mark.deep
def test_play_runs_from_where_it_is(page):
    time = "Number(document.querySelector('[data-test=time]').value)"
    before = page.page.evaluate(time)
    page.page.locator("[data-test=play]").click()
    page.wait(f"{time} > {before + 0.05}")
    page.page.locator("[data-test=play]").click()
    assert page.page.locator("[data-test=play]").inner_text() == "play"
