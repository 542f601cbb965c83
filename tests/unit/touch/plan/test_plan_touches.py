"""Plans of touches: the choice against all sets, the rules of every search, and what is said without a plan."""

import math
from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import pytest

from tests.benchmarks.bench_touches import compared
from tests.few import few
from tests.touch_parts import touch_part
from wpcal.brep.graph import SurfaceKind
from wpcal.brep.hits import find_hits
from wpcal.calibrate.errors.of_touches import budget_of_touches
from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.calibrate.errors.robot_field import RobotField
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.plane_touches import Planes
from wpcal.calibrate.solve.touches import Pose
from wpcal.calibrate.trust.criteria import Criterion
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.robot_space import RobotSpace
from wpcal.core.transform import RigidTransform
from wpcal.touch.plan import NominalError, Pattern, TouchOptions, plan_touches
from wpcal.touch.plan.choose import TouchDesign, best_set, joint_error_of
from wpcal.touch.plan.contacts import find_places, surface_labels
from wpcal.touch.plan.free import find_strokes
from wpcal.touch.plan.part import PartPlace
from wpcal.touch.searches import Contact, SearchKind, plan_from_record, touches_record
from wpcal.touch.searches.setup import TouchSetup

UP = np.array([0.0, 0.0, 1.0])
ON_FACE_MM = 1e-6
SAMPLED = 0.35  #: Of the 95 % quantile of sixty runs.
SAME = 1e-9  #: Of errors that are computed in another order.


def random_design(seed: int, count: int = 14) -> TouchDesign:
    """Return touches on the sides of a box, some held askew."""
    rng = np.random.default_rng(seed)
    normal = np.eye(3)[rng.integers(0, 3, count)] * rng.choice([-1.0, 1.0], (count, 1))
    p = rng.uniform(-1.0, 1.0, (count, 3)) * [200.0, 120.0, 60.0]
    wire = -normal + rng.uniform(-1.0, 1.0, (count, 3))
    wire /= np.linalg.norm(wire, axis=1, keepdims=True)
    seams = rng.uniform(-1.0, 1.0, (9, 3)) * [200.0, 120.0, 60.0]
    return TouchDesign.of(p, normal, wire, TouchSetup(), seams, stick_out_sigma_mm=0.5)


@pytest.mark.parametrize("seed", range(4))
def test_the_choice_is_the_best_of_all_sets(seed: int) -> None:
    design = random_design(seed)
    every = np.array(list(combinations(range(len(design)), 7)))
    least = design.largest_errors(every).min()
    rows, error = best_set(design, 7, slots=None, rng=np.random.default_rng(0))
    assert len(set(rows.tolist())) == 7
    assert error == pytest.approx(least, rel=SAME)


def test_six_planned_touches_are_better_than_the_best_classical_pattern_where_fits_are_simulated() -> None:
    predicted, planned, classical = compared(touch_part("lap"), TouchSetup(), runs=60)
    assert planned <= 0.8 * classical
    assert planned == pytest.approx(predicted, rel=SAMPLED)


def test_the_predicted_covariance_is_that_of_simulated_fits() -> None:
    design = random_design(1)
    sets = np.arange(8)
    predicted, free = design.covariances(sets[None])
    assert not free[0]
    rng = np.random.default_rng(0)
    own = rng.normal(size=(40_000, 8)) * np.sqrt(design.variances[sets])
    errors = own + rng.normal(size=(40_000, 2)) @ design.shared[sets].T
    H, w = design.rows[sets], design.weights[sets]
    xi = errors @ (w[:, None] * H) @ np.linalg.inv(H.T @ (w[:, None] * H))
    ratio = np.linalg.eigvals(np.linalg.solve(predicted[0], np.cov(xi.T))).real
    np.testing.assert_allclose(ratio, 1.0, rtol=0, atol=0.05)


def test_opposite_touches_cancel_the_latency() -> None:
    p = np.array([[100.0, 0, 0], [-100.0, 0, 0], [0, 50, 10], [0, -50, 10], [30, 0, 20], [-30, 10, 20], [10, -20, 20]])
    normal = np.array([[1.0, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, 1], [0, 0, 1]])
    normal[3] = [1.0, 0, 0]
    late = replace(TouchSetup(), repeatability_mm=1e-6, latency_sigma_s=0.1, stick_out_sigma_mm=0.0)
    design = TouchDesign.of(p, normal, -normal, late, np.zeros((1, 3)), stick_out_sigma_mm=0.0)
    covariance = design.covariances(np.arange(7)[None])[0][0]
    one_sided = design.covariances(np.array([[0, 3, 2, 4, 5, 6]]))[0][0]
    assert covariance[3, 3] < 0.2 * one_sided[3, 3]


@pytest.mark.parametrize("name", few(["saddle", "tee"], 1))
def test_every_search_keeps_the_rules(name: str, golden: Any) -> None:
    part = touch_part(name)
    options = TouchOptions()
    plan = plan_touches(part, options=options)
    assert len(plan.searches) == 8
    trimmed = part.trimmed
    for search in plan.searches:
        np.testing.assert_allclose(search.direction, -search.normal_part, rtol=0, atol=ON_FACE_MM)
        before = float((search.start - search.planned) @ search.normal_part)
        after = float((search.planned - search.end) @ search.normal_part)
        assert before > 2.5  # 99 % of 1 mm alone
        assert after > 2.5
        angle = math.degrees(math.acos(float(np.clip(search.R_part_tool[:, 2] @ search.direction, -1, 1))))
        assert angle < 1e-3 if search.contact is Contact.END else angle >= 20.0
        assert search.radius_mm == pytest.approx(0.6 * math.sin(math.radians(angle)), abs=1e-6)
        ray = find_hits(trimmed, search.start[None], search.direction[None], length_mm=search.stroke_mm)
        first = ray.at_mm.min(initial=np.inf)
        assert first == pytest.approx(before + search.radius_mm, abs=1e-3)  # the face itself
        assert np.linalg.det(search.R_part_tool) == pytest.approx(1.0)
        assert np.linalg.eigvalsh(search.covariance_part)[0] > 0.0
    golden(plan)


def test_rounds_are_not_touched_although_they_look_everywhere(golden: Any) -> None:
    part = touch_part("rounded-upright")
    found, _ = find_places(part.graph, part.trimmed, PartPlace.of(part.trimmed, UP), TouchOptions())
    strokes = find_strokes(part.graph, part.trimmed, found, TouchOptions())
    radius = part.graph.face_param[strokes.contacts.face, 0]
    round_ = part.graph.face_kind[strokes.contacts.face] == SurfaceKind.CYLINDER
    assert len(strokes)
    assert not (round_ & (radius < 6.0)).any()
    golden(strokes)


def test_faces_of_one_surface_have_one_label() -> None:
    graph = touch_part("saddle").graph
    labels = surface_labels(graph)
    for face in range(graph.face_count):
        for other in range(face):
            if labels[face] == labels[other]:
                assert graph.face_solid[face] == graph.face_solid[other]
                np.testing.assert_allclose(graph.face_param[face], graph.face_param[other], rtol=0, atol=1e-3)
    assert len(np.unique(labels)) >= 6


def test_a_part_that_stands_otherwise_is_touched_from_its_upper_side(golden: Any) -> None:
    part = touch_part("tee")
    place = RigidTransform.from_six_tuple([800.0, 0, 500.0, math.radians(90), 0, 0.4], target="base", source="part")
    plan = plan_touches(part, options=TouchOptions(), T_base_part=place)
    wire = np.array([place.rotate(search.R_part_tool[:, 2]) for search in plan.searches])
    assert (wire[:, 2] <= -0.5 + SAME).all()
    again = plan_from_record(touches_record(plan))
    assert again.fingerprint == plan.fingerprint
    golden(plan)


def test_a_post_comes_first_and_makes_the_seams_sure(golden: Any) -> None:
    part = touch_part("lap")
    without = plan_touches(part, options=TouchOptions())
    plan = plan_touches(part, options=TouchOptions(post_base=(300.0, 0.0, 50.0)))
    assert plan.searches[0].kind is SearchKind.POST
    np.testing.assert_allclose(plan.searches[0].planned, [300.0, 0.0, 50.0], rtol=0, atol=SAME)
    assert len(plan.searches) == 9
    assert plan.predicted.error_95_mm < without.predicted.error_95_mm
    golden([without.searches, plan.searches])


def test_patterns_have_six_touches_and_never_less_error(golden: Any) -> None:
    part = touch_part("tee")
    best = plan_touches(part, options=TouchOptions(touches=6))
    for pattern in (Pattern.THREE_TWO_ONE, Pattern.THREE_POINT):
        plan = plan_touches(part, options=TouchOptions(touches=6, pattern=pattern))
        assert len(plan.searches) == 6
        assert plan.predicted.error_95_mm >= best.predicted.error_95_mm * (1.0 - SAME)
        if pattern is Pattern.THREE_TWO_ONE:
            axes = np.abs(np.array([search.normal_part for search in plan.searches])).argmax(axis=1)
            assert sorted(np.bincount(axes, minlength=3).tolist()) == [1, 2, 3]
    golden([best, plan])


def test_what_is_wrong_is_one_line() -> None:
    with pytest.raises(InputError, match="5 touches: expected 6 to 60"):
        TouchOptions(touches=5)
    with pytest.raises(InputError, match="the pattern 3-2-1 has 6 touches, got 8"):
        TouchOptions(touches=8, pattern=Pattern.THREE_TWO_ONE)
    with pytest.raises(InputError, match="leave it or the tolerance away"):
        TouchOptions(pattern=Pattern.THREE_TWO_ONE, tolerance_mm=1.0)
    with pytest.raises(InputError, match="the tolerance must be a positive length"):
        TouchOptions(tolerance_mm=0.0)
    with pytest.raises(InputError, match="the uncertainty of the part's place"):
        NominalError(sigma_mm=-1.0)
    part = touch_part("lap")
    with pytest.raises(GeometryError, match=r"too small for a displacement of .* mm .*--uncertainty-mm") as caught:
        plan_touches(part, options=TouchOptions(nominal=NominalError(sigma_mm=30.0)))
    assert "\n" not in str(caught.value)


def test_a_free_motion_is_named() -> None:
    left = NominalError(left=np.diag([0.0, 0.0, 0.0, 16.0, 16.0, 16.0]))  # there is no third stage
    with pytest.raises(GeometryError, match=r"leave the part free: it (slides|turns|screws) .*; ") as caught:
        plan_touches(touch_part("tee"), options=TouchOptions(nominal=left))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("robot", [RobotField(0.3, 400.0), RobotField(0.0, 400.0, rest_mm=0.1)])
def test_a_plan_with_a_stated_robot_promises_what_the_verdict_compares(robot: RobotField) -> None:
    design = replace(random_design(3), robot=robot)
    rows, names = np.arange(12), tuple(f"T{k}" for k in range(12))
    p, n, shared = design.p[rows], design.normal[rows], design.shared[rows, None, :] * design.normal[rows, :, None]
    covariances = design.variances[rows, None, None] * np.eye(3) + shared @ shared.swapaxes(1, 2)
    own = (Planes(p, n), names, covariances, RobotSpace.NOMINAL, rows)
    touches = Touches(names, p, np.zeros(12), *own, shared=shared)
    pose = Pose.of(touches, np.eye(3), np.zeros(3))
    found = budget_of_touches(touches, pose, Criterion.WEIGHTED, TeachingError(robot=robot))
    promised = joint_error_of(design, rows, design.seam_points)
    assert promised == pytest.approx(found.joint_errors(design.seam_points).error_95_mm, rel=1e-6)
    alone = joint_error_of(replace(design, robot=RobotField.none()), rows, design.seam_points)
    assert promised > alone
