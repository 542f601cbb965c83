"""The controller's own program as the file of taught points: the same numbers as from the table."""

import csv
import json
from pathlib import Path

import numpy as np
import pytest

from tests.running import run_here
from wpcal.core.rotations import rotation_from_zyx

pytestmark = pytest.mark.usefixtures("kernel_here")

TEE = Path(__file__).parents[2] / "fixtures" / "tee"
FRAME = (500.0, 100.0, 50.0)  #: Of a user frame that is not turned: its points are the taught ones minus this.
SAME_MM = 1e-9  #: The coordinates have two decimals; adding and subtracting the frame leaves round-off.


def taught_rows() -> list[dict[str, str]]:
    return list(csv.DictReader((TEE / "taught.csv").read_text().splitlines()))


def krl(names: list[str], *, with_frame: bool) -> str:
    lines = ["DEFDAT TEACH"]
    x0, y0, z0 = FRAME
    if with_frame:
        lines.append(f"BASE_DATA[7]={{FRAME: X {x0},Y {y0},Z {z0},A 0.0,B 0.0,C 0.0}}")
    for name, row in zip(names, taught_rows(), strict=True):
        x, y, z = (float(row[f"{axis}_mm"]) - origin for axis, origin in zip("xyz", FRAME, strict=True))
        lines.append(f"DECL E6POS X{name}={{X {x:.4f},Y {y:.4f},Z {z:.4f},A 0.0,B 90.0,C 0.0,S 2,T 35}}")
        lines.append(f'DECL FDAT F{name}={{TOOL_NO 1,BASE_NO 7,IPO_FRAME #BASE,POINT2[] " "}}')
    return "\n".join([*lines, "ENDDAT", ""])


def calibrated(program: Path, out: Path, *options: str) -> dict[str, object]:
    done = run_here("calibrate", TEE / "tee.step", program, "-o", out, *options)
    assert (done.returncode, done.stderr) == (0, ""), done.stderr
    record: dict[str, object] = json.loads((out / "calibration.json").read_text())
    return record


@pytest.fixture(scope="module")
def from_table(tmp_path_factory: pytest.TempPathFactory) -> dict[str, object]:
    """The record of a calibration from the same points as a table."""
    folder = tmp_path_factory.mktemp("table")
    table = folder / "taught.csv"
    table.write_text((TEE / "taught.csv").read_text().replace("check", "yes"))
    return calibrated(table, folder / "table")


def assert_same(found: dict[str, object], expected: dict[str, object]) -> None:
    for key in ("T_base_part", "objective_mm"):
        np.testing.assert_allclose(np.array(found[key]), np.array(expected[key]), rtol=0, atol=SAME_MM)


def test_named_points_give_the_numbers_of_the_table(tmp_path: Path, from_table: dict[str, object]) -> None:
    program = tmp_path / "teach.dat"
    program.write_text(krl([row["name"] for row in taught_rows()], with_frame=True))
    found = calibrated(program, tmp_path / "out")
    assert_same(found, from_table)
    assert "features" not in found


def test_numbered_points_are_found_and_the_frame_is_given(tmp_path: Path, from_table: dict[str, object]) -> None:
    program = tmp_path / "teach.dat"
    program.write_text(krl(["P1", "P2", "P3", "P4", "P5", "P6"], with_frame=False))
    frame = ("--uframe", "7=500,100,50,0,0,0")
    found = calibrated(program, tmp_path / "out", *frame)
    assert_same(found, from_table)
    assert found["features"] == {f"P{n}": row["name"] for n, row in enumerate(taught_rows(), 1)}
    match = run_here("match", TEE / "tee.step", program, *frame, "--json")
    assert (match.returncode, match.stderr) == (0, "")
    record = json.loads(match.stdout)
    assert record["answers"][record["chosen"]]["features"] == [row["name"] for row in taught_rows()]


@pytest.mark.parametrize("command", [("calibrate", "-o", "out"), ("match",)])
def test_a_frame_without_values_is_asked_for(tmp_path: Path, command: tuple[str, ...]) -> None:
    program = tmp_path / "teach.dat"
    program.write_text(krl(["P1", "P2", "P3", "P4", "P5", "P6"], with_frame=False))
    options = [str(tmp_path / word) if word == "out" else word for word in command[1:]]
    done = run_here(command[0], TEE / "tee.step", program, *options)
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.count("\n") == 1
    assert "teach.dat, line 2: point P1: is in user frame 7" in done.stderr
    assert "give the user frame as 7=X,Y,Z,A,B,C (--uframe)" in done.stderr
    assert not (tmp_path / "out").exists()


def test_a_program_with_a_home_position_is_read_by_naming_the_others(
    tmp_path: Path, from_table: dict[str, object]
) -> None:
    program = tmp_path / "teach.dat"
    text = krl([row["name"] for row in taught_rows()], with_frame=True)
    home = "DECL E6AXIS XHOME={A1 0.0,A2 -90.0,A3 90.0,A4 0.0,A5 0.0,A6 0.0}"
    program.write_text(text.replace("\n", f"\n{home}\n", 1))
    done = run_here("calibrate", TEE / "tee.step", program, "-o", tmp_path / "out")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "HOME: is stored as joint angles" in done.stderr
    assert "or name the points to read (--robot and --tool, or --points)" in done.stderr
    names = ",".join(row["name"] for row in taught_rows())
    assert_same(calibrated(program, tmp_path / "out", "--points", names), from_table)


def test_options_for_programs_are_refused_with_a_table(tmp_path: Path) -> None:
    done = run_here("calibrate", TEE / "tee.step", TEE / "taught.csv", "-o", tmp_path / "out", "--tool", "0,0,1")
    assert done.returncode == 2
    assert "is not a controller program: --tool cannot be used with it" in done.stderr


def test_a_program_touched_in_several_postures_shows_a_wrong_tool(tmp_path: Path) -> None:
    """The tip is 1.2 mm beside the tool centre point of the controller, in a frame that is turned."""
    rng, tip = np.random.default_rng(0), np.array([0.8, -0.8, 0.4])
    frame = rotation_from_zyx(0.0, 0.0, np.pi / 2)
    lines = ["DEFDAT TEACH", "BASE_DATA[7]={FRAME: X 500,Y 100,Z 50,A 90.0,B 0.0,C 0.0}"]
    for row in csv.DictReader((TEE / "taught_exact.csv").read_text().splitlines()):
        angles = np.radians([0, 90, 0]) + 0.4 * rng.normal(size=3)  # about x, y, z of the frame
        shown = np.array([float(row[f"{axis}_mm"]) for axis in "xyz"]) + 0.05 * rng.normal(size=3)
        shown = frame.T @ (shown - FRAME) - rotation_from_zyx(*angles) @ tip
        c, b, a = np.degrees(angles)
        place = ",".join(f"{axis} {v:.4f}" for axis, v in zip("XYZABC", [*shown, a, b, c], strict=True))
        lines.append(f"DECL E6POS X{row['name']}={{{place},S 2,T 35}}")
        lines.append(f'DECL FDAT F{row["name"]}={{TOOL_NO 1,BASE_NO 7,IPO_FRAME #BASE,POINT2[] " "}}')
    program = tmp_path / "teach.dat"
    program.write_text("\n".join([*lines, "ENDDAT", ""]))
    for source in (program, tmp_path / "taught.csv"):
        done = run_here("calibrate", TEE / "tee.step", source, "-o", tmp_path / f"out{source.suffix}")
        assert done.returncode == 1
        record = json.loads((tmp_path / f"out{source.suffix}" / "calibration.json").read_text())
        found = record["tool_offset"]
        assert np.linalg.norm(np.array(found["tip_mm"]) - tip) <= found["error_95_mm"] <= 0.5
        assert record["judgement"]["sentence"].startswith("the tip is 1")
        assert run_here("taught", program, "-o", tmp_path / "taught.csv", "--force").returncode == 0
