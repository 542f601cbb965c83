"""Written programs are read back: a pose that is lost, changed, out of reach or inside the part does not pass."""

import re
import shutil
from dataclasses import replace
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.running import run_here
from tests.unit.conftest import CONFIGURATIONS
from tests.unit.controllers.judging import judged
from wpcal.controllers.audit import audit_path
from wpcal.controllers.audit.off_line import Track, off_line_faults
from wpcal.controllers.judge.written import WrittenWrongError
from wpcal.controllers.program import ControllerSettings, WeldProgram, build_program
from wpcal.controllers.program.checked_program import check_program
from wpcal.controllers.program.coordinated_program import SyncProgram
from wpcal.controllers.registry import controller_named, exporter_named
from wpcal.results.folder import read_finished
from wpcal.robot.kinematics.arm_file import find_arm

FIXTURES = Path(__file__).parents[4] / "fixtures"
WRITERS = ("rapid", "krl", "fanuc", "inform", "urscript", "val3", "as", "pdl2")
COORDINATE = {
    "rapid": (r"(W2_0007:=\[\[)([-\d.]+)", 1.0),
    "krl": (r"(W2_0007=\{X )([-\d.]+)", 1.0),
    "fanuc": (r"(P\[7\]\{.*?X =\s*)([-\d.]+)", 1.0),
    "inform": (r"(C00007=)([-\d.]+)", 1.0),
    "urscript": (r"(# W3.*?# ARC ON.*?p\[)([-\d.]+)", 0.001),
    "val3": (r'(<Data name="W2".*?key="7" x=")([-\d.]+)', 1.0),
    "pdl2": (r"(W2_0007 := POS\()([-\d.]+)", 1.0),
    "as": (r"(W2_0002 )([-\d.]+)(?= [-\d.]+ [-\d.]+ )", 1.0),
}
"""Where an x of a point of a seam is in each language, and a millimetre there."""


@cache
def program(part: str = "tee") -> WeldProgram:
    finished = read_finished(FIXTURES / part / "golden").select()
    settings = ControllerSettings(configurations=CONFIGURATIONS)
    return check_program(build_program(finished, controller=settings))


def moved(text: str, name: str, by_mm: float) -> str:
    """The text with another x at one point of a seam."""
    pattern, mm = COORDINATE[name]
    changed, count = re.subn(pattern, lambda m: f"{m[1]}{float(m[2]) + by_mm * mm:.6f}", text, count=1, flags=re.DOTALL)
    assert count in (0, 1)
    return changed


@pytest.mark.parametrize("name", WRITERS)
def test_what_is_written_is_read_back_as_it_was_asked_for(name: str) -> None:
    written = judged(exporter_named(name).write(program()), program(), name)
    assert (written.not_checked, written.unjudged) == ((), ())
    assert written.program.checked


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("by_mm", [0.5, -40.0, float("nan")])
def test_a_changed_number_is_found(name: str, by_mm: float) -> None:
    files = dict(exporter_named(name).write(program()))
    changed = {file: moved(str(text), name, by_mm) for file, text in files.items()}
    assert changed != files
    with pytest.raises(WrittenWrongError, match="nothing is written") as caught:
        judged(changed, program(), name)
    assert caught.value.exit_code == 70


@pytest.mark.parametrize("name", WRITERS)
@pytest.mark.parametrize("by_mm", [float("nan"), 2e5])
def test_an_audit_finds_a_number_that_is_no_coordinate(name: str, by_mm: float, tmp_path: Path) -> None:
    for file, text in exporter_named(name).write(program()).items():
        (tmp_path / file).write_bytes(moved(str(text), name, by_mm).encode("utf-8"))
    wrong = [file for file in audit_path(tmp_path).files if file.faults]
    assert any(file.checked.endswith("NOT CHECKED: what its instructions do") for file in wrong)
    assert all(one.line is not None or one.field is not None or name == "val3" for file in wrong for one in file.faults)


@pytest.mark.parametrize(
    ("part", "by_mm", "off"),
    [("tee", (0, 0, 0), ""), ("tee", (0, 0, 8), "8.0"), ("saddle", (0, -0.9, -1.2), "1.[2-5]")],
)
@pytest.mark.parametrize("name", WRITERS)
def test_an_audit_finds_a_pose_beside_its_seam(
    name: str, part: str, by_mm: tuple[float, ...], off: str, tmp_path: Path
) -> None:
    """By 8 mm into the joint: the move there and the one after it are told as well."""
    folder = shutil.copytree(FIXTURES / part / "golden", tmp_path / "out")
    (folder / name).mkdir()
    *first, path = program(part).paths[:2]
    p, row = path.p_base.copy(), path.weld_rows.start + 4
    p[row] += path.R_base[row] @ by_mm
    wrong = replace(program(part), paths=(*first, replace(path, p_base=p), *program(part).paths[2:]))
    for file, text in exporter_named(name).write(wrong).items():
        (folder / name / file).write_bytes(str(text).encode("utf-8"))
    faults = [fault for file in audit_path(folder).files for fault in file.faults]
    assert len(faults) == bool(off) + 2 * (by_mm[2] > 0)
    assert all(fault.line and "of a straight torch of 300 mm" in fault.message for fault in faults[:-1])
    for fault in faults[-1:]:
        assert re.fullmatch(rf"the wire is {off} mm off the line of {path.seam.name}", fault.message)


def test_a_ring_that_ends_with_another_lean_than_it_begins_keeps_to_its_line() -> None:
    """INFORM says the start of an arc once more: several poses are there, and the end is as near as the start."""
    T = np.tile(np.eye(4), (120, 1, 1))
    turn = np.linspace([0.0, 0.0, 0.0], [0.2, 0.0, 2.0 * np.pi], 120)
    T[:, :3, 3] = 12.5 * Rotation.from_rotvec(turn * [0, 0, 1]).as_matrix()[:, :, 0]
    T[:, :3, :3] = Rotation.from_rotvec(turn * [1, 0, 0]).as_matrix()
    begin = T[[0, 0, 0]]
    begin[:, 1, 3] -= 1e-9
    line = Track.dense("W1", T[:, :3, 3], T[:, :3, :3], is_planned=True)
    placed: list[Any] = [(SimpleNamespace(seam=1), each) for each in (begin, T)]
    assert [*off_line_faults(placed, [line])] == []


@pytest.mark.parametrize(("what", "told"), [("weld", "8 mm/s along a seam: its"), ("air", "100 mm/s in the air: its")])
@pytest.mark.parametrize("name", WRITERS)
def test_an_audit_finds_a_line_faster_than_its_header_says(name: str, what: str, told: str, tmp_path: Path) -> None:
    """Where no header says a speed, none is compared, and that is said."""
    reports = []
    for put in (r"\g<1>7", "fast"):
        for file, text in exporter_named(name).write(program()).items():
            slower = re.sub(rf"({what} speed <= )\d+", put, str(text), flags=re.IGNORECASE)
            (tmp_path / file).write_bytes(slower.encode("utf-8"))
        reports.append(audit_path(tmp_path).files)
    messages = {fault.message for file in reports[0] for fault in file.faults}
    assert [message.startswith(told) for message in messages] == [True]
    said = [{"speeds: no header states" in f.checked for f in files if "program" in f.kind} for files in reports]
    assert said == [{False}, {True}]


def test_an_arm_that_does_not_reach_the_part_is_named(tmp_path: Path) -> None:
    (text,) = exporter_named("rapid").write(program()).values()
    path = tmp_path / "WPCAL.mod"
    path.write_text(str(text), encoding="utf-8")
    far = re.sub(r'(wpPart:=\[FALSE,TRUE,"",\[\[)[-\d.]+', r"\g<1>9000", str(text))
    near = run_here("audit", path, "--robot", "mh6", "--tool", "0,0,300")
    path.write_text(far, encoding="utf-8")
    ended = run_here("audit", path, "--robot", "mh6", "--tool", "0,0,300")
    assert near.returncode in (0, 1)
    assert ended.returncode == 1
    assert "no joint angles within the limits of" in ended.stdout
    assert ended.stdout.count("point ") > near.stdout.count("point ")


def test_a_program_that_reads_back_differently_is_not_put_in_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    from wpcal.controllers.abb import write

    right = write.write_rapid
    monkeypatch.setattr(write, "write_rapid", lambda one: {k: moved(v, "rapid", 1.0) for k, v in right(one).items()})
    golden = FIXTURES / "tee" / "golden"
    ended = run_here("export", golden, "--every-point", "-f", "krl", "-f", "rapid", "-o", tmp_path / "out")
    assert ended.returncode == 70
    assert re.search(r"rapid: WPCAL.mod, line \d+: the pose at base", ended.stderr)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ["rapid", "inform"])
def test_programs_of_two_robots_which_hold_joints_are_clean(name: str, tmp_path: Path) -> None:
    arms = (find_arm("irb1600_6_12"), find_arm("mh6"))
    moves = SyncProgram("W1", arms, (np.zeros((4, 6)), np.zeros((4, 6))), np.ones(3), 1, 2)
    for file, text in controller_named(name).write_sync(moves).items():
        (tmp_path / file).write_text(text, encoding="utf-8", newline="")
    assert audit_path(tmp_path).fault_count == 0


@pytest.mark.parametrize("beside", ["AAA", "ZZZ"])
def test_modules_beside_each_other_have_names_of_their_own(beside: str, tmp_path: Path) -> None:
    """A KRL module with the names of another one hides nothing of it, and its own faults are told, endless ones too."""
    folder = shutil.copytree(FIXTURES / "tee" / "golden", tmp_path / "tee")
    run_here("export", folder, "-f", "krl")
    source, data = ((folder / "krl" / f"WPCAL.{end}").read_text() for end in ("src", "dat"))
    pushed = re.sub(r"(E6POS W1_0001=\{X )[-\d.]+", r"\g<1>9000", data.replace("DEFDAT WPCAL", f"DEFDAT {beside}"))
    (folder / "krl" / f"{beside}.dat").write_text(pushed)
    endless = "DEF AGAIN()\nAGAIN()\nEND\nDEF SPINS()\nLOOP\nENDLOOP\nEND\n"
    (folder / "krl" / f"{beside}.src").write_text(f"{source}\n{endless}")
    told = {Path(each.path).name: [fault.message for fault in each.faults] for each in audit_path(folder / "krl").files}
    assert told["WPCAL.src"] == told["WPCAL.dat"] == []
    found = told[f"{beside}.src"] + told[f"{beside}.dat"]
    assert any("where no robot is" in what or "inside" in what for what in found), found
    assert sum("does not end" in what for what in found) == len(("AGAIN", "SPINS"))


def test_a_job_that_another_file_has_too_is_named(tmp_path: Path) -> None:
    folder = shutil.copytree(FIXTURES / "tee" / "golden", tmp_path / "tee")
    run_here("export", folder, "-f", "as", "--tool-name", "gun")
    shutil.copy(folder / "as" / "WPCAL.as", folder / "as" / "ZZZ.as")
    told = {Path(each.path).name: [fault.message for fault in each.faults] for each in audit_path(folder / "as").files}
    assert told["WPCAL.as"] == []
    assert "WPCAL is declared twice: WPCAL.as has it, too" in told["ZZZ.as"][0]
