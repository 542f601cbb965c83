"""Touches for a weldment whose bodies may move: the choice against all, its order, and what cannot be reached."""

from dataclasses import replace
from itertools import combinations
from typing import Any

import numpy as np
import pytest

from tests.weldments import Weldment, uprights
from wpcal.calibrate.errors.of_bodies import MeetingPoints, meeting_errors
from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.calibrate.errors.robot_field import RobotField
from wpcal.calibrate.observe.bodies import Bodies, KeptContacts, TackTolerance
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform
from wpcal.touch.moved_advice import HowMany, MovedAdvice, TouchChoices, advise_moved, advise_touches
from wpcal.touch.weldment import MovedModel, MovedSearch, SeamPoints, Tacked

SIGMA_MM = 0.2
PART = uprights(6)


def seam_points(part: Weldment) -> SeamPoints:
    """Three points of the seam on one side of each upright."""
    p, n, x, body = [], [], [], []
    for b in range(1, len(part.bodies)):
        normal = part.n[np.flatnonzero(part.body == b)[0]]
        along = np.cross(normal, [0.0, 0.0, 1.0])
        for s in (-150.0, 0.0, 150.0):
            p.append(part.bodies.centroid_part[b] * [1.0, 1.0, 0.0] + 4.0 * normal + s * along)
            n.append(normal), x.append(along), body.append(b)
    wall, met = np.array(body), np.ones(len(p), dtype=bool)
    slant = [exp_rotation(0.1 * b * along) for b, along in zip(body, x, strict=True)]  # of the bases, not of the walls
    up = np.array([R @ [0.0, 0.0, 1.0] for R in slant])
    points = MeetingPoints(np.array(p), wall, np.zeros_like(wall), np.array(n), up, np.array(x), met)
    return SeamPoints(points, tuple(f"W{b}" for b in body))


def tacked(part: Weldment) -> Tacked:
    return Tacked(part.bodies, np.zeros(0, dtype=np.int64), seam_points(part))


OWN = tacked(PART)
MODEL = OWN.model()


def choices(part: Weldment, model: MovedModel, some: list[int] | None = None) -> TouchChoices:
    """The touches of the weldment, each of one number."""
    k = list(range(len(part.p))) if some is None else some
    rows = model.rows(part.p[k], part.n[k][:, None, :] / SIGMA_MM, part.body[k])
    return TouchChoices(tuple(f"T{i}" for i in k), tuple("" for _ in k), part.body[k], part.p[k], rows)


def advised(part: Weldment, some: list[int] | None = None, **options: float) -> MovedAdvice:
    own = tacked(part)
    return advise_moved(own.model(), choices(part, own.model(), some), own.seams, HowMany(**options))  # type: ignore[arg-type]


@pytest.mark.parametrize("robot", [None, RobotField(0.3, 400.0)])
def test_the_predicted_error_is_the_one_after_the_fit(robot: RobotField | None) -> None:
    """Touches without errors on a part that did not move: the covariance of the fit is that of the plan."""
    T = RigidTransform.identity(target="base", source="part")
    still = PART.drawn(np.random.default_rng(0), scale=0.0)
    touches = PART.touched(replace(still, T_base_part=T), 0.0, np.random.default_rng(0))
    teaching = None if robot is None else TeachingError(robot=robot, tcp_bias_mm=0.2)
    found = PART.moved(touches, T, SIGMA_MM, teaching=teaching).fit
    error = meeting_errors(found, OWN.seams.points)
    advice = advise_moved(MODEL, choices(PART, MODEL), OWN.seams, HowMany(len(PART.p)), teaching=teaching)
    assert advice.error_95_mm == pytest.approx(error.total_mm.max(), rel=1e-6)
    assert advice.unseen_mm == pytest.approx(error.unseen_mm[int(np.argmax(error.total_mm))], rel=1e-6)


def test_errors_after_each_touch_are_those_of_the_whole_inverse() -> None:
    some = choices(PART, MODEL)
    three = replace(some, rows=some.rows.reshape(-1, 3, MODEL.size))  # three numbers each
    search = MovedSearch(three.rows, MODEL.seam_rows(OWN.seams.points))
    M = MODEL.prior() + search.information([0, 4, 9])
    scores = search.scores(np.linalg.inv(M))
    for k in range(len(three.rows)):
        errors = search.errors(np.linalg.inv(M + search.information([k])))
        assert scores[k] == pytest.approx(1.5 * np.sum(errors**16.0) ** (1 / 16), rel=1e-6)  # no floor: both parts


def test_errors_along_an_order_are_those_of_the_whole_inverse() -> None:
    search = MovedSearch(choices(PART, MODEL).rows, MODEL.seam_rows(OWN.seams.points))
    order = [0, 7, 3, 4, 12, 1, 20, 5]
    errors = search.errors_after(MODEL.prior(), order)
    for k in (6, 8):  # the part is held
        direct = search.errors(np.linalg.inv(MODEL.prior() + search.information(order[:k])))
        np.testing.assert_allclose(errors[k], direct, rtol=1e-4, atol=0)


def test_the_choice_is_nearly_the_best_of_all_sets() -> None:
    some = [*range(6), *range(6, 12)]  # the base and one upright
    search = MovedSearch(choices(PART, MODEL, some).rows, MODEL.seam_rows(OWN.seams.points)[:3])
    prior, sets = MODEL.prior(), combinations(range(12), 8)
    every = [search.errors(np.linalg.inv(prior + search.information(each))).max() for each in sets]
    found = search.errors(np.linalg.inv(prior + search.information(search.chosen(prior, 8)))).max()
    assert found <= 1.02 * min(every)
    assert found < 0.5 * np.median(every)


def test_a_body_without_a_touch_is_touched_next(golden: Any) -> None:
    made = np.flatnonzero(PART.body != 3)
    have = choices(PART, MODEL, made.tolist()).rows, PART.p[made]
    advice = advise_moved(MODEL, choices(PART, MODEL), OWN.seams, HowMany(1), have=have)
    (touch,) = advice.touches
    assert (touch.body, touch.seam) == ("U3", "W3")
    assert touch.before_mm is not None
    assert touch.after_mm is not None
    assert touch.after_mm < touch.before_mm
    assert "on U3" in touch.sentence()
    assert f"seam W3 from {touch.before_mm:.2f} mm to {touch.after_mm:.2f} mm" in touch.sentence()
    golden(advice)


def test_more_touches_are_taken_until_the_tolerance_is_reached(golden: Any) -> None:
    loose, tight = (advised(PART, tolerance_mm=mm) for mm in (3.0, 1.2))
    assert len(loose.touches) < len(tight.touches) < len(PART.p)
    assert loose.joint_95_mm <= 3.0
    assert tight.joint_95_mm <= 1.2
    assert loose.why_not == tight.why_not == ""
    fewer = advised(PART, count=len(tight.touches) - 2)
    assert fewer.joint_95_mm > 1.2
    golden([loose, tight, fewer])


def test_what_cannot_be_reached_says_why(golden: Any) -> None:
    on_others = np.flatnonzero(PART.body != 2).tolist()
    assert "nothing on U2 can be touched" in advised(PART, on_others, tolerance_mm=0.8).why_not
    assert "all 30 places" in advised(PART, tolerance_mm=0.1).why_not
    model = OWN.model(shared=1)
    k = np.arange(len(PART.p))
    long_wire = -2.0 / SIGMA_MM * PART.n[:, 2:][:, None, :]  # all see 2 mm of the wire that points down
    rows = model.rows(PART.p, PART.n[:, None, :] / SIGMA_MM, PART.body, long_wire)
    some = TouchChoices(tuple(f"T{i}" for i in k), ("",) * len(k), PART.body, PART.p, rows)
    advice = advise_moved(model, some, OWN.seams, HowMany(tolerance_mm=1.5))
    assert "--post" in advice.why_not
    golden(advice)


def test_a_kept_contact_keeps_the_gap() -> None:
    """Feet that stay on the base within 1 µm; along the base they are as free as before."""
    foot = PART.bodies.centroid_part[1:] * [1.0, 1.0, 0.0]
    wall, base = np.arange(1, 5), np.zeros(4, dtype=np.int64)
    up, along = (np.tile(axis, (4, 1)) for axis in ([0.0, 0.0, 1.0], [1.0, 0.0, 0.0]))
    kept = KeptContacts(foot, up, wall, base, np.full(4, 1e-3))
    for part, gap_mm in ((tacked(PART), 1.0), (replace(tacked(PART), contacts=kept), 1e-3)):
        model = part.model()
        C = np.linalg.inv(model.prior())
        for ways, least, most in ((up, 0.9 * gap_mm, 2.5 * gap_mm), (along, 1.0, 2.5)):
            G = model.rows(foot, ways[:, None, :], wall)[:, 0] - model.rows(foot, ways[:, None, :], base)[:, 0]
            gap = np.sqrt(np.einsum("ni,ij,nj->n", G, C, G))
            assert (least <= gap).all()
            assert (gap <= most).all()


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({}, "say how many touches"),
        ({"count": 0}, "1 touch or more"),
        ({"tolerance_mm": 0.0}, "must be a positive length"),
    ],
)
def test_what_cannot_be_asked(options: dict[str, float], message: str) -> None:
    with pytest.raises(InputError, match=message):
        advised(PART, **options)


def test_a_part_without_seams_or_places_is_refused() -> None:
    none = SeamPoints(OWN.seams.points.select(np.zeros(0, dtype=np.int64)), ())
    with pytest.raises(GeometryError, match="no seam"):
        advise_moved(MODEL, choices(PART, MODEL), none, HowMany(1))
    with pytest.raises(GeometryError, match="nothing to touch"):
        advise_moved(MODEL, choices(PART, MODEL, []), OWN.seams, HowMany(1))


def test_tight_tacks_are_the_rigid_part() -> None:
    """The uprights follow the base: a touch on any body serves all seams."""
    stiff = tuple(TackTolerance(1e-6, 1e-6) for _ in PART.bodies.names)
    part = replace(PART, bodies=replace(PART.bodies, tolerances=stiff))
    advice = advised(part, count=6)
    J = tacked(part).model().rows(part.p, part.n[:, None, :], part.body)[:, 0, :6]
    chosen = [touch.index for touch in advice.touches]
    assert np.linalg.matrix_rank(J[chosen]) == 6
    assert advice.unseen_mm < 1e-3


def test_arrays_alone_give_the_advice_of_the_model_that_is_made_of_them() -> None:
    body = [PART.bodies.names[b] for b in PART.body]
    part = replace(PART, bodies=Bodies.of_points(PART.p, body, TackTolerance(0.7, 4.0))[0])
    own, teaching = tacked(part), TeachingError(SIGMA_MM)
    made = advise_moved(own.model(), choices(part, own.model()), own.seams, HowMany(9), teaching=teaching)
    at, options = own.seams.points, {"sigma_mm": SIGMA_MM, "tack_mm": 0.7, "tack_mrad": 4.0}
    faces = [[part.bodies.names[b] for b in each] for each in (at.wall_body, at.base_body)]
    normals = at.n_wall, at.n_base
    found = advise_touches(part.p, 3.0 * part.n, body, at.p_part, normals, tuple(faces), count=9, **options)
    assert found.error_95_mm == pytest.approx(made.error_95_mm, rel=1e-9)
    for touch, same in zip(found.touches, made.touches, strict=True):
        x, y, z = part.p[same.index]
        told = f"P{same.index + 1}", f"({x:g} {y:g} {z:g}) on {same.body}", same.seam.replace("W", "U") + " on base"
        assert (touch.name, touch.where, touch.seam) == told
