"""`wpcal teach`: a key per row, what must not be a row, and when it is enough."""

import csv
import io
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.robot_servers import Robot
from tests.running import run_here
from wpcal.core.readings import readings_of_table
from wpcal.core.tables import parse_table
from wpcal.core.transform import RigidTransform
from wpcal.robot.links.judge import STILL_S
from wpcal.taught.table import taught_from_table

pytestmark = pytest.mark.usefixtures("kernel_here")
TEE = Path(__file__).parents[2] / "fixtures" / "tee" / "tee.step"
T_BASE_PART = RigidTransform.from_six_tuple([812.34, -45.67, 501.02, 0.4, -0.2, 2.5], target="base", source="part")
NAMES = ("V2", "V4", "V14", "V12")


class Hand(io.StringIO):
    """A person at the keyboard: does something with the robot, and presses a key."""

    def __init__(self, *does: Callable[[], str]) -> None:
        super().__init__()
        self._does = iter(does)

    def readline(self, *_: object) -> str:  # type: ignore[override]
        return next(self._does, lambda: "")()


@pytest.fixture(scope="module")
def places(kernel_here: None) -> dict[str, list[float]]:
    found = json.loads(run_here("features", TEE, "--json").stdout)["features"]
    return {feature["name"]: feature["p_mm"] for feature in found}


def test_a_key_per_row_until_it_is_enough(
    places: dict[str, list[float]], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    robot = Robot()

    def touch(name: str, *, tool: str = "7", key: str = "\n") -> Callable[[], str]:
        def does() -> str:
            p = np.round(T_BASE_PART.apply(np.array(places[name])), 2)
            robot.T_base_tool, robot.tool = RigidTransform(T_BASE_PART.R, p, "base", "tool"), tool
            return key

        return does

    template = "name,x_mm,y_mm,z_mm\n" + "".join(f"{name},,,\n" for name in NAMES)
    (tmp_path / "template.csv").write_text(template, encoding="utf-8")
    wrong = touch("V2", tool="8")
    hand = Hand(touch("V2"), touch("V14"), lambda: "u\n", wrong, *(touch(name) for name in NAMES[1:]))
    monkeypatch.setattr("sys.stdin", hand)
    with robot.serve("kuka") as port:
        words = ("--robot", f"kuka:127.0.0.1:{port}", "--tolerance-mm", "0.4", "-o", "taught.csv")
        done = run_here("teach", TEE, "template.csv", *words, cwd=tmp_path)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "tool 8 is active, the row before was touched with tool 7" in done.stdout
    assert "V4: taken back" in done.stdout
    assert "enough: all seams are within the tolerance" in done.stdout
    assert "PASS for a tolerance of 0.4 mm" in done.stdout
    with (tmp_path / "taught.csv").open(encoding="utf-8") as file:
        saved = {row["name"]: [float(row[key]) for key in ("x_mm", "y_mm", "z_mm")] for row in csv.DictReader(file)}
    assert list(saved) == list(NAMES)
    table = parse_table((tmp_path / "taught.csv").read_bytes(), path="")
    kept = readings_of_table(table)
    assert {(read.tool, read.frame, read.configuration) for read in kept if read} == {("7", "3", "S 2, T 35")}
    assert all(read and read.still_s >= STILL_S and read.joints_deg == list(robot.joints_deg) for read in kept)
    np.testing.assert_allclose(taught_from_table(table).R_base_tool, [T_BASE_PART.R] * 4, rtol=0, atol=1e-6)
    was, now = (f"V2,{saved['V2'][0] + by:.3f}".encode() for by in (0.0, 0.002))
    typed_over = parse_table((tmp_path / "taught.csv").read_bytes().replace(was, now, 1), path="")
    assert [read is None for read in readings_of_table(typed_over)] == [True, False, False, False]
    for name, read in saved.items():
        np.testing.assert_allclose(read, T_BASE_PART.apply(np.array(places[name])), rtol=0, atol=0.01)


@pytest.mark.parametrize(
    ("robot", "says"),
    [
        (None, "teach needs --robot KIND:ADDRESS"),
        ("irb1600_6_12", "teach needs"),
        ("kuka:127.0.0.1:9", "no connection"),
    ],
)
def test_without_a_robot_it_is_one_line_and_nothing_is_written(robot: str | None, says: str, tmp_path: Path) -> None:
    words = () if robot is None else ("--robot", robot)
    done = run_here("teach", TEE, "-o", "taught.csv", *words, cwd=tmp_path)
    assert done.returncode == 2
    assert says in done.stderr
    assert not (tmp_path / "taught.csv").exists()
