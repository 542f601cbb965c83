"""A plan is kept: programs are written again from its folder alone, and from nothing that was changed."""

import json
import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from tests.one_robot_cells import TEE, TEE_ON_TABLE, one_robot_record, with_positioner, write_cell
from tests.running import run_here
from wpcal.controllers.judge.execute import execute, programs_of
from wpcal.controllers.judge.in_cell import CellSweep
from wpcal.core.arrays import FloatArray
from wpcal.planning.sequence.kept_plan import kept_plan_of, read_kept_plan

pytest.importorskip("fcl", reason="python-fcl is not installed")
LANGUAGES = ("rapid", "krl")
SAME_RAD = 1e-6  #: The languages write at least five decimals of a degree.
VALUES = {"job": 3, "current_a": 200.0, "voltage_v": 24.0, "speed_mm_s": 7.0}


def written(folder: Path) -> dict[str, bytes]:
    return {f"{path.parent.name}/{path.name}": path.read_bytes() for path in folder.glob("*/*") if path.is_file()}


def welds_file(folder: Path, name: str = "welds.json", **values: object) -> Path:
    record = {"schema": "wpcal/welds/1", "welds": [{"name": "W2", "values": {**VALUES, **values}}]}
    path = folder / name
    path.write_text(json.dumps(record), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def planned(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The plan of one seam; nothing is left of what it was made from but the copies beside it."""
    folder = tmp_path_factory.mktemp("kept")
    result = shutil.copytree(TEE, folder / "tee")
    cell = write_cell(folder, one_robot_record())
    formats = [word for name in LANGUAGES for word in ("-f", name)]
    done = run_here("plan", cell, result, "--only", "W2", *formats, "-o", folder / "plan")
    assert done.returncode == 0
    assert re.fullmatch("wpcal: .* has no job.json: .*\n", done.stderr)
    shutil.rmtree(result)
    cell.unlink()
    return folder / "plan"


@pytest.fixture(scope="module")
def cornered(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan with corners on the ways between seams."""
    folder = tmp_path_factory.mktemp("cornered")
    run_here("plan", write_cell(folder, one_robot_record()), TEE, "-f", "rapid", "-o", folder / "plan")
    return folder / "plan"


@pytest.mark.deep
def test_a_ring_is_planned_on_over_its_start_and_written_again(tmp_path: Path) -> None:
    cell, out = write_cell(tmp_path, one_robot_record()), tmp_path / "plan"
    words = ("-f", "krl", "--every-point")
    done = run_here("plan", cell, TEE.parents[1] / "saddle" / "golden", *words, "--overlap-mm", "12", "-o", out)
    assert done.returncode == 0
    motions = execute(programs_of({path.name: path.read_bytes() for path in (out / "krl").iterdir()})).motions
    along = np.array([each.goal[:3, 3] for each in motions if each.goal is not None])[:-1]  # then the retract
    start, end = (np.linalg.norm(along - along[k], axis=1) for k in (0, -1))
    assert (start[len(start) // 2 :].min() < 1.0, end[0]) == (True, pytest.approx(12.0, abs=0.5))
    assert run_here("export", out, *words, "-o", tmp_path / "again").returncode == 0
    assert written(tmp_path / "again").items() <= written(out).items()


@pytest.fixture
def kept(planned: Path, tmp_path: Path) -> Path:
    """A copy of the plan in another place."""
    return shutil.copytree(planned, tmp_path / "elsewhere")


def test_programs_are_written_again_to_the_byte(kept: Path, tmp_path: Path) -> None:
    formats = [word for name in LANGUAGES for word in ("-f", name)]
    done = run_here("export", kept, *formats, "-o", tmp_path / "again")
    assert (done.returncode, done.stderr) == (0, "")
    again = written(tmp_path / "again")
    assert {name.partition("/")[0] for name in again} == set(LANGUAGES)
    assert again.items() <= written(kept).items()


def test_names_are_changed_without_planning(kept: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("wpcal.planning.sequence.plan_sequence.plan_sequence", None)
    names = ("--program-name", "NIGHT", "--tool-name", "tGun")
    assert run_here("export", kept, "-f", "rapid", *names, "-o", tmp_path / "again").returncode == 0
    text = (tmp_path / "again" / "rapid" / "NIGHT.mod").read_text()
    before = (kept / "rapid" / "WPCAL.mod").read_text()
    assert text == before.replace("WPCAL", "NIGHT").replace("tTorch", "tGun")


def test_the_tool_is_set_where_it_is_asked_for(kept: Path, tmp_path: Path) -> None:
    """The judge executes the programs with the tool that they set."""
    formats = ("rapid", "krl", "fanuc", "urscript", "as")
    words = [word for name in formats for word in ("-f", name)]
    done = run_here("export", kept, *words, "--set-tool", "-o", tmp_path / "set")
    assert done.stdout.count(f" in {tmp_path}") >= 4  # the arm has no coupling as FANUC needs it
    record = json.loads((kept / "input" / "cell.json").read_text())["torch_robot"]["T_flange_tool"]
    x = record["xyz_mm"][0] if isinstance(record, dict) else record[0][3]
    for name, before in (("rapid", "tTorch.tframe:=[["), ("krl", "TOOL_DATA[1]={X "), ("as", "tTorch ")):
        text = "".join(path.read_text() for path in (tmp_path / "set" / name).iterdir())
        assert f"{before}{x:g}." in text or f"{before}{x:.3f}" in text, name
        assert "SETS THE TOOL DATA" in text
    done = run_here("export", kept, "-f", "inform", "--set-tool", "-o", tmp_path / "no")
    assert (done.returncode, "programs do not set the tool data" in done.stderr) == (2, True)


def corners_of(folder: Path, sweep: CellSweep) -> list[FloatArray]:
    """Return the states before, at and after every rounded corner of a program; its routines one after the other."""
    files = {path.name: path.read_bytes() for path in folder.iterdir()}
    motions = list(execute(programs_of(files)).motions)
    rows = zip(motions, motions[1:], motions[2:], strict=False)
    joints = [(a.joints, b.joints, c.joints, b.place.zone) for a, b, c in rows if b.place.blends and b.kind == "J"]
    return [sweep.corner(np.radians(np.array(q)), *zone) for *q, zone in joints if not any(one is None for one in q)]


def sweep_of(folder: Path) -> CellSweep:
    kept = read_kept_plan(folder)
    plan = kept_plan_of(kept.record, kept.cell, {each.name: each for each in kept.given.seams})
    return CellSweep.of(plan.cell, kept.given.part, plan.air, [piece.q for piece in plan.pieces])


@pytest.mark.deep
def test_corners_in_the_air_are_rounded_alike_in_every_language(cornered: Path, tmp_path: Path) -> None:
    """All texts keep within the swept corner, those without bounded zones stop, and a zone that is not free is cut."""
    formats = ("rapid", "krl", "urscript", "val3", "as", "inform")
    words = [word for name in formats for word in ("-f", name)]
    done = run_here("export", cornered, *words, "--zone-mm", "80", "-o", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    sweep, out = sweep_of(cornered), {name: tmp_path / name for name in formats}
    script = corners_of(out["urscript"], sweep)
    assert len(script) > 1
    rapid, krl = (corners_of(out[name], sweep) for name in ("rapid", "krl"))
    for a, b in zip(script, corners_of(out["val3"], sweep), strict=True):
        np.testing.assert_allclose(a, b, rtol=0.0, atol=SAME_RAD)
    for a, b in zip(script, rapid, strict=False):  # it goes on with the routines of single seams
        np.testing.assert_allclose(a, b, rtol=0.0, atol=SAME_RAD)
    assert krl
    for q in krl:
        same = min(rapid, key=lambda one: np.abs(one[1:] - q[1:]).max())
        np.testing.assert_allclose(same[1:], q[1:], rtol=0.0, atol=SAME_RAD)
        assert np.abs(q[0] - q[1]).max() <= np.abs(same[0] - q[1]).max() + SAME_RAD
    for name in ("as", "inform"):
        assert corners_of(out[name], sweep) == []
        assert "stops at every corner" in " ".join(path.read_text() for path in out[name].iterdir())


def test_the_judge_refuses_a_zone_that_touches(cornered: Path, tmp_path: Path) -> None:
    """The export judges its own text with the same sweep, and finds nothing."""
    done = run_here("export", cornered, "-f", "rapid", "--zone-mm", "80", "-o", tmp_path)
    assert (done.returncode, done.stderr) == (0, "")
    text = (tmp_path / "rapid" / "WPCAL.mod").read_text()
    wider = re.sub(r"(zonedata wpZ\w+:=\[FALSE,\d+)[\d.]*", r"\g<1>00", text)
    met = sweep_of(cornered).meetings(execute({"WPCAL.mod": wider}).motions)
    assert {each.what for each in met} == {"the zone at its end is not free"}


@pytest.mark.parametrize(
    ("name", "line"), [("urscript", "movej({{ point }}, {{ speed }}, r=0.05)"), ("krl", "PTP {{ point }} C_PTP")]
)
def test_a_zone_of_a_template_is_told(name: str, line: str, kept: Path, tmp_path: Path) -> None:
    own = tmp_path / "shop" / name
    own.mkdir(parents=True)
    (own / "joint_move.txt").write_text(f"  {line}\n")
    done = run_here("export", kept, "-f", name, "--template", tmp_path / "shop", "-o", tmp_path / "out")
    assert (done.returncode, "NOT CHECKED" in done.stderr) == (1, True)


def test_the_arc_is_switched_on_later(kept: Path, tmp_path: Path) -> None:
    words = ("--arc", "on", "--welds", welds_file(tmp_path))
    done = run_here("export", kept, "-f", "rapid", *words, "-o", tmp_path / "again")
    assert (done.returncode, done.stderr) == (0, "")
    assert "the programs switch the arc" in done.stdout
    text = (tmp_path / "again" / "rapid" / "WPCAL.mod").read_text()
    assert "ArcLStart" in text
    assert "ArcL" not in (kept / "rapid" / "WPCAL.mod").read_text()


def test_a_plan_with_lines_that_nobody_follows_is_not_called_checked(kept: Path, tmp_path: Path) -> None:
    own = tmp_path / "shop" / "rapid"
    own.mkdir(parents=True)
    (own / "before_weld.txt").write_text("    CleanTorch;\n", encoding="utf-8")
    words = ("--template", own.parent, "-o", tmp_path / "again", "--json")
    done = run_here("export", kept, "-f", "rapid", *words)
    assert (done.returncode, json.loads(done.stdout)["checked"]) == (1, [])
    assert re.search(r"NOT CHECKED: rapid: WPCAL.mod, line \d+: 'CleanTorch;'", done.stderr)
    assert "checked against" not in (tmp_path / "again" / "rapid" / "WPCAL.mod").read_text()


def test_weld_data_with_other_runs_need_another_plan(kept: Path, tmp_path: Path) -> None:
    welds = welds_file(tmp_path, stitch={"length_mm": 40, "pitch_mm": 110, "offset_mm": 0})
    done = run_here("export", kept, "-f", "rapid", "--welds", welds, "-o", tmp_path / "again")
    assert (done.returncode, done.stdout) == (2, "")
    assert "the weld data cut the seams into other runs than the plan has: plan again" in done.stderr
    assert not (tmp_path / "again").exists()


def _state(kept: Path) -> None:
    record = json.loads((kept / "plan.json").read_text())
    record["kept"]["pieces"][0]["states"][1][2] += 0.01
    (kept / "plan.json").write_text(json.dumps(record, indent=1) + "\n")


def _seams(kept: Path) -> None:
    path = kept / "input" / "seams.json"
    path.write_bytes(path.read_bytes().replace(b"5", b"6", 1))


def _earlier(kept: Path) -> None:
    record = json.loads((kept / "plan.json").read_text())
    for name in ("kept", "digest", "made_from", "planned", "runs"):
        del record[name]
    (kept / "plan.json").write_text(json.dumps(record))


CHANGES = (
    (_state, "plan.json: was changed after wpcal plan wrote it (digest); plan again"),
    (_seams, "seams.json: is not what plan.json was made from (SHA-256); plan again"),
    (lambda kept: (kept / "input" / "cell.json").unlink(), "cell.json: is missing; the plan was made from it"),
    (
        lambda kept: (kept / "input" / "welds.json").write_text("{}"),
        "welds.json: plan.json was not made from it: take it out, or plan again",
    ),
    (_earlier, "plan.json: an earlier version of wpcal made this plan, without its states: plan again"),
    (lambda kept: (kept / "plan.json").write_text('{"schema": "wpcal/plan/1"}'), "not a plan of one robot"),
)


@pytest.mark.parametrize(("change", "message"), CHANGES)
def test_a_changed_plan_is_refused(kept: Path, tmp_path: Path, change: Callable[[Path], None], message: str) -> None:
    change(kept)
    done = run_here("export", kept, "-f", "rapid", "-o", tmp_path / "again")
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert message in done.stderr
    assert not (tmp_path / "again").exists()
    has_digest = "digest" in (kept / "plan.json").read_text()
    assert (message.removeprefix("plan.json: ") in run_here("audit", kept).stdout) == has_digest


def test_the_audit_sweeps_the_text_of_a_plan_in_its_cell(kept: Path) -> None:
    done = run_here("audit", kept)
    assert (done.returncode, "executed: every move of YASKAWA MOTOMAN MH6 in its cell" in done.stdout) == (0, True)
    path = kept / "rapid" / "WPCAL.mod"
    text, count = re.subn(r"    MoveL W2_retr,[^\n]*\n", "", path.read_bytes().decode())
    assert count == 1
    path.write_bytes(text.encode())
    done = run_here("audit", kept / "rapid")
    assert done.returncode == 1
    assert "robot wire and part miss their safety distance" in done.stdout
    assert done.stdout.count("  line ") == 2  # after the weld in the program, and in the routine of the seam


@pytest.mark.deep
def test_the_audit_sweeps_a_plan_whose_positioner_moves(tmp_path: Path) -> None:
    """The last joint move to the seam tilts the part into the torch: one number of the text."""
    record = with_positioner(TEE_ON_TABLE)
    out = tmp_path / "plan"
    done = run_here("plan", write_cell(tmp_path, record), TEE, "--only", "W2", "-f", "rapid", "-f", "krl", "-o", out)
    assert done.returncode == 0, done.stderr
    done = run_here("audit", out)
    assert (done.returncode, "in its cell, wire and torch included" in done.stdout) == (0, True), done.stdout
    for file, axis in (
        ("rapid/WPCAL.mod", r"(wpJ0002:=\[.*\],\[)[-\d.]+"),
        ("krl/WPCAL.dat", r"(WPJ0002=\{.*E1 )[-\d.]+"),
    ):
        path = out / file
        text, count = re.subn(axis, r"\g<1>-60.0", path.read_bytes().decode())
        assert count == 1
        path.write_bytes(text.encode())
        done = run_here("audit", path.parent)
        assert (done.returncode, "part miss their safety distance" in done.stdout) == (1, True), done.stdout


@pytest.mark.parametrize(
    "words", [("--only", "W3"), ("--speed-mm-s", "5"), ("--tacks", "off"), ("--robot", "mh6"), ("--overlap-mm", "5")]
)
def test_what_a_plan_settles_is_refused(kept: Path, words: tuple[str, ...]) -> None:
    done = run_here("export", kept, "-f", "rapid", *words)
    assert (done.returncode, done.stdout) == (2, "")
    assert f"{words[0]} is settled in a plan; give it to wpcal plan, or to its cell (wpcal cell new)" in done.stderr


def test_what_a_language_needs_is_asked_before_anything_is_planned(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("wpcal.planning.sequence.plan_sequence.plan_sequence", None)
    cell = write_cell(tmp_path, one_robot_record())
    record = {name: value for name, value in VALUES.items() if name != "job"}
    path = tmp_path / "welds.json"
    path.write_text(json.dumps({"schema": "wpcal/welds/1", "welds": [{"name": "W2", "values": record}]}))
    words = ("--only", "W2", "--arc", "on", "--welds", path)
    done = run_here("plan", cell, TEE, *words, "-f", "fanuc", "-o", tmp_path / "plan")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.splitlines()[0].startswith("wpcal: no fanuc program: ")
    assert not (tmp_path / "plan").exists()
