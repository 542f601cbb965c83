"""`plan.html` in a browser: a click in the front shows a plan, the time moves the arms, names are never markup."""

from dataclasses import replace

import numpy as np
import pytest

from wpcal.core.errors import InputError
from wpcal.pages.cell import build_cell_page
from wpcal.pages.plan import MethodFront, build_plan_page
from wpcal.planning.cell.shape import Shape
from wpcal.planning.plan.plan import schedule_plan
from wpcal.planning.plan.run import build_run
from wpcal.planning.search.objectives import OBJECTIVE_NAMES, OBJECTIVES

pytest.importorskip("fcl", reason="python-fcl is not installed")
DRAWN_MM = 0.01  #: Frames are kept as 32-bit numbers: 1e-4 mm at 2 m; the clock of the page has milliseconds.
HOSTILE = "</script><img src=x onerror='window.struck = true'>"


@pytest.fixture(scope="module")
def runs(cell, simple_plan):
    """A front of three: found in two ways, the last one unchecked."""
    schedule = schedule_plan(simple_plan, cell)
    values = [(9.0, 2.0, 0.5), (5.0, 1.0, 0.9), (2.0, 3.0, 1.6)]
    plans = [
        replace(simple_plan, objectives=dict(zip(OBJECTIVE_NAMES, row, strict=True)), found_by=found)
        for row, found in zip(values, ("ladder", "nsga2", "ladder"), strict=True)
    ]
    return [build_run(plan, cell, schedule, refine=10 if row < 2 else None) for row, plan in enumerate(plans)]


@pytest.fixture
def opened(browser, tmp_path):
    """Open a page from a file; it must call nobody and complain of nothing."""
    said, asked, pages = [], [], []

    def open_page(html):
        path = tmp_path / "plan.html"
        path.write_text(html, encoding="utf-8")
        page = browser.new_page(viewport={"width": 1280, "height": 900})
        pages.append(page)
        page.on("console", lambda message: "GPU stall due to ReadPixels" in message.text or said.append(message.text))
        page.on("pageerror", lambda error: said.append(str(error)))
        page.on("request", lambda request: asked.append(request.url))
        page.goto(path.as_uri())
        wait_until(page, "window.wpcal && window.wpcal.ready")
        return page

    yield open_page
    for page in pages:  # one that plays would draw beside all further tests
        page.close()
    assert said == []
    assert [url for url in asked if not url.startswith(("file:", "data:", "blob:"))] == []


def wait_until(page, expression):
    """Ask again and again from outside: the page's own policy lets nothing be evaluated inside."""
    for _ in range(1200):
        if page.evaluate(expression):
            return
        page.wait_for_timeout(50)
    raise TimeoutError(expression)


def tip_drawn(page):
    """Where the view has the wire's tip: the last column of the layer's matrix."""
    return np.array(page.evaluate("window.wpcal.viewer.layer('tip').matrixWorld.elements"))[12:15]


def test_the_time_moves_the_torch_to_where_it_is(opened, cell, runs):
    page = opened(build_plan_page(runs, cell, OBJECTIVES, chosen=1))
    tip = cell.tool_places(runs[1].q[:, :6])[:, :3, 3]
    for row in (0, 5, 40, len(runs[1]) - 1):
        page.evaluate(f"window.wpcal.seek({round(float(runs[1].t_s[row]), 4)})")
        np.testing.assert_allclose(tip_drawn(page), tip[row], rtol=0, atol=DRAWN_MM)
    assert page.evaluate("window.wpcal.project(window.wpcal.viewer.layer('tip').position.toArray())")
    assert f"of {runs[1].t_s[-1]:.1f} s" in page.inner_text("[data-test=clock]")
    assert page.inner_text("[data-test=place]") == "leaving the seam"


def test_every_body_is_drawn_where_its_frame_is(opened, cell, runs):
    """The flange of robot 2 carries the part: layer of its bodies against the kinematics."""
    page = opened(build_plan_page(runs, cell, OBJECTIVES, chosen=0))
    page.evaluate(f"window.wpcal.seek({round(float(runs[0].t_s[20]), 4)})")
    drawn = np.array(page.evaluate("window.wpcal.viewer.layer('part@16').matrixWorld.elements")).reshape(4, 4).T
    T = cell.T_world_base2.matrix @ cell.arm2.forward(runs[0].q[20:21, 6:])[0] @ cell.T_part.matrix
    np.testing.assert_allclose(drawn, T, rtol=0, atol=DRAWN_MM)
    assert page.evaluate("window.wpcal.viewer.layer('robot1@3').children.length") == 2  # elbow and forearm


def test_a_click_in_the_front_shows_that_plan(opened, cell, runs):
    page = opened(build_plan_page(runs, cell, OBJECTIVES, chosen=1))
    assert page.inner_text("[data-test=which]") == "plan 2 of 3, the chosen one"
    assert page.inner_text("[data-test=freedom]") == "FREE"
    page.click("[data-plan='2']")
    wait_until(page, "window.wpcal.plan === 2")
    assert page.inner_text("[data-test=which]") == "plan 3 of 3"
    assert page.inner_text("[data-test=freedom]") == "UNCHECKED"
    assert page.locator(".plan.chosen").count() == 1
    page.click("#front tr[data-row='0']")
    wait_until(page, "window.wpcal.plan === 0")
    assert page.inner_text("[data-test=freedom]") == "FREE"
    assert page.locator("svg.chart").count() == 5


@pytest.mark.deep
def test_what_each_method_found_is_drawn_behind_the_plans(opened, cell, runs):
    fronts = [
        MethodFront("ladder", np.array([[9.0, 2, 0.5], [2.0, 3, 1.6]]), 12.3),
        MethodFront("nsga2", np.array([[5.0, 1, 0.9]]), 4.5),
    ]
    page = opened(build_plan_page(runs, cell, OBJECTIVES, chosen=0, fronts=fronts))
    assert [page.locator(f"[data-front='{name}'] path").count() for name in ("ladder", "nsga2")] == [2, 1]
    assert "2 plans by itself, hypervolume 12.3" in page.inner_text("#front")


@pytest.mark.deep
def test_playing_lets_the_time_run_and_a_click_in_a_chart_sets_it(opened, cell, runs):
    page = opened(build_plan_page(runs, cell, OBJECTIVES, chosen=0))
    before = tip_drawn(page)
    page.click("[data-test=play]")
    wait_until(page, "Number(document.querySelector('[data-test=time]').value) > 1.3")
    page.click("[data-test=play]")
    assert np.linalg.norm(tip_drawn(page) - before) > 0.1
    page.locator(".charts svg").first.click(position={"x": 300, "y": 60})
    assert 5 < float(page.input_value("[data-test=time]")) < 25


def test_names_stay_names(opened, cell, runs):
    odd = Shape(HOSTILE, [[0, 900, 0]], [[0, 900, 10]], [5])
    strange = replace(cell, name=HOSTILE, bench=(*cell.bench, odd))
    renamed = [replace(run, plan=replace(run.plan, seam=HOSTILE, found_by=HOSTILE)) for run in runs]
    html = build_plan_page(renamed, strange, OBJECTIVES, chosen=0)
    assert HOSTILE not in html
    page = opened(html)
    assert page.inner_text("h1") == f"Seam {HOSTILE}"
    assert page.evaluate("window.struck") is None
    assert page.locator("img").count() == 0


@pytest.mark.deep
def test_tip_and_speed_between_the_points_are_in_the_table_and_in_the_head(opened, cell, runs):
    page = opened(build_plan_page(runs, cell, OBJECTIVES, chosen=1))
    tip = runs[1].tip
    assert f"tip up to {tip.error_mm:.2f} mm off the line" in page.inner_text("[data-test=tip]")
    row = page.inner_text("#front tr[data-row='1']")
    assert f"{tip.error_mm:.2f}" in row
    assert f"{tip.slowest_mm_s:.1f} to {tip.fastest_mm_s:.1f}" in row
    assert page.locator("[data-test=issues]").count() == 0


@pytest.mark.deep
def test_an_odd_cell_is_told_on_the_page(opened, cell, runs):
    page = opened(build_plan_page(runs, replace(cell, torch=()), OBJECTIVES, chosen=0))
    assert "the torch has no bodies" in page.inner_text("[data-test=issues]")


def test_the_page_of_a_cell_draws_its_bodies_frames_and_mounting_faces(opened, cell):
    page = opened(build_cell_page(replace(cell, torch=(), floor_z_mm=-300.0)))
    assert page.inner_text("[data-test=stamp]") == "3 ODD"  # no torch, and both arms 300 mm above the floor
    assert "300 mm above the floor (z = -300 mm)" in page.inner_text("[data-test=issues]")
    drawn = np.array(page.evaluate("window.wpcal.viewer.layer('part@16').matrixWorld.elements")).reshape(4, 4).T
    T = cell.T_world_base2.matrix @ cell.arm2.forward(np.zeros((1, 6)))[0] @ cell.T_part.matrix
    np.testing.assert_allclose(drawn, T, rtol=0, atol=DRAWN_MM)
    for layer in ("mounting faces", "frame@0", "frame@7", "floor"):
        assert page.evaluate(f"window.wpcal.viewer.layer('{layer}').children.length") > 0
        assert page.evaluate(f"window.wpcal.viewer.layer('{layer}').visible")


def test_a_page_that_may_call_nobody(cell, runs):
    html = build_plan_page(runs, cell, OBJECTIVES, chosen=0)
    assert "default-src 'none'" in html
    assert "connect-src" not in html
    assert build_plan_page(runs, cell, OBJECTIVES, chosen=0) == html


def test_a_front_of_nothing_or_of_two_seams_is_refused(cell, runs):
    with pytest.raises(InputError, match="the plans of one seam"):
        build_plan_page([], cell, OBJECTIVES, chosen=0)
    other = replace(runs[1], plan=replace(runs[1].plan, seam="W2"))
    with pytest.raises(InputError, match="the plans of one seam"):
        build_plan_page([runs[0], other], cell, OBJECTIVES, chosen=0)
