"""Photograph wpcal's pages for the README and the tour: `make shots`, or this script with names.

Needs chromium and playwright. Every shot calibrates a part of `fixtures/` (or opens another page of ours), brings the
page into a state and keeps one picture in `docs/images`.
"""

import contextlib
import io
import shutil
import subprocess
import sys
import tempfile
import threading
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from matplotlib.image import imread, imsave
from playwright.sync_api import sync_playwright

from cad.pick.opening import find_table, start_table
from cad.pick.page import build_pick_page
from cad.pick.server import PickServer
from cad.session.part import read_pick_part
from cad.session.session import PickSession
from cad.workpiece.calibrate import calibrate_files
from cad.workpiece.fit_taught import CalibrateOptions
from cad.workpiece.seams import SeamChoice
from wpcal.core.records import read_json
from wpcal.seam import SeamOptions

ROOT = Path(__file__).parents[1]
IMAGES = ROOT / "docs" / "images"
FIXTURES = ROOT / "fixtures"
FLAGS = ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
LARGEST_BYTES = 200_000  #: A page of the documentation with six pictures stays under a megabyte or so.


@dataclass(frozen=True)
class Shot:
    """One picture: which address, how large a window, what to do in it, which element to keep (None: the window)."""

    name: str
    page: Callable[[Path], str]
    width: int = 1280
    height: int = 900
    act: Callable[[Any, Path], None] = lambda page, folder: None
    element: str | None = None


def report_of(name: str, *, off_mm: float = 0.0) -> Callable[[Path], str]:
    """Calibrate a fixture; `off_mm` spoils x of the second point."""

    def make(folder: Path) -> str:
        source, taught = FIXTURES / name, folder / "taught.csv"
        lines = (source / "taught.csv").read_text(encoding="utf-8").splitlines()
        cells = lines[2].split(",")
        cells[1] = f"{float(cells[1]) + off_mm:.2f}"
        taught.write_text("\n".join([*lines[:2], ",".join(cells), *lines[3:]]) + "\n", encoding="utf-8")
        out = folder / "out"
        calibrate_files(source / f"{name}.step", taught, out, overwrite=True, options=CalibrateOptions())
        return (out / "report.html").as_uri()

    return make


def hover_a_seam(page: Any, folder: Path) -> None:
    """Put the pointer on the middle of the second seam, with the frames shown."""
    page.locator("input[data-layer='frames']").check()
    page.locator("input[data-layer='residuals']").uncheck()
    frames = read_json(folder / "out" / "seams.json", schema="wpcal/seams/1")["seams"][1]["frames"]
    spot = page.evaluate("p => window.wpcal.project(p)", frames[len(frames) // 2]["p_mm"])
    box = page.locator(".stage canvas").bounding_box()
    page.mouse.move(box["x"] + spot["x"], box["y"] + spot["y"])
    page.wait_for_timeout(500)


def see_through(page: Any, folder: Path) -> None:
    """Make the part transparent."""
    page.locator(".toggle-alone input").first.check()
    page.wait_for_timeout(300)


def plan_of_saddle(folder: Path) -> str:
    """Plan the saddle with both methods, the second a short run."""
    cells, out = FIXTURES / "cells", folder / "plan"
    files = [str(cells / "two-mh6.json"), str(cells / "saddle-seams.json")]
    options = ["--seam", "W1", "--generations", "15", "--population", "40", "-o", str(out)]
    subprocess.run([sys.executable, "-m", "wpcal", "plan", *files, *options], check=True, capture_output=True)
    return (out / "plan.html").as_uri()


def picker_of_tee(folder: Path) -> str:
    """Serve the picker with the rows of the fixture until this script ends; one point is still to be typed."""
    lines = (FIXTURES / "tee" / "taught.csv").read_text(encoding="utf-8").splitlines()
    table = folder / "taught.csv"
    table.write_text("\n".join([*lines[:-1], "H1,,,,yes", ""]), encoding="utf-8")
    part = read_pick_part(FIXTURES / "tee" / "tee.step", options=SeamOptions(), choice=SeamChoice())
    session = PickSession(part)
    shared, _ = start_table(find_table(Path(table.name)), part, part_step=FIXTURES / "tee" / "tee.step")
    server = PickServer(session, shared, build_pick_page(part, session.options))
    threading.Thread(target=server.run, daemon=True).start()
    return server.url


def hover_a_feature(page: Any, folder: Path) -> None:
    """Put the pointer near the hole whose coordinates are missing."""
    page.wait_for_timeout(1000)
    spot = page.evaluate("p => window.wpcal.project(p)", [20, 20, 10])
    box = page.locator(".stage canvas").bounding_box()
    page.mouse.move(box["x"] + spot["x"] + 5, box["y"] + spot["y"] + 5)
    page.wait_for_timeout(500)


def on_the_way(page: Any, folder: Path) -> None:
    """Let both robots be twelve seconds on the way."""
    page.evaluate("window.wpcal.seek(12)")


def open_details(page: Any, folder: Path) -> None:
    """Unfold the details of the fit."""
    page.locator("#fit summary").click()


SHOTS = (
    Shot("pick", picker_of_tee, width=1366, height=768, act=hover_a_feature),
    Shot("report", report_of("tee")),
    Shot("report-seam", report_of("tee"), act=hover_a_seam, element="#view"),
    Shot("report-points", report_of("tee"), element="#points"),
    Shot("report-seams", report_of("tee"), element="#seams"),
    Shot("report-pose", report_of("tee"), element="#pose"),
    Shot("report-fit", report_of("tee"), act=open_details, element="#fit"),
    Shot("report-frame", report_of("frame"), act=see_through, element="#view"),
    Shot("report-fail", report_of("tee", off_mm=2.5), height=1150),
    Shot("report-phone", report_of("saddle"), width=390, height=844),
    Shot("plan", plan_of_saddle, width=1160, height=800, act=on_the_way),
    Shot("plan-curves", plan_of_saddle, height=860, act=on_the_way, element=".charts"),
)


@contextlib.contextmanager
def browser() -> Iterator[Any]:
    chromium = shutil.which("chromium")
    if chromium is None:
        raise SystemExit("make shots needs chromium; as root: sh .ci/browser")
    with sync_playwright() as driver:
        running = driver.chromium.launch(executable_path=chromium, args=FLAGS)
        yield running
        running.close()


def take(shot: Shot, running: Any) -> None:
    with tempfile.TemporaryDirectory() as name, contextlib.chdir(name):  # pages show names as a person types them
        folder = Path(name)
        page = running.new_page(viewport={"width": shot.width, "height": shot.height})
        page.goto(shot.page(folder))
        while not page.evaluate("Boolean(window.wpcal && window.wpcal.ready)"):
            page.wait_for_timeout(50)
        shot.act(page, folder)
        page.wait_for_timeout(300)
        data = page.locator(shot.element).screenshot() if shot.element else page.screenshot()
        page.close()
    target = IMAGES / f"{shot.name}.png"
    imsave(target, imread(io.BytesIO(data))[..., :3])  # without the alpha channel, which nothing uses
    size = target.stat().st_size
    print(f"{target.relative_to(ROOT)}: {size / 1000:.0f} kB{' - too large' if size > LARGEST_BYTES else ''}")


with browser() as chromium:
    for one in SHOTS:
        if not sys.argv[1:] or one.name in sys.argv[1:]:
            take(one, chromium)
