"""`wpcal drift`: planted causes are found and named, nothing is found without a change, and bad folders are one line.

The answer stands in each case before the jobs are simulated.
"""

import json
import re
import shutil
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.drift_jobs import Planted, simulated_jobs, write_batch
from tests.record_checks import check_record
from tests.running import run_here
from wpcal.pages.drift import build_drift_page
from wpcal.study.drift import read_drift_jobs, watch_part
from wpcal.study.drift.causes import Cause
from wpcal.study.drift.control import control_charts
from wpcal.study.drift.record import RULES, drift_record

TRIALS = 60
NEAR = 2  #: Jobs by which a shift may be dated wrongly.
MOST_PAGE_MB = 2.0


@pytest.mark.parametrize(
    ("planted", "points", "cause", "named"),
    [
        (Planted("fixture", 35, 1.5), 4, Cause.FIXTURE, ()),
        (Planted("fixture", 35, 20.0), 8, Cause.FIXTURE, ()),
        (Planted("P2", 35, 0.8), 5, Cause.TOUCH, (2,)),
        (Planted("P2", 20, 0.6), 8, Cause.TOUCH, (2,)),
        (Planted("robot", 35, 0.8), 8, Cause.ROBOT, ()),
        (Planted("robot", 25, -1.0), 5, Cause.ROBOT, ()),
    ],
    ids=lambda value: str(getattr(value, "what", value)),
)
def test_a_planted_cause_is_dated_and_named(
    planted: Planted, points: int, cause: Cause, named: tuple[int, ...]
) -> None:
    """In at least 9 of 10 series exactly this one shift, with this cause and this point."""
    right = 0
    for seed in range(20):
        shifts = watch_part(simulated_jobs(60, seed=seed, points=points, planted=(planted,))).shifts
        if len(shifts) == 1 and abs(shifts[0].at - planted.at) <= NEAR:
            right += shifts[0].likely.cause is cause and shifts[0].likely.points == named
    assert right >= 18


def test_three_causes_one_after_the_other(golden: Any) -> None:
    planted = (Planted("P1", 40, 0.8), Planted("fixture", 90, 1.5), Planted("robot", 150, 0.8))
    part = watch_part(simulated_jobs(200, seed=4, planted=planted))
    assert [shift.likely.cause for shift in part.shifts] == [Cause.TOUCH, Cause.FIXTURE, Cause.ROBOT]
    assert [shift.at for shift in part.shifts] == pytest.approx([40, 90, 150], abs=NEAR)
    assert part.most_wrong == 1
    assert part.shifts[0].likely.amount == pytest.approx(0.8, abs=0.1)
    assert part.shifts[2].likely.amount == pytest.approx(0.0008, abs=0.0001)
    golden(part)


@pytest.mark.parametrize("n", [8, 30, 200])
def test_without_a_change_alarms_are_as_rare_as_the_rules_say(n: int) -> None:
    """1 % of 60 parts is less than one: 4 would happen by chance once in 300 runs of another seed."""
    parts = [watch_part(simulated_jobs(n, seed=1000 + seed)) for seed in range(TRIALS)]
    assert sum(bool(part.shifts) for part in parts) <= 3
    outside = np.mean([part.pose.outside.mean() for part in parts])
    stated = {8: 0.015, 30: 0.007, 200: 0.004}[n]
    assert f"{stated * 100:g} %" in RULES[0]["false_alarm"]
    assert stated / 2 <= outside <= stated * 1.6
    if n == 200:
        assert 1 / 300 <= np.mean([part.pose.alarms.mean() for part in parts]) <= 1 / 130


@pytest.mark.deep
@pytest.mark.parametrize("n", [8, 30, 60])
def test_one_part_in_a_hundred_without_a_change_has_a_shift(n: int) -> None:
    """Of 1000; 20 would happen once in 300 runs of another seed if the rate were 1.25 %."""
    assert sum(bool(watch_part(simulated_jobs(n, seed=50000 + seed)).shifts) for seed in range(1000)) < 20


def test_cusum_with_a_known_centre_and_sigma_alarms_once_in_465_jobs() -> None:
    """About 430 alarms are expected, give or take 21."""
    charts = control_charts(np.random.default_rng(1).normal(size=(20_000, 10)), first=20_000)
    assert 1 / charts.alarms.mean() == pytest.approx(465, rel=0.15)
    assert f"one in {465} jobs" in RULES[1]["false_alarm"]


def test_cusum_sees_what_single_jobs_do_not(golden: Any) -> None:
    values = np.random.default_rng(2).normal(size=(200, 1))
    values[100:] += 1.0
    charts = control_charts(values)
    assert not charts.alarms[:100].any()
    assert charts.alarms[100:130].any()
    golden(charts)


def test_numbers_of_the_pose_do_not_wrap() -> None:
    """A part near 180 degrees has turns that scatter by hundredths of a degree."""
    jobs = simulated_jobs(20, seed=1)
    half_turn = np.diag([-1.0, -1.0, 1.0, 1.0])
    part = watch_part(replace(jobs, T_base_part=half_turn @ jobs.T_base_part, residuals=-jobs.residuals))
    assert np.abs(part.pose.values[:, 3:]).max() < 1.0


def test_equal_jobs_have_no_alarm_and_a_step_between_equal_jobs_is_a_shift() -> None:
    one = simulated_jobs(20, seed=1)
    equal = replace(one, T_base_part=one.T_base_part[np.zeros(20, int)], residuals=one.residuals[np.zeros(20, int)])
    part = watch_part(equal)
    assert not part.shifts
    assert not part.pose.outside.any()
    moved = equal.T_base_part.copy()
    moved[12:, 2, 3] += 0.5
    (shift,) = watch_part(replace(equal, T_base_part=moved)).shifts
    assert (shift.at, shift.likely.cause) == (12, Cause.FIXTURE)


def test_a_touch_on_a_face_is_seen_in_one_direction(golden: Any) -> None:
    """Touches along one normal each: planted 1 mm at one of nine, 3-2-1 and three more; the answer is that point."""
    rng, n = np.random.default_rng(7), 60
    places = rng.uniform(-200, 200, (9, 3))
    normals = np.repeat(np.eye(3), 3, axis=0)
    seen = rng.normal(0, 0.1, (n, 9))
    seen[30:, 4] += 1.0
    motion = np.hstack([np.cross(places, normals), normals])
    left = seen @ (np.eye(9) - motion @ np.linalg.pinv(motion))
    jobs = replace(
        simulated_jobs(n, seed=1, points=9),
        places=places,
        residuals=left[:, :, None] * normals,
        T_base_part=np.tile(np.eye(4), (n, 1, 1)),
    )
    (shift,) = watch_part(jobs).shifts
    assert abs(shift.at - 30) <= NEAR
    assert 4 in shift.likely.points
    golden(watch_part(jobs))


def test_page_and_record_over_5000_jobs() -> None:
    planted = (Planted("fixture", 1200, 1.5), Planted("P3", 3100, 0.8))
    jobs = replace(simulated_jobs(5000, seed=5, planted=planted), file="</script><b>x.step")
    part = watch_part(jobs)
    record = drift_record([part], [], [])
    check_record(record)
    assert [shift["cause"] for shift in record["parts"][0]["shifts"]] == ["fixture or base", "touch"]
    page = build_drift_page([part], [], [])
    assert len(page.encode()) < MOST_PAGE_MB * 1e6
    assert "<b>x" not in page
    assert "<script" not in page


@pytest.mark.parametrize("jobs", [10, 420])
def test_a_page_over_5000_jobs_on_many_parts_is_small_too(jobs: int) -> None:
    """Parts with a shift have charts; of the others the page says how to see them."""
    still, moved = (
        watch_part(simulated_jobs(jobs, seed=1, points=20, planted=planted))
        for planted in ((), (Planted("fixture", jobs // 2, 20.0),))
    )
    parts = [replace(still, jobs=replace(still.jobs, file=f"p{k}.step")) for k in range(5000 // jobs - 1)]
    page = build_drift_page([*parts, replace(moved, jobs=replace(moved.jobs, file="moved.step"))], [], [])
    assert len(page.encode()) < MOST_PAGE_MB * 1e6
    assert "--on-part moved.step" not in page
    assert ("--on-part p400.step" in page) == (jobs == 10)


def test_several_folders_of_mixed_parts_are_sections_in_the_order_of_time(tmp_path: Path) -> None:
    late, early = simulated_jobs(30, seed=1), simulated_jobs(12, seed=2)
    write_batch(tmp_path / "b", replace(late, when=tuple(f"2026-04-{1 + row:02}" for row in range(30))), failed=2)
    write_batch(tmp_path / "a", replace(early, when=tuple(f"2026-03-{1 + row:02}" for row in range(12))))
    write_batch(tmp_path / "c", replace(early, file="other.step", sha256="cd" * 32))
    write_batch(tmp_path / "d", replace(simulated_jobs(7, seed=3), file="rare.step", sha256="ef" * 32))
    summary = tmp_path / "b" / "summary.jsonl"
    summary.write_text(summary.read_text().replace('"j0029"', '"../j0029"'))  # a failed job may have any name
    folders = [tmp_path / name for name in "bacd"]
    done = run_here("drift", *folders, "-o", tmp_path / "drift.html", "--json")
    assert done.returncode == 0, done.stderr
    record = json.loads(done.stdout)
    check_record(record)
    assert record == json.loads((tmp_path / "drift.json").read_text())
    assert [(part["part"]["file"], part["jobs"]) for part in record["parts"]] == [("other.step", 12), ("part.step", 40)]
    assert record["parts"][1]["order"] == "when"
    assert record["parts"][1]["first_job"] == "j0000"
    assert record["parts"][1]["last_job"] == "j0027"
    assert len(record["failed"]) == 2
    assert len(record["left_out"]) == 1
    assert "rare.step: 7 jobs" in record["left_out"][0]
    kept = ("--cell-errors", tmp_path / "cell.json")
    only = run_here("drift", *folders, "-o", tmp_path / "one.html", "--json", "--on-part", "other.step", *kept)
    assert f"--robot-mm {tmp_path / 'cell.json'}" in only.stderr
    check_record(json.loads((tmp_path / "cell.json").read_text()))
    assert len(json.loads(only.stdout)["parts"]) == 1


def test_jobs_that_are_gone_or_on_other_points_are_left_out_and_told(tmp_path: Path) -> None:
    """Of 30 jobs one folder was deleted, two are on other points, and one has a point more; 27 are on the page."""
    write_batch(tmp_path / "out", simulated_jobs(30, seed=1))
    shutil.rmtree(tmp_path / "out" / "j0005")
    for job in ("j0007", "j0009", "j0011"):
        path = tmp_path / "out" / job / "calibration.json"
        record = json.loads(path.read_text())
        if job == "j0011":
            record["points"].append({**record["points"][0], "name": "more"})
        else:
            record["points"] = [{**point, "name": f"Q{row}"} for row, point in enumerate(record["points"])]
        path.write_text(json.dumps(record))
    done = run_here("drift", tmp_path / "out", "-o", tmp_path / "drift.html", "--json")
    record = json.loads(done.stdout)
    check_record(record)
    (part,) = record["parts"]
    assert (part["jobs"], len(part["points"])) == (27, 8)
    assert record["left_out"] == ["part.step: jobs without the points of most jobs: j0007, j0009"]
    assert [(each["job"], each["error"]) for each in record["failed"]] == [
        ("j0005", "its calibration.json is not there any more")
    ]
    assert "j0009" in (tmp_path / "drift.html").read_text()


@pytest.mark.parametrize(
    ("times", "order"),
    [
        (("2026-10-25T03:30+01:00", "2026-10-25T02:30+02:00", "2026-10-25T02:45+02:00"), (1, 2, 0)),
        (("2026-10-25T03:30+01:00", "2026-10-25T02:30", "2026-10-25T02:45+02:00"), (0, 1, 2)),
        (("06:30", "06:10", "06:20"), (0, 1, 2)),
        (("2026-03-09", "2026-03-08", "2026-03-09"), (1, 0, 2)),
    ],
    ids=["clock set back", "some with a zone", "no dates", "equal times in the order of the list"],
)
def test_jobs_are_in_the_order_of_their_times(tmp_path: Path, times: tuple[str, ...], order: tuple[int, ...]) -> None:
    jobs = simulated_jobs(3, seed=1)
    write_batch(tmp_path / "out", replace(jobs, when=times))
    ((part,), _) = read_drift_jobs([tmp_path / "out"])
    assert part.names == tuple(f"j{row:04}" for row in order)
    assert part.by_time == (order != (0, 1, 2))


def test_what_cannot_be_read_is_one_line(tmp_path: Path) -> None:
    write_batch(tmp_path / "few", simulated_jobs(7, seed=1))
    write_batch(tmp_path / "failed", simulated_jobs(9, seed=1), failed=9)
    for name in ("cut", "odd", "gone", "line", "away", "none"):
        write_batch(tmp_path / name, simulated_jobs(9, seed=1))
    calibration = "j0003/calibration.json"
    cut = (tmp_path / "cut" / calibration).read_text()
    (tmp_path / "cut" / calibration).write_text(cut[:200])
    (tmp_path / "odd" / calibration).write_text(cut.replace('"T_base_part": [[', '"T_base_part": [["x", '))
    for job in ("j0003", "j0004"):
        (tmp_path / "gone" / job / "calibration.json").unlink()
    (tmp_path / "line" / "summary.jsonl").write_text("[1]\n")
    summary = (tmp_path / "away" / "summary.jsonl").read_text()
    (tmp_path / "away" / "summary.jsonl").write_text(summary.replace('"j0003"', '"../few/j0003"'))
    (tmp_path / "none" / "summary.jsonl").write_text("")
    (tmp_path / "empty").mkdir()
    cases = {
        "few": "7 jobs with a calibration; drift needs at least 8",
        "failed": "no job has a calibration; 9 failed",
        "cut": "is not JSON",
        "odd": "T_base_part",
        "gone": "7 jobs with a calibration; drift needs at least 8",
        "line": "line 1: is not a line of wpcal batch",
        "away": "job: expected the name of a folder",
        "none": "no job has a calibration",
        "empty": "is not a folder of wpcal batch",
        "absent": "no such folder; expected the results of wpcal batch",
    }
    for name, expected in cases.items():
        done = run_here("drift", tmp_path / name, "-o", tmp_path / "page.html")
        assert done.returncode == 2, name
        assert expected in done.stderr, (name, done.stderr)
        assert len(done.stderr.splitlines()) == 1
        assert not re.search("internal|Traceback", done.stderr)
        assert not (tmp_path / "page.html").exists()
        assert not (tmp_path / "page.json").exists()
    wrong = run_here("drift", tmp_path / "few", "-o", tmp_path / "page.json")
    assert "expected the name of a page" in wrong.stderr
