"""Take the picture of a plan's page for the pages of docs. Usage: python docs/make_plan_picture.py (needs chromium)."""

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from playwright.sync_api import sync_playwright

ROOT = Path(__file__).parents[1]
CELLS = ROOT / "fixtures" / "cells"
FLAGS = ["--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
SECONDS = 12.0


def main() -> None:
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as driver:
        arguments = [CELLS / "two-mh6.json", CELLS / "saddle-seams.json", "--seam", "W1", "-o", f"{folder}/plan"]
        subprocess.run([sys.executable, "-m", "wpcal", "plan", *map(str, arguments)], check=True, capture_output=True)
        browser = driver.chromium.launch(executable_path=shutil.which("chromium"), args=FLAGS)
        page = browser.new_page(viewport={"width": 1280, "height": 860})
        page.goto(Path(folder, "plan", "plan.html").as_uri())
        page.wait_for_selector("[data-test=freedom]:has-text('FREE')")
        page.evaluate(f"window.wpcal.seek({SECONDS})")
        page.wait_for_timeout(500)  # the view draws in the next frame
        page.screenshot(path=str(ROOT / "docs" / "images" / "plan.png"))
        browser.close()


main()
