"""Points without names: the one answer, or a refusal that says what would settle it."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.few import few
from tests.unit.taught.match.random_parts import as_features, pattern_points, random_points, random_pose, touched
from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import GeometryError
from wpcal.core.transform import RigidTransform
from wpcal.taught.features import FeatureKind, ReferenceFeature
from wpcal.taught.match import Match, MatchOptions, match_points, name_points
from wpcal.taught.table import TaughtPoints

BOX = np.array([[x, y, z] for x in (0, 100) for y in (0, 60) for z in (0, 20)], dtype=float)
NOMINAL = RigidTransform.identity(target="nominal", source="part")
POSE_MM, POSE_RAD = 1e-9, 1e-11
"""Round-off of fits of coordinates of 1e3 mm."""


def without_names(p_base: FloatArray) -> TaughtPoints:
    taught = TaughtPoints.of_features([f"P{i}" for i in range(1, len(p_base) + 1)], p_base)
    return replace(taught, features=("",) * len(p_base))


def test_an_odd_part_has_one_answer(golden: Any) -> None:
    rng = np.random.default_rng(0)
    points = random_points(rng, 100)
    T = random_pose(rng)
    named = name_points(without_names(T.apply(points[[4, 9, 30, 77]])), as_features(points))
    assert named.features == ("V5", "V10", "V31", "V78")
    golden(named)


def test_names_that_are_there_are_not_looked_at() -> None:
    taught = TaughtPoints.of_features(["V1", "V2", "V3"], np.eye(3))
    assert name_points(taught, as_features(BOX)) is taught


def test_a_box_is_refused_with_its_symmetry() -> None:
    match = match_points(without_names(BOX[[0, 1, 2, 4]] + 5.0), as_features(BOX))
    assert match.chosen is None
    assert len(match.answers) == 4
    assert "a half turn about the line along z through (50, 30, 0)" in match.reason
    assert "give the nominal pose, or write the feature's name of one point" in match.reason
    with pytest.raises(GeometryError, match="4 answers fit"):
        name_points(without_names(BOX[[0, 1, 2, 4]] + 5.0), as_features(BOX))


def test_the_nominal_pose_chooses_among_symmetric_answers() -> None:
    taught = without_names(BOX[[0, 1, 2, 4]] + 5.0)
    match = match_points(taught, as_features(BOX), MatchOptions(T_nominal_part=NOMINAL))
    assert match.chosen is not None
    assert match.answers[match.chosen].features == ("V1", "V2", "V3", "V5")
    turned = RigidTransform.from_six_tuple([100, 60, 0, 0, 0, np.pi], target="nominal", source="part")
    other = match_points(taught, as_features(BOX), MatchOptions(T_nominal_part=turned))
    assert other.chosen is not None
    assert other.answers[other.chosen].features == ("V7", "V8", "V5", "V3")
    assert other.answers[other.chosen].T_base_part.is_close(
        RigidTransform.from_six_tuple([105, 65, 5, 0, 0, np.pi], target="base", source="part"),
        atol_mm=POSE_MM,
        atol_rad=POSE_RAD,
    )


def test_a_nominal_pose_between_two_answers_does_not_choose() -> None:
    between = RigidTransform.from_six_tuple([80, -20, 0, 0, 0, np.pi / 2], target="nominal", source="part")
    match = match_points(without_names(BOX[[0, 1, 2, 4]]), as_features(BOX), MatchOptions(T_nominal_part=between))
    assert match.chosen is None
    assert "the nominal pose does not tell" in match.reason


def test_one_name_settles_a_symmetric_part() -> None:
    taught = replace(without_names(BOX[[0, 1, 2, 4]] + 5.0), features=("", "v2", "", ""))
    assert name_points(taught, as_features(BOX)).features == ("V1", "V2", "V3", "V5")


def test_the_point_that_is_asked_for_settles_it() -> None:
    rng = np.random.default_rng(1)
    points = np.concatenate([BOX, [[40.0, 25, 20]]])  # an odd hole makes the box one of its kind
    T = random_pose(rng)
    rows = [0, 1, 2, 4]
    match = match_points(without_names(T.apply(points[rows])), as_features(points))
    assert match.chosen is None
    assert "teach one more: V9 would settle it" in match.reason
    named = name_points(without_names(T.apply(points[[*rows, 8]])), as_features(points))
    assert named.features == ("V1", "V2", "V3", "V5", "V9")


def test_close_features_are_told_from_symmetry(golden: Any) -> None:
    points = np.concatenate([random_points(np.random.default_rng(2), 30), [[500.0, 300, 150], [500.4, 300, 150]]])
    match = match_points(without_names(points[[0, 1, 2, 30]]), as_features(points))
    assert match.chosen is None
    assert "P4 may be V31 or V32" in match.reason
    assert name_points(without_names(points[[0, 1, 2, 30]]), as_features(points), sigma_mm=0.02).features[3] == "V31"
    golden(match)


def test_the_error_that_the_points_state_is_used(golden: Any) -> None:
    points = random_points(np.random.default_rng(6), 50)
    taught = points[:5] + 2.0 * np.random.default_rng(0).standard_normal((5, 3))
    with pytest.raises(GeometryError, match=r"error of 0\.3 mm"):
        name_points(without_names(taught), as_features(points))
    covariances = np.tile(4.0 * np.eye(3), (5, 1, 1))
    match = match_points(replace(without_names(taught), covariances=covariances), as_features(points))
    assert match.answers[0].features == ("V1", "V2", "V3", "V4", "V5")
    golden(match)


def test_a_mis_taught_point_fits_nothing() -> None:
    points = random_points(np.random.default_rng(3), 50)
    taught = points[:5].copy()
    taught[4, 2] += 30.0
    with pytest.raises(GeometryError, match="mis-taught"):
        match_points(without_names(taught), as_features(points))


def test_points_left_out_are_not_matched() -> None:
    points = random_points(np.random.default_rng(4), 50)
    taught = without_names(np.vstack([points[:4], [[9e3, 0, 0]]]))
    named = name_points(replace(taught, use=("yes", "check", "yes", "yes", "no")), as_features(points))
    assert named.features == ("V1", "V2", "V3", "V4", "")


def test_features_at_one_place_are_one_answer() -> None:
    points = random_points(np.random.default_rng(5), 20)
    rim = ReferenceFeature("C1", FeatureKind.CIRCLE, frozen(points[0]), None, 8.0, "S1")
    hole = ReferenceFeature("H1", FeatureKind.HOLE, frozen(points[0]), None, 8.0, "S1")
    features = (rim, hole, *as_features(points)[1:])
    assert name_points(without_names(points[:4]), features).features == ("H1", "V2", "V3", "V4")


def test_a_plane_is_no_point_without_a_name() -> None:
    points = random_points(np.random.default_rng(6), 20)
    datum = ReferenceFeature("P1", FeatureKind.PLANE, frozen(points[0]), None, None, "S1")
    with pytest.raises(GeometryError, match="no features of the part"):
        match_points(without_names(points[:4]), (datum, *as_features(points)[1:]))


def wrong_single_answers(parts: int, seed: int) -> tuple[int, int]:
    """Count wrong answers that stand alone, and right ones, over random parts, half of them regular."""
    rng = np.random.default_rng(seed)
    wrong = right = 0
    for part in range(parts):
        points = pattern_points(rng) if part % 2 else random_points(rng, int(rng.integers(20, 1500)))
        rows, taught = touched(rng, points, int(rng.integers(3, 7)), 0.3)
        match = match_points(without_names(taught), as_features(points))
        if match.chosen is not None:
            expected = tuple(f"V{row + 1}" for row in rows)
            wrong += match.answers[match.chosen].features != expected
            right += match.answers[match.chosen].features == expected
    return wrong, right


@pytest.mark.parametrize(("count", "seed", "least"), few([(30, 0, 5), (500, 1, 150)], 1))
def test_no_wrong_answer_stands_alone(count: int, seed: int, least: int) -> None:
    wrong, right = wrong_single_answers(count, seed=seed)
    assert (wrong, right >= least) == (0, True)


def test_a_record_has_all_answers() -> None:
    match: Match = match_points(without_names(BOX[[0, 1, 2, 4]]), as_features(BOX))
    record = match.to_record()
    assert record["schema"] == "wpcal/match/1"
    assert len(record["answers"]) == 4
    np.testing.assert_allclose(sum(a["probability"] for a in record["answers"]), 1.0, rtol=0, atol=1e-12)
