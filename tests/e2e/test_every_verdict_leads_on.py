"""A newcomer who types only what wpcal tells him comes to a program, whatever the verdict: PASS, UNSURE or FAIL.

What is counted is typing (60 letters a minute) and reading (5 s for what a command printed), not touching and waiting.
A line that was typed before is fetched with the arrow key; where the end differs, that end is typed again.
"""

import csv
import json
import re
import sys
import time
from dataclasses import dataclass, field
from pathlib import Path
from subprocess import DEVNULL, PIPE, Popen

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.few import few
from tests.robot_servers import Robot
from tests.running import run_here
from tests.samples.walked_parts import PARTS, put_part
from wpcal.core.transform import RigidTransform
from wpcal.robot.links.judge import STILL_S

DAYS = {"mistyped": (0.1, 10.0), "good": (0.1, 0.0), "scattered": (0.35, 0.0)}
"""How the points are touched: standard deviation per axis, and by how much the second one is mistyped, mm."""
REPORT_S, PROGRAM_S = 240.0, 300.0
POINT_S, FEW_POINTS = 24.0, 6  #: Typing of each point beyond six: how many the scatter asks for is not ours to say.
LETTER_S, READ_S, ARROWS = 1.0, 5.0, 2  #: The keys with which a line typed before is fetched, and left again.
MOST_ROUNDS = 6  #: Touches that wpcal may ask for until it is content, or says that it cannot be.
R, T_MM = Rotation.from_euler("xyz", (0.4, -0.3, 31.0), degrees=True), np.array([940.0, -310.0, 205.0])

pytestmark = pytest.mark.usefixtures("kernel_here")


@dataclass
class Newcomer:
    """He types commands and numbers; seconds count both."""

    folder: Path
    sigma_mm: float
    seconds: float = 0.0
    typed: list[str] = field(default_factory=list)
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(11))
    places: dict[str, np.ndarray] = field(default_factory=dict)

    def wpcal(self, line: str) -> str:
        """Type a command; one that ends with wrong use is a wrong turn."""
        done = run_here(*line.split(), cwd=self.folder)
        assert done.returncode in (0, 1), f"wrong turn: {line}: {done.stderr}"
        self.seconds += READ_S + LETTER_S * self.keys(f"wpcal {line}")
        self.typed.append(line)
        return done.stdout + done.stderr

    def keys(self, line: str) -> int:
        """Return how many keys he presses, the shortest way."""
        heads = [[a == b for a, b in zip(line, f"wpcal {before}", strict=False)] for before in self.typed]
        other = len(line) - max(((*head, False).index(False) for head in heads), default=0)
        return min(len(line), ARROWS + 2 * other)

    def move_to(self, name: str, off_mm: float = 0.0) -> np.ndarray:
        """Touch a feature."""
        return R.apply(self.places[name]) + T_MM + self.rng.normal(0.0, self.sigma_mm, 3) + [off_mm, 0.0, 0.0]

    def touch(self, rows: dict[str, list[str]], name: str, off_mm: float = 0.0) -> None:
        """Read a position from the pendant and type it."""
        rows[name] = [f"{value:.2f}" for value in self.move_to(name, off_mm)]
        self.seconds += LETTER_S * sum(len(value) + 1 for value in rows[name])

    def save(self, rows: dict[str, list[str]]) -> None:
        """Write the table."""
        with (self.folder / "taught.csv").open("w", newline="") as file:
            csv.writer(file).writerows(
                [["name", "x_mm", "y_mm", "z_mm"], *([name, *row] for name, row in rows.items())]
            )


def asked(said: str, places: dict[str, np.ndarray]) -> list[str]:
    """Return the points that the first of the next lines asks for that names any."""
    lines = (line for line in said.splitlines() if line.startswith("next: "))
    named = ([name for name in re.findall(r"\b[A-Z]+\d+\b", line) if name in places] for line in lines)
    return next((names for names in named if names), [])


def newcomer(part: str, day: str, tmp_path: Path) -> Newcomer:
    """Return him with the part and its features, in a new folder."""
    put_part(part, tmp_path / "part.step")
    person = Newcomer(tmp_path, DAYS[day][0])
    features = json.loads(run_here("features", "part.step", "--json", cwd=tmp_path).stdout)["features"]
    person.places = {one["name"]: np.array(one["p_mm"]) for one in features}
    return person


@pytest.mark.parametrize("day", few(DAYS, 1))
@pytest.mark.parametrize("part", few(PARTS, 1))
def test_what_wpcal_says_next_leads_to_a_program(part: str, day: str, tmp_path: Path) -> None:
    person, mistyped_mm = newcomer(part, day, tmp_path), DAYS[day][1]
    person.wpcal("advise part.step -o taught.csv")
    with (tmp_path / "taught.csv").open(newline="") as file:
        names = [row["name"] for row in csv.DictReader(file)]
    rows: dict[str, list[str]] = {}
    for k, name in enumerate(names):
        person.touch(rows, name, mistyped_mm if k == 1 else 0.0)
    person.save(rows)
    verdicts, report_s = [], None
    for number in range(MOST_ROUNDS):
        said = person.wpcal(f"calibrate part.step taught.csv -o out{number}")
        report_s = report_s or person.seconds
        verdicts.append(json.loads((tmp_path / f"out{number}" / "calibration.json").read_text())["verdict"])
        if verdicts[-1] == "PASS":
            break
        wanted = asked(said, person.places)
        assert wanted, f"{verdicts}: nothing to do next in {said[-1500:]}"
        for name in wanted:
            person.touch(rows, name)
        person.save(rows)
    assert report_s is not None
    assert report_s <= REPORT_S, person.typed
    if verdicts[-1] == "PASS":
        person.wpcal(f"export out{number} -f rapid")
        print(part, day, verdicts, f"report {report_s:.0f} s, program {person.seconds:.0f} s", len(rows), "points")
        assert person.seconds <= PROGRAM_S + POINT_S * max(len(rows) - FEW_POINTS, 0), person.typed
    else:
        assert day == "scattered", verdicts


@pytest.mark.deep
@pytest.mark.parametrize("day", few(DAYS, 1))
@pytest.mark.parametrize("part", few(PARTS, 1))
def test_where_a_key_reads_the_robot_no_number_of_points_is_too_long(part: str, day: str, tmp_path: Path) -> None:
    person, robot, count = newcomer(part, day, tmp_path), Robot(), 0
    with robot.serve("kuka") as port:
        line = f"teach part.step -o taught.csv --robot kuka:127.0.0.1:{port}"
        words = [sys.executable, "-u", "-m", "wpcal", *line.split()]
        with Popen(words, cwd=tmp_path, stdin=PIPE, stdout=PIPE, stderr=DEVNULL, text=True) as teach:
            while name := asked_by(teach):
                p = person.move_to(name, DAYS[day][1] if count == 1 else 0.0)
                robot.T_base_tool = RigidTransform(np.eye(3), p, "base", "tool")
                time.sleep(2.0 * STILL_S)
                teach.stdin.write("\n")
                teach.stdin.flush()
                count, person.seconds = count + 1, person.seconds + READ_S + LETTER_S
        person.typed, person.seconds = [line], person.seconds + READ_S + LETTER_S * len(f"wpcal {line}")
        assert teach.returncode == 0
    person.wpcal("calibrate part.step taught.csv -o out")
    person.wpcal("export out -f rapid")
    print(part, day, f"program {person.seconds:.0f} s", count, "keys")
    assert person.seconds <= PROGRAM_S, person.typed


def asked_by(teach: Popen[str]) -> str:
    """Return the feature that is to be touched now; empty when the command has ended."""
    said = ""
    while not (found := re.search(r"^touch (\w+), .*q: end\]$", said, re.MULTILINE)):
        letter = teach.stdout.read(1)
        if not letter:
            return ""
        said += letter
    return found[1]
