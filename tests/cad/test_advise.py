"""Advice on the sample parts: what is easy to touch, what the advised points promise, and the file to fill in."""

import csv
import json
from collections.abc import Callable
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from cad.workpiece.advise import AdviseOptions, advise_points
from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import Workpiece
from tests.few import few
from wpcal.calibrate import Criterion, TeachingError, calibrate
from wpcal.calibrate.errors.budget import ErrorBudget
from wpcal.calibrate.errors.robot_field import RobotField
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.pairs import PointPairs
from wpcal.seam import Seam, SeamOptions, StepOptions
from wpcal.taught.features import Ease, feature_named, judge_features
from wpcal.taught.table import read_taught
from wpcal.touch.advice import advise

FIXTURES = Path(__file__).parents[2] / "fixtures"
ROUND_OFF_MM = 1e-9
SIMULATED_MM = 1e-4
"""The simulated part of the minimax figure starts from coordinates with other round-off in another frame."""


Sample = Callable[[str], tuple[Workpiece, list[Seam]]]


@pytest.fixture(scope="module")
def sample(sample_part: Callable[[str], Workpiece]) -> Sample:
    """Sample parts with their accepted seams."""

    @cache
    def read(name: str) -> tuple[Workpiece, list[Seam]]:
        seams, workpiece = find_seams(sample_part(name), SeamOptions())
        return workpiece, [seam for seam in seams if seam.accepted]

    return read


def names_of(workpiece: Workpiece, ease: Ease) -> set[str]:
    return {item.feature.name for item in judge_features(workpiece.graph, workpiece.features) if item.ease is ease}


def test_corners_against_another_plate_are_hidden(sample: Sample) -> None:
    workpiece, _ = sample("tee")
    web_foot = {f.name for f in workpiece.features if f.solid == "web" and f.name[0] == "V" and f.p_mm[2] < 11}
    assert len(web_foot) == 4
    assert web_foot <= names_of(workpiece, Ease.HIDDEN)
    free = {f.name for f in workpiece.features if f.name[0] in "VH"} - web_foot
    assert free == names_of(workpiece, Ease.SHARP)


def test_mitred_corners_are_free_outside_and_hidden_inside(sample: Sample) -> None:
    workpiece, _ = sample("frame")
    sharp = {tuple(feature_named(workpiece.features, n).p_mm.round(6)) for n in names_of(workpiece, Ease.SHARP)}
    assert sharp == {(x, y, z) for x in (0.0, 600.0) for y in (0.0, 400.0) for z in (0.0, 40.0)}


@pytest.mark.parametrize(
    ("criterion", "atol"), few([(Criterion.LEAST_SQUARES, ROUND_OFF_MM), (Criterion.MINIMAX, SIMULATED_MM)], 1)
)
def test_the_promise_is_what_calibrate_reports(sample: Sample, criterion: Criterion, atol: float, golden: Any) -> None:
    workpiece, seams = sample("tee")
    robot = RobotField(0.2, 500.0)
    advice = advise(judge_features(workpiece.graph, workpiece.features), seams, criterion=criterion, robot=robot)
    p = np.array([feature.p_mm for feature in advice.chosen.features])
    pairs = PointPairs(advice.chosen.names, p, p)
    points = np.concatenate([seam.frames.p for seam in seams])
    teaching = TeachingError(sigma_mm=0.3, robot=robot)
    result = calibrate(pairs, criterion=criterion, teaching=teaching, seam_points=points)
    assert result.judgement.error_95_mm == pytest.approx(advice.chosen.error_95_mm, rel=0, abs=atol)
    golden(advice)


@pytest.mark.deep
def test_no_other_set_of_free_features_is_better_by_least_squares(sample: Sample) -> None:
    workpiece, seams = sample("lap")
    judged = judge_features(workpiece.graph, workpiece.features)
    advice = advise(judged, seams, robot=RobotField.none())
    sharp = [item.feature for item in judged if item.ease is Ease.SHARP]
    best = min(
        advise(judged, seams, points=4, have=three, robot=RobotField.none()).chosen.error_95_mm
        for three in list(combinations(sharp, 3))[::20]
    )
    assert advice.chosen.error_95_mm <= best + ROUND_OFF_MM


def test_further_points_make_the_error_smaller_by_least_squares(sample: Sample, golden: Any) -> None:
    workpiece, seams = sample("lap")
    advice = advise(judge_features(workpiece.graph, workpiece.features), seams, criterion=Criterion.LEAST_SQUARES)
    errors = [found.error_95_mm for found in advice.by_count]
    assert [len(found.features) for found in advice.by_count] == [3, 4, 5, 6]
    assert errors == sorted(errors, reverse=True)
    assert errors[2] <= advice.with_next.error_95_mm < errors[1]
    golden(advice)


def test_the_outer_seam_points_choose_the_same_as_all(sample: Sample, monkeypatch: pytest.MonkeyPatch) -> None:
    seams, workpiece = find_seams(sample("saddle")[0], SeamOptions(steps=StepOptions(max_step_mm=1.0)))
    judged, asked = judge_features(workpiece.graph, workpiece.features), []
    whole, points = ErrorBudget.joint_errors, sum(len(seam.frames) for seam in seams)
    monkeypatch.setattr(ErrorBudget, "joint_errors", lambda own, p: asked.append(len(p)) or whole(own, p))
    monkeypatch.setattr("wpcal.touch.advice.FEW_SEAM_POINTS", 0)
    few, asked_few = advise(judged, seams).to_record(), asked.count(points)
    monkeypatch.setattr("wpcal.touch.advice.FEW_SEAM_POINTS", points)
    assert advise(judged, seams).to_record() == few
    assert asked_few < asked.count(points) - asked_few


def test_what_is_there_already_is_kept() -> None:
    step = FIXTURES / "tee" / "tee.step"
    found = advise_points(step, options=AdviseOptions(have=("v1", "H1")), seam_options=SeamOptions())
    assert {"V1", "H1"} <= set(found.chosen.names)


@pytest.mark.deep
def test_excluded_and_distant_features_are_not_advised(sample: Sample) -> None:
    tee, _ = sample("tee")
    first = advise_points(tee, options=AdviseOptions(), seam_options=SeamOptions()).chosen
    options = AdviseOptions(exclude=first.names[:1], near=(0.0, 60.0, 10.0, 150.0))
    second = advise_points(tee, options=options, seam_options=SeamOptions()).chosen
    assert first.names[0] not in second.names
    assert all(np.linalg.norm(f.p_mm - [0, 60, 10]) <= 150.0 for f in second.features)


@pytest.mark.parametrize(
    ("options", "error", "says"),
    [
        (AdviseOptions(seams=("W99",)), InputError, "unknown seam W99"),
        (AdviseOptions(have=("Q1",)), InputError, "no feature 'Q1'"),
        (AdviseOptions(points=2), InputError, "at least 3"),
        (AdviseOptions(points=3, have=("V1", "V2", "V3")), InputError, "3 points are there already"),
        (AdviseOptions(sigma_mm=0.0), InputError, "a length of at least"),
        (AdviseOptions(near=(0.0, 0.0, 0.0, 1.0)), GeometryError, "the part has 1 places"),
    ],
)
def test_what_cannot_be_advised(sample: Sample, options: AdviseOptions, error: type[Exception], says: str) -> None:
    with pytest.raises(error, match=says):
        advise_points(sample("tee")[0], options=options, seam_options=SeamOptions())


def test_the_command_writes_a_file_to_fill_in(wpcal: Callable[..., Any], tmp_path: Path) -> None:
    out = tmp_path / "taught_template.csv"
    command = ("advise", FIXTURES / "tee" / "tee.step", "-o", out, "--json")
    done = wpcal(*command)
    assert (done.returncode, done.stderr) == (0, "")
    record = json.loads(done.stdout)
    rows = list(csv.DictReader(out.read_text().splitlines()))
    assert [row["name"] for row in rows] == record["chosen"]["features"]
    filled = tmp_path / "taught.csv"
    with filled.open("w", newline="") as file:
        writer = csv.DictWriter(file, rows[0])
        writer.writeheader()
        writer.writerows({**row, "x_mm": k, "y_mm": k * k, "z_mm": 0} for k, row in enumerate(rows))
    assert read_taught(filled).features == tuple(record["chosen"]["features"])
    again = wpcal(*command)
    assert again.returncode == 2
    assert "--force" in again.stderr
