"""A newcomer with the README and a part of his own, up to the first report: every click and letter is counted.

What a person does is counted at a slow pace, what the machine does in processor time. Touching the points at the robot
is not part of it.
"""

import json
import resource
import subprocess
import sys
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.robot_servers import Robot
from tests.samples.walked_parts import PARTS, put_part
from wpcal.core.transform import RigidTransform

CLICK_S = 3.0
LETTER_S = 1.0  #: 60 letters a minute.
READ_S = 5.0  #: To look at what a command printed and find the next line of the README, which is copied.
PICKER_S = 5.0
"""Processor time until the page of such a part is there, measured by hand: the process is still running."""
ALLOWED_S, ALLOWED_WITH_ROBOT_S = 300.0, 90.0
NAME = "my_part.step"
SIGMA_MM = 0.1
T_MM, DEGREES = np.array([940.0, -310.0, 205.0]), (0.4, -0.3, 31.0)
WAIT_S = 600
README = (Path(__file__).parents[2] / "README.md").read_text(encoding="utf-8")


@dataclass
class Walk:
    """What was done, and how long it takes."""

    folder: Path
    steps: list[tuple[str, float, float]] = field(default_factory=list)

    def wpcal(self, line: str, *codes: int) -> str:
        """Copy a line of the README, put the part's name in, and run it."""
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        assert line.replace(NAME, "part.step") in README, f"the README has no line {line}"
        words = [sys.executable, "-m", "wpcal", *line.split()]
        done = subprocess.run(words, cwd=self.folder, capture_output=True, text=True, check=False, timeout=WAIT_S)
        assert done.returncode in (codes or (0,)), f"{line}: {done.stdout}{done.stderr}"
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
        used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
        human = READ_S + 2 * CLICK_S + LETTER_S * (len(NAME) if NAME in line else 0)
        self.steps.append((f"wpcal {line}", human, used))
        return done.stdout

    def type(self, opened: Any, text: str) -> None:
        """Type a value and go on with Enter."""
        opened.page.keyboard.type(text)
        opened.page.keyboard.press("Enter")
        self.steps.append((f"type {text}", LETTER_S * (len(text) + 1), 0.0))

    def click(self, opened: Any, what: str) -> None:
        opened.page.locator(what).first.click()
        self.steps.append((f"click {what}", CLICK_S, 0.0))

    def told(self) -> str:
        """Every step with its seconds, and the sums."""
        lines = [f"{human:6.1f} {machine:6.1f}  {what}" for what, human, machine in self.steps]
        human, machine = (sum(step[k] for step in self.steps) for k in (1, 2))
        return "\n".join(["person machine  step", *lines, f"{human:6.1f} {machine:6.1f}  in all"])


@pytest.mark.deep
@pytest.mark.parametrize("part", PARTS)
def test_first_report_within_five_minutes(part: str, start: Any, open_page: Any, tmp_path: Path) -> None:
    put_part(part, tmp_path / NAME)
    walk = Walk(tmp_path)
    walk.wpcal(f"features {NAME}")
    walk.wpcal(f"seams {NAME}")
    walk.wpcal(f"advise {NAME} --count 4 -o taught.csv")
    walk.wpcal(f"sheet {NAME} taught.csv -o sheet.pdf")
    listed = subprocess.run(
        [sys.executable, "-m", "wpcal", "features", NAME, "--json"], cwd=tmp_path, capture_output=True, check=True
    )
    places = {feature["name"]: np.array(feature["p_mm"]) for feature in json.loads(listed.stdout)["features"]}
    R, rng = Rotation.from_euler("xyz", DEGREES, degrees=True), np.random.default_rng(7)

    opened = open_page(start(tmp_path / NAME).url)
    opened.wait("window.wpcal.idle")
    walk.steps.append((f"wpcal pick {NAME}", READ_S + 2 * CLICK_S + LETTER_S * len(NAME), PICKER_S))
    rows = [line.get_attribute("data-name") for line in opened.page.locator("#points tbody tr").all()]
    assert len(rows) == 4
    for name in rows:
        walk.click(opened, f"tr[data-name={name}] input[aria-label=x_mm]")
        for value in R.apply(places[name]) + T_MM + rng.normal(0.0, SIGMA_MM, 3):
            walk.type(opened, f"{value:.2f}")
    opened.wait("window.wpcal.idle")
    assert opened.page.inner_text("#state").startswith(("PASS", "UNSURE")), opened.page.inner_text("#state")
    walk.click(opened, "#save")
    opened.wait("document.querySelector('#save-state').textContent.startsWith('saved 4 rows to taught.csv')")

    said = walk.wpcal(f"calibrate {NAME} taught.csv -o out --tolerance-mm 0.5", 0, 1)
    assert (tmp_path / "out" / "report.html").exists()
    print(walk.told(), said[-800:], sep="\n")
    assert sum(human + machine for _, human, machine in walk.steps) <= ALLOWED_S, walk.told()


@pytest.mark.deep
def test_first_report_with_a_robot_that_tells_its_position(start: Any, open_page: Any, tmp_path: Path) -> None:
    """The line that calibrates is the one that the page shows: it is copied whole."""
    put_part("hopper", tmp_path / NAME)
    walk, typed = Walk(tmp_path), " --robot kuka:192.168.0.10"
    listed = subprocess.run(
        [sys.executable, "-m", "wpcal", "features", NAME, "--json"], cwd=tmp_path, capture_output=True, check=True
    )
    places = {feature["name"]: np.array(feature["p_mm"]) for feature in json.loads(listed.stdout)["features"]}
    R, rng, robot = Rotation.from_euler("xyz", DEGREES, degrees=True), np.random.default_rng(7), Robot(delay_s=0.02)
    with robot.serve("kuka") as port:
        opened = open_page(start(tmp_path / NAME, "--robot", f"kuka:127.0.0.1:{port}").url)
        walk.steps.append((f"wpcal pick{typed}", READ_S + 2 * CLICK_S + LETTER_S * len(NAME + typed), PICKER_S))
        walk.click(opened, "#suggest")
        opened.wait("document.querySelectorAll('#points tbody tr').length === 4")
        for name in [line.get_attribute("data-name") for line in opened.page.locator("#points tbody tr").all()]:
            place = np.round(R.apply(places[name]) + T_MM + rng.normal(0.0, SIGMA_MM, 3), 2)
            robot.T_base_tool = RigidTransform(np.eye(3), place, "base", "tool")
            opened.page.keyboard.press("F2")
            walk.steps.append(("press F2", LETTER_S, 0.0))
            opened.wait(f"document.querySelector('tr[data-name={name}] [aria-label=x_mm]').value !== ''")
        opened.wait("window.wpcal.idle")
        walk.click(opened, "#save")
        opened.wait("document.querySelector('#save-state').textContent.startsWith('saved 4 rows to taught.csv')")
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    words = [sys.executable, "-m", "wpcal", "calibrate", NAME, "taught.csv", "-o", "RESULT"]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False, timeout=WAIT_S)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    used = after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime
    walk.steps.append(("the line of the page", READ_S + 2 * CLICK_S, used))
    assert done.returncode in (0, 1), done.stderr
    print(walk.told(), done.stdout[-800:], sep="\n")
    assert sum(human + machine for _, human, machine in walk.steps) <= ALLOWED_WITH_ROBOT_S, walk.told()
