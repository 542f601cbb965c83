"""Programs that come back from the pendant: what was changed is understood, and nothing else is touched."""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.drift_jobs import simulated_jobs, write_batch
from tests.running import run_here
from tests.touch_ups.shop import Truth, load
from tests.touch_ups.study import Seen, Wanted, calibrated, play, program
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.calibrate.errors.field_shift import FieldShift
from wpcal.controllers.touchup.record import sentences
from wpcal.controllers.touchup.study import TouchUp, TouchUpOptions
from wpcal.controllers.touchup.swept import moved_part

GOLDEN = Path(__file__).parents[3] / "fixtures" / "tee" / "golden"
FRAME = Path(__file__).parents[3] / "fixtures" / "frame" / "golden"
LANGUAGES = {
    "rapid": [],
    "krl": [],
    "fanuc": ["--config", "N U T, 0, 0, 0"],
    "inform": ["--config", "1,0,0,0,0,0,0,0"],
    "as": [],
    "urscript": [],
    "val3": [],
}
START, END = (25.0, 56.0, 10.0), (175.0, 56.0, 10.0)  #: Of the seam W2, in the part.
OTHER = (25.0, 64.0, 10.0)  #: Start of W3.
NUMBER = re.compile(r"(?<![\w.])-?\d+\.\d+")


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("written")
    for language, options in LANGUAGES.items():
        done = run_here("export", GOLDEN, "-f", language, "-o", folder, "--force", "--only", "W2,W3", *options)
        assert done.returncode == 0, done.stderr
    return folder


def places(text: str, at: tuple[float, float, float], unit: float) -> list[re.Match[str]]:
    """Find x, y, z one after another in a text: the numbers of the first place where they stand."""
    numbers = list(NUMBER.finditer(text))
    for row in range(len(numbers) - 2):
        three = numbers[row : row + 3]
        if all(abs(float(n[0]) - unit * v) <= 2e-3 * unit for n, v in zip(three, at, strict=True)):
            return three
    raise AssertionError(f"{at} is not in the text")


def moved(text: str, at: tuple[float, float, float], by: tuple[float, float, float], unit: float) -> str:
    for number, delta in reversed(list(zip(places(text, at, unit), by, strict=True))):
        decimals = len(number[0].partition(".")[2])
        new = f"{float(number[0]) + unit * delta:.{decimals}f}".rjust(len(number[0]))
        text = text[: number.start()] + new + text[number.end() :]
    return text


def changed_copy(
    written: Path, language: str, folder: Path, *moves: tuple[tuple[float, ...], tuple[float, ...]]
) -> Path:
    shutil.copytree(written / language, folder)
    unit = 1e-3 if language == "urscript" else 1.0
    for path in folder.iterdir():
        text = path.read_text(encoding="latin-1")
        for at, by in moves:
            try:
                text = moved(text, at, by, unit)  # type: ignore[arg-type]
            except AssertionError:
                continue
        path.write_text(text, encoding="latin-1")
    return folder


def touched_up(program: Path, written: Path, *words: object) -> dict[str, object]:
    done = run_here("touchup", program, "--of", GOLDEN, "--written", written, "--json", *words)
    assert done.returncode in (0, 1), done.stderr
    return json.loads(done.stdout)  # type: ignore[no-any-return]


@pytest.mark.parametrize("language", LANGUAGES)
def test_corrections_are_read_and_only_poses_are_written(written: Path, language: str, tmp_path: Path) -> None:
    by = (0.0, -0.4, 0.3)
    back = changed_copy(written, language, tmp_path / "back", (START, by), (END, by))
    record = touched_up(back, written / language, "-o", tmp_path / "new", "--html", tmp_path / "page.html")
    points = record["points"]
    assert [point["seam"] for point in points] == ["W2", "W2"]
    assert [point["across_mm"] for point in points] == pytest.approx([0.5, 0.5], abs=0.01)
    assert all(point["is_end"] and not point["is_exception"] for point in points)
    assert {seam["seam"]: seam["corrected"] for seam in record["seams"]} == {"W1": 0, "W2": 2, "W3": 0, "W4": 0}
    kept = [line["place"] for line in record["lines"] if line["what"] == "by hand: kept"]
    assert kept == [point["place"] for point in points]
    assert all(place in (tmp_path / "page.html").read_text() for place in kept)
    unit = 1e-3 if language == "urscript" else 1.0
    for path in back.iterdir():
        old, new = (folder.read_bytes().splitlines(keepends=True) for folder in (path, tmp_path / "new" / path.name))
        assert len(old) == len(new)
        for a, b in zip(old, new, strict=True):
            if a != b:  # only numbers
                strip = (NUMBER.sub("", line.decode("latin-1")).replace(" ", "") for line in (a, b))
                assert len(set(strip)) == 1
    assert record["not_free"] == []
    texts = "\n".join(path.read_text(encoding="latin-1") for path in sorted((tmp_path / "new").iterdir()))
    for hand in (START, END):
        places(texts, tuple(a + b for a, b in zip(hand, by, strict=True)), unit)  # type: ignore[arg-type]
    with pytest.raises(AssertionError):
        places(texts, OTHER, unit)  # the other seam went along


def test_a_seam_that_is_set_aside_can_be_taken_back_on_the_page(written: Path, tmp_path: Path) -> None:
    back = changed_copy(written, "rapid", tmp_path / "back", (START, (0.0, -0.4, 0.3)), (OTHER, (0.0, -0.4, 0.3)))
    page = tmp_path / "page.html"
    for aside in ((), ("W2",), ("W2", "W3")):
        touched_up(
            back, written / "rapid", "--html", page, "--force", *(w for name in aside for w in ("--set-aside", name))
        )
        text = page.read_text(encoding="utf-8")
        boxes = dict(re.findall(r'<input type=checkbox value="(\w+)"( checked)?>', text))
        assert boxes == {name: "" if name in aside else " checked" for name in ("W2", "W3")}
        (command,) = re.findall(r"<code id=command>([^<]*)</code>", text)
        assert command.endswith(" -o NEW")
        assert "--set-aside" not in command  # the script writes what the boxes say


@pytest.mark.parametrize("language", LANGUAGES)
def test_a_program_that_meets_the_part_is_not_called_checked(written: Path, language: str, tmp_path: Path) -> None:
    back = changed_copy(written, language, tmp_path / "back", (START, (0.0, 15.0, -5.0)))  # through the web
    done = run_here("touchup", back, "--of", GOLDEN, "--written", written / language, "--json", "-o", tmp_path / "new")
    assert done.returncode == 1
    faults = json.loads(done.stdout)["not_free"]
    assert any("inside 'web'" in each and ", line " in each for each in faults), faults
    texts = b"".join(path.read_bytes() for path in (tmp_path / "new").iterdir())
    assert b"checked against the part" not in texts
    assert b"NOT CHECKED: touched up" in texts


def test_the_part_is_swept_where_the_corrections_have_it(golden: Any) -> None:
    seen = Seen()
    found = play(FRAME, Wanted(seams=6, moved=1), 5003, seen)
    assert seen.bodies == [True]
    (name,) = found.bodies
    mesh = read_part_glb(found.part.finished.part_glb or b"")
    material, place = moved_part(found), found.part.finished.T_base_part
    by = {
        solid.name: np.linalg.norm(
            material.corners[material.solid == row].reshape(-1, 3) - place.apply(solid.points)[solid.triangles.ravel()],
            axis=1,
        ).max()
        for row, solid in enumerate(mesh.solids)
    }
    assert by.pop(name) > 1.0 > max(by.values())
    golden([found, sentences(found), found.seams, found.offsets, found.explanation.node])


def test_an_arc_instruction_leads_to_the_start_and_an_output_burns_from_the_pose_before() -> None:
    from wpcal.controllers.touchup.poses import read_program

    examples = Path(__file__).parents[3] / "docs" / "examples" / "programs"
    found = [pose for pose in read_program(examples / "abb-2").poses if pose.seam]
    assert [pose.text.split(",")[0] for pose in found] == ["ArcLStart W2_0001", "ArcLEnd W2_0002"]


def test_what_else_a_person_does_on_the_pendant_is_understood(written: Path, tmp_path: Path) -> None:
    path = changed_copy(written, "rapid", tmp_path / "back") / "WPCAL.mod"
    text = path.read_text()
    text = text.replace("    weld_W2;\n    weld_W3;\n", "    weld_W3;\n    weld_W2;\n")
    text = text.replace("W2_0002", "pEnd")
    text = text.replace("    MoveL W3_up02,vAir,fine,tTorch\\WObj:=wpPart;\n", "")
    middle = text[text.index("  LOCAL CONST robtarget W3_0001") :].partition("\n")[0]
    middle = middle.replace("W3_0001", "p10").replace("[25.00000,64.00000,10.00000]", "[100.00000,64.30000,10.00000]")
    text = text.replace("  LOCAL CONST robtarget W3_0001", f"{middle}\n  LOCAL CONST robtarget W3_0001")
    text = text.replace(
        "    MoveL W3_0002,vWeld", "    MoveL p10,vWeld,fine,tTorch\\WObj:=wpPart;\n    MoveL W3_0002,vWeld"
    )
    assert "W2_retr:=[[175.00000,20." in text
    path = path.rename(path.with_name("copy.mod"))
    text = text.replace("tTorch", "TTORCH")
    path.write_text(text.replace("W2_retr:=[[175.00000,20.", "W2_retr:=[[175.00000,-20."))  # 40 mm, by its name
    record = touched_up(path, written / "rapid")
    (added,) = record["points"]  # type: ignore[misc]
    assert (added["seam"], added["is_added"], added["is_end"]) == ("W3", True, False)
    assert added["across_mm"] == pytest.approx(0.3, abs=1e-3)
    assert len(record["deleted"]) == 1  # type: ignore[arg-type]
    assert not any("the tool was" in said for said in record["sentences"])  # type: ignore[attr-defined]
    assert record["common"] is None


def test_a_frame_that_was_taught_again_is_no_correction(written: Path, tmp_path: Path) -> None:
    path = changed_copy(written, "rapid", tmp_path / "back") / "WPCAL.mod"
    path.write_text(path.read_text().replace('"",[[812.', '"",[[815.'))
    record = touched_up(path, written / "rapid")
    assert record["points"] == []
    assert record["common"]["what"] == "frame"  # type: ignore[index, call-overload]
    assert np.array(record["common"]["T"])[:3, 3] == pytest.approx([3.0, 0.0, 0.0], abs=1e-3)  # type: ignore[index, call-overload]


def test_a_program_of_another_part_is_refused(written: Path, tmp_path: Path) -> None:
    back = changed_copy(written, "rapid", tmp_path / "back", (START, (0.0, 1.0, 0.0)))
    done = run_here("touchup", back, "--of", FRAME, "--written", written / "rapid", "-o", tmp_path / "new")
    assert (done.returncode, done.stderr.count("\n"), (tmp_path / "new").exists()) == (2, 1, False)
    path = back / "WPCAL.mod"
    path.write_text(path.read_text().replace("[175.00000", "[9e9"))
    done = run_here("touchup", back, "--of", GOLDEN, "--written", written / "rapid")
    assert (done.returncode, done.stderr.count("\n")) == (2, 1)
    assert "a pose that is no number, or more than 100000 mm away" in done.stderr
    for words in (("--written", written / "rapid"), ()):
        done = run_here("touchup", tmp_path / "none", "--of", GOLDEN, *words)
        assert (done.returncode, done.stderr.count("\n")) == (2, 1)
        assert "no such file or folder" in done.stderr


def test_what_is_corrected_alike_in_most_jobs_of_a_part_is_proposed_by_drift(written: Path, tmp_path: Path) -> None:
    jobs = simulated_jobs(8, seed=1)
    write_batch(tmp_path / "out", jobs)
    back = changed_copy(written, "rapid", tmp_path / "back", (START, (0.0, -0.4, 0.3)), (END, (0.0, -0.4, 0.3)))
    record = {**touched_up(back, written / "rapid"), "bodies": ["web"]}
    for row, name in enumerate(jobs.names):
        own = {
            **record,
            "part": jobs.sha256 if row < 4 else "cd" * 32,
            "bodies": ["web"] if row < 4 else ["base plate"],
        }
        folder = tmp_path / "out" / name / "touched"
        folder.mkdir()
        (folder / "touchup.json").write_text(json.dumps(own))
    done = run_here("drift", tmp_path / "out", "-o", tmp_path / "drift.html", "--json")
    assert done.returncode == 0, done.stderr
    (part,) = json.loads(done.stdout)["parts"]
    assert part["corrected"][0].startswith("web moved on 4 of 4 parts")
    assert not any("base plate" in line for line in part["corrected"])
    assert part["corrected"][0] in (tmp_path / "drift.html").read_text()


def test_a_clamp_is_named_and_an_offset_is_a_preference(golden: Any) -> None:
    seen = Seen()
    found = play(FRAME, Wanted(seams=4, clamp=True), 1, seen)
    assert (seen.clamp, seen.false_clamp) == ([True], 0)
    (clamp,) = found.exceptions
    assert any(f"moved by {np.linalg.norm(clamp.moved):.2f} mm" in said for said in sentences(found))
    found = play(FRAME, Wanted(seams=8, preference=True, rebase=True), 2, seen)
    assert found.common is not None
    assert found.offsets
    of_one_field = [node.log_prior for node in found.explanation.nodes[:3]]  # and three errors of the hand
    assert of_one_field[1] > max(of_one_field[0], of_one_field[2])
    at = found.part.places(np.array([[0, 0], [2, 1], [5, 0]]))
    every = [one for causes, nodes in found.explanation._models for one in found.explanation._given(causes, nodes, at)]
    weights, means, covariances = (np.array(column) for column in zip(*every, strict=True))
    mean, C = found.explanation.seams_at(at)
    off = means - np.einsum("m,mki->ki", weights, means)
    assert weights.sum() == pytest.approx(1.0)
    np.testing.assert_allclose(mean, means[0] - off[0], rtol=0, atol=1e-9)
    spread = covariances + np.einsum("mki,mkj->mkij", off, off)  # of a mixture, with the distance of its means
    np.testing.assert_allclose(C, np.einsum("m,mkij->kij", weights, spread), rtol=0, atol=1e-9)
    golden([found, sentences(found), found.seams, found.offsets, found.explanation.node])


def test_corrections_within_a_frame_that_was_taught_again_move_its_seams_alike() -> None:
    plain, based = (play(FRAME, Wanted(seams=3, rebase=rebase), 4, Seen()) for rebase in (False, True))
    assert plain.common is None
    turn = based.common[0][:3, :3]
    assert np.abs(turn - np.eye(3)).max() > 1e-3
    np.testing.assert_allclose(based.shifts, plain.shifts @ turn.T, rtol=0, atol=1e-6)  # mm: round-off of two programs
    assert np.abs(plain.shifts).max() > 0.01


def test_what_is_corrected_alike_on_every_part_is_proposed_once(written: Path, tmp_path: Path) -> None:
    for part, dy in enumerate((0.55, 0.6, 0.65)):
        back = changed_copy(
            written, "rapid", tmp_path / f"back{part}", (START, (0.0, -dy, 0.0)), (END, (0.0, -dy, 0.0))
        )
        words = () if part < 2 else ("--earlier", tmp_path / "done")
        record = touched_up(back, written / "rapid", "-o", tmp_path / "done" / str(part), *words)
    (said,) = record["proposals"]  # type: ignore[misc]
    assert "corrected by y " in said
    assert "on 3 of 3 parts" in said
    done = run_here(
        "touchup", back, "--of", GOLDEN, "--written", written / "rapid", "--earlier", tmp_path / "back0", "--json"
    )
    assert (done.returncode, "no touchup.json is in it" in done.stderr) == (2, True)


@pytest.mark.deep
def test_the_band_holds_for_corrected_parts() -> None:
    for wanted in (Wanted(), Wanted(seams=4, clamp=True), Wanted(seams=6, moved=1), Wanted(seams=8, preference=True)):
        seen = Seen()
        for seed in range(100, 120):
            play(FRAME, wanted, seed, seen)
        before, after = np.array(seen.untouched).T
        assert np.mean(seen.covered) >= 0.9
        assert after.mean() < before.mean()
        assert seen.false_clamp <= 2
        assert not seen.clamp or np.mean(seen.clamp) >= 0.9


def test_corrections_of_seams_that_followed_the_robot_are_not_applied_twice() -> None:
    """Where the seams of the program already followed the robot's own error, the corrected program ends in one place.

    Once the program is written by the pose alone, once with the seams moved (any smooth shift); a hand leads the same
    points to the same places.
    """
    rng, part = np.random.default_rng(5), load(FRAME)
    truth = Truth.draw(rng, part, field_mm=0.4, length=400.0, moved=0, plate_mm=1.0)
    finished, T = calibrated(FRAME, part, truth, rng, 8)
    old = [[T @ tip for tip in frames[[0, -1]]] for frames in part.frames]
    hand = {(k, 0): part.frames[k][0, :3, 3] + truth.seam(part, k)[0] for k in range(0, len(old), 2)}
    places = np.array([point["p_base_mm"] for point in finished.calibration["points"]])
    about, pulls = places - places.mean(axis=0), 0.3 * rng.normal(size=(1, len(places), 3))
    shift = FieldShift(places.mean(axis=0), about, np.array([400.0]), pulls, np.zeros(6), 5.0)
    seams = tuple(replace(s, frames=replace(s.frames, p=s.frames.p + shift.at(s.frames.p))) for s in finished.seams)
    calibration = {**finished.calibration, "field_shift": shift.to_record()}
    ends = []
    for follows, known in ((False, finished), (True, replace(finished, seams=seams, calibration=calibration))):
        written = [[tip.copy() for tip in seam] for seam in old]
        for tip in (each for seam in written if follows for each in seam):
            tip[:3, 3] += shift.at(tip[None, :3, 3])[0]
        changed = [[tip.copy() for tip in seam] for seam in written]
        for (seam, row), at in hand.items():
            changed[seam][row][:3, 3] = at
        found = TouchUp(known, program(written), program(changed), TouchUpOptions())
        poses = np.array([pose.T[:3, 3] for pose in found.changed.poses])
        ends.append((poses + found.shifts)[[pose.seam > 0 for pose in found.changed.poses]])
    moved = np.linalg.norm(shift.at(ends[0]), axis=1).max()
    assert moved > 0.3
    np.testing.assert_allclose(ends[1], ends[0], rtol=0, atol=0.02)  # measured: 0.004
