"""`advise_moved`: which touches of a weldment whose bodies may move, in which order, and what each of them serves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from wpcal.calibrate.errors.of_bodies import MeetingPoints
from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.calibrate.observe.bodies import Bodies, TackTolerance
from wpcal.core.arrays import FloatArray, IntArray, as_points
from wpcal.core.errors import ErrorCode, GeometryError, InputError
from wpcal.core.wording import counted, listed
from wpcal.touch.searches.plan import MOST_TOUCHES, SeamPrediction, Served
from wpcal.touch.weldment import (
    OFTEN,
    UNKNOWN_MM,
    CommonErrors,
    MovedModel,
    MovedSearch,
    SeamPoints,
    Tacked,
    deciding_points,
    inverse,
)

MOVED_ADVICE_SCHEMA = "wpcal/moved-advice/1"
NOT_HELD_MM = UNKNOWN_MM / 10.0  #: A larger error means that the touches leave a motion of the whole part free.


@dataclass(frozen=True, slots=True, eq=False)
class TouchChoices:
    """n touches that are possible."""

    names: tuple[str, ...]
    where: tuple[str, ...]  #: length n. Each in words.
    body: IntArray  #: shape (n,). The body that each touch lies on.
    p_part: FloatArray  #: shape (n, 3). mm.
    rows: FloatArray  #: shape (n, q, m). In units of the error of the touch: see `MovedModel.rows`.


@dataclass(frozen=True, slots=True, kw_only=True)
class AdvisedTouch(Served):
    """One touch in the order of the advice, and what it does for the worst seam of its body."""

    index: int  #: In the choices.
    name: str
    where: str
    body: str  #: Name of the body that it lies on.

    def sentence(self) -> str:
        """Say what to touch next, and why."""
        on = "" if self.body in self.where else f" on {self.body}"
        what = f"touch {self.name} next: {self.where}{on}"
        if self.after_mm is None:
            return f"{what}; it helps to hold the part"
        before = "" if self.before_mm is None else f"from {self.before_mm:.2f} mm "
        return f"{what}; it brings the error of seam {self.seam} {before}to {self.after_mm:.2f} mm"

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        names = ("name", "where", "body", "seam", "before_mm", "after_mm")
        return {**{name: getattr(self, name) for name in names}, "sentence": self.sentence()}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class MovedAdvice(SeamPrediction):
    """What to touch on a weldment whose bodies may move, and what that promises for its seams."""

    touches: tuple[AdvisedTouch, ...]  #: In the order in which each lowers the errors most.
    next_touch: AdvisedTouch | None  #: The best further touch.
    model: MovedModel
    tolerance_mm: float | None = None  #: What was asked for.

    def template_rows(self) -> list[tuple[str, str]]:
        """Return name and place of each touch, for `template_csv`."""
        return [(touch.name, touch.where) for touch in self.touches]

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        bodies = self.model.bodies
        return {
            "schema": MOVED_ADVICE_SCHEMA,
            "touches": [touch.to_record() for touch in self.touches],
            "error_95_mm": self.error_95_mm,
            "seam": self.seam,
            "unseen_mm": self.unseen_mm,
            "joint_95_mm": self.joint_95_mm,
            "by_seam": [{"seam": name, "error_95_mm": error} for name, error in self.by_seam_mm],
            "next": None if self.next_touch is None else self.next_touch.to_record(),
            "bodies": [
                {"name": name, "tack_mm": each.mm, "tack_mrad": each.mrad}
                for name, each in zip(bodies.names, bodies.tolerances, strict=True)
            ],
            "tolerance_mm": self.tolerance_mm,
            "why_not": self.why_not,
        }


@dataclass(frozen=True, slots=True)
class HowMany:
    """How many touches are asked for: a number, as many as a tolerance needs, or both.

    Raises `InputError` when neither a positive count nor a positive tolerance is given.
    """

    count: int | None = None  #: How many to add. With a tolerance, how many at least.
    tolerance_mm: float | None = None  #: Add as many as the worst seam needs.
    usual: int = 1  #: How many to add at least if no number reaches the tolerance.
    most: int = MOST_TOUCHES

    def __post_init__(self) -> None:
        if self.count is None and self.tolerance_mm is None:
            raise InputError("say how many touches, or to which tolerance")
        if self.count is not None and self.count < 1:
            raise InputError(f"expected 1 touch or more, got {self.count}")
        if self.tolerance_mm is not None and not 0.0 < self.tolerance_mm < np.inf:
            raise InputError(f"the tolerance must be a positive length, got {self.tolerance_mm:g} mm")


def advise_moved(
    model: MovedModel,
    choices: TouchChoices,
    seams: SeamPoints,
    asked: HowMany,
    *,
    have: tuple[FloatArray, FloatArray] | None = None,
    teaching: TeachingError | None = None,
) -> MovedAdvice:
    """Choose touches that lower the largest error of the seams of a weldment most.

    `have`: Rows and places of touches that were made already, shapes (r, q, m) and (r, 3); on some bodies there may be
    none.
    `teaching`: What is stated of the robot and the tool. By default they are without errors, as in `fit_moved_bodies`.
    Raises `GeometryError` when there is no seam point, nothing to choose from, or all touches leave the part free.
    """
    if len(seams.seams) == 0:
        raise GeometryError("there is no seam where the error counts", code=ErrorCode.NO_SEAM)
    if len(choices.names) == 0:
        raise GeometryError("there is nothing to touch")
    made, places = (choices.rows[:0], choices.p_part[:0]) if have is None else have
    start, common = model.prior() + _information(made), None
    if teaching is not None:
        common = CommonErrors(teaching, 6 * len(model.bodies), choices.p_part, made, places, seams.points.p_part)
    points = seams.points.select(deciding_points(seams.points))
    own = None if common is None else replace(common, seams=points.p_part)
    search = MovedSearch.with_floor(choices.rows, model.seam_rows(points), start, own)
    least, why, tolerance_mm = asked.count or 1, "", asked.tolerance_mm
    if tolerance_mm is None:
        chosen = search.chosen(start, least)
    else:
        chosen, error = search.fewest(start, tolerance_mm, least, max(asked.most, least), asked.usual)
        if error > tolerance_mm:
            head = f"{tolerance_mm:g} mm is not reached: {counted(len(chosen), 'touch')} leave {error:.2f} mm"
            why = f"{head}, {_why_not(search, start, (model, choices, seams), tolerance_mm, len(chosen))}"
    order = search.in_order(start, chosen)
    every = MovedSearch(choices.rows, model.seam_rows(seams.points), common=common)
    errors = every.errors_with(start, order)
    worst = int(np.argmax(errors))
    if errors[worst] > NOT_HELD_MM and len(chosen) == len(choices.names):
        raise GeometryError("the touches that are possible leave a motion of the whole part free")
    best = search.added(start, order)
    shown = order if best is None else [*order, best]
    told = _told(model, choices, seams, every.errors_after(start, shown), shown)
    return MovedAdvice(
        error_95_mm=float(errors[worst]),
        seam=seams.seams[worst],
        by_seam_mm=tuple((name, float(errors[rows].max())) for name, rows in _rows_of(seams).items()),
        joint_95_mm=every.joint_error_with(start, order),
        unseen_mm=_unseen(model, every, inverse(start + every.information(order)), worst),
        why_not=why,
        touches=tuple(told[: len(order)]),
        next_touch=None if best is None else told[-1],
        model=model,
        tolerance_mm=tolerance_mm,
    )


def _information(rows: FloatArray) -> FloatArray:
    H = rows.reshape(-1, rows.shape[-1])
    return np.asarray(H.T @ H)


def _unseen(model: MovedModel, search: MovedSearch, C: FloatArray, point: int) -> float:
    """Return the part of a point's 95 % error that motions of bodies leave which no touch sees, mm."""
    own = C[:, 6 : 6 + 6 * len(model.bodies)]
    one = MovedSearch(search.rows[:0], search.seams[point : point + 1])
    return float(one.errors(own @ own.T)[0])


def _rows_of(seams: SeamPoints) -> dict[str, IntArray]:
    """Return the points of each seam."""
    names = np.array(seams.seams)
    return {name: np.flatnonzero(names == name) for name in dict.fromkeys(seams.seams)}


def _told(
    model: MovedModel, choices: TouchChoices, seams: SeamPoints, errors: FloatArray, order: Sequence[int]
) -> list[AdvisedTouch]:
    """Say what each touch does: `errors`, of shape (n + 1, k), are those before the first and after each of n."""
    points, rows, touches = seams.points, _rows_of(seams), []
    for number, index in enumerate(order):
        before, after = errors[number], errors[number + 1]
        body = int(choices.body[index])
        own = (points.wall_body == body) | (points.base_body == body)
        own = own if own.any() else np.ones(len(before), dtype=bool)
        is_held = bool(before.max() <= NOT_HELD_MM)
        seam = seams.seams[int(np.argmax(np.where(own, before if is_held else after, -1.0)))]
        now, then = (float(each[rows[seam]].max()) for each in (before, after))
        touches.append(
            AdvisedTouch(
                seam=seam,
                before_mm=now if now <= NOT_HELD_MM else None,
                after_mm=then if then <= NOT_HELD_MM else None,
                index=index,
                name=choices.names[index],
                where=choices.where[index],
                body=model.bodies.names[body] if body >= 0 else "the part",
            )
        )
    return touches


def shared_error_words(common_mm: float) -> str:
    """Say that an error that all touches share keeps the error above the tolerance."""
    return (
        f"of which {common_mm:.2f} mm come from an error that all touches share: a touch on a --post, or a "
        "smaller stick_out_sigma_mm in the --setup, would help"
    )


def _why_not(
    search: MovedSearch,
    start: FloatArray,
    weldment: tuple[MovedModel, TouchChoices, SeamPoints],
    tolerance_mm: float,
    count: int,
) -> str:
    """Say what keeps the error above the tolerance: motions that no touch sees, shared errors, or too few touches."""
    model, choices, seams = weldment
    once = search.information(range(len(choices.names)))
    known = np.zeros_like(start)
    if model.shared:
        known[-model.shared :, -model.shared :] = OFTEN * np.eye(model.shared)
    unseen = inverse(start + OFTEN * once + known)
    if search.joint_error(unseen) > tolerance_mm:
        points = seams.points.select(deciding_points(seams.points))
        worst = int(np.argmax(search.errors(unseen)))
        pair = [b for b in dict.fromkeys([int(points.wall_body[worst]), int(points.base_body[worst])]) if b >= 0]
        bare = [model.bodies.names[b] for b in pair if not (choices.body == b).any()]
        least = f"of which {search.joint_error(unseen):.2f} mm come from motions that no possible touch sees"
        names = [model.bodies.names[b] for b in pair]
        what = f"nothing on {listed(bare)} can be touched" if bare else f"of {listed(names)}"
        return f"{least}: {what}; tighter tacks (--tack-mm) or another way to reach these faces would help"
    common = search.joint_error(inverse(start + OFTEN * once))
    if common > tolerance_mm:
        return shared_error_words(common)
    exact = search.joint_error_with(start + OFTEN * once, range(len(choices.names)))
    if exact > tolerance_mm:
        return (
            f"of which {exact:.2f} mm come from the robot's own error, the size of the part and the tool: state what "
            "is known of the robot (--robot-mm)"
        )
    best = search.joint_error_with(start, range(len(choices.names)))
    rest = f"more than {counted(count, 'touch')} are not planned"
    if best > tolerance_mm:
        rest = f"all {len(choices.names)} places that can be touched {best:.2f} mm"
    return f"and {rest}; a better repeatability would help"


def advise_touches(
    p_part: ArrayLike,
    normal_part: ArrayLike,
    body: Sequence[str],
    seam_p: ArrayLike,
    seam_normals: tuple[ArrayLike, ArrayLike],
    seam_bodies: tuple[Sequence[str], Sequence[str]],
    *,
    count: int | None = None,
    tolerance_mm: float | None = None,
    sigma_mm: float = 0.3,
    tack_mm: float = 1.0,
    tack_mrad: float = 3.0,
) -> MovedAdvice:
    """Choose touches on plane faces that lower the largest error of the seams of a weldment most.

    Returns: The index of a touch is its row in `p_part`; seams are named by their bodies: ``web on plate``.

    `p_part`, `normal_part`: shape (n, 3). Places that may be touched, and outward normals there; `part`, mm.
    `body`: length n. The body of each place. A body turns about the middle of its places.
    `seam_p`: shape (k, 3). Points of seams, in `part`, mm.
    `seam_normals`: shape (k, 3) each. Outward normals of the two faces that meet there: of the wall, of the base.
    `seam_bodies`: length k. The bodies of these faces.

    Raises `InputError, GeometryError` when lengths differ, a body of a seam has no place, or as in
    `wpcal.touch.moved_advice.advise_moved`.
    """
    p, n, at = (as_points(each, name="points") for each in (p_part, normal_part, seam_p))
    wall_normal, base_normal = (as_points(each, name="normals") for each in seam_normals)
    lengths = (len(wall_normal), len(base_normal), *(len(each) for each in seam_bodies))
    if not len(p) == len(n) == len(body) or any(each != len(at) for each in lengths):
        raise InputError("the places, or the points of the seams, have normals or bodies of another number")
    unknown = [name for each in seam_bodies for name in each if name not in body]
    if unknown:
        raise InputError(f"body {unknown[0]!r} of a seam has no place that may be touched")
    bodies, own = Bodies.of_points(p, body, TackTolerance(tack_mm, tack_mrad))
    wall, base = (np.array([bodies.names.index(name) for name in each], dtype=np.int64) for each in seam_bodies)
    x = np.cross(wall_normal, base_normal)
    length = np.linalg.norm(x, axis=1)
    points = MeetingPoints(at, wall, base, wall_normal, base_normal, x / np.maximum(length, 1e-12)[:, None], length > 0)
    seams = SeamPoints(points, tuple(f"{a} on {b}" for a, b in zip(*seam_bodies, strict=True)))
    tacked = Tacked(bodies, np.zeros(0, dtype=np.int64), seams)
    model = tacked.model()
    unit = n / np.linalg.norm(n, axis=1, keepdims=True)
    rows = model.rows(p, unit[:, None, :] / sigma_mm, own)
    words = tuple(f"({' '.join(f'{v:g}' for v in place)}) on {name}" for place, name in zip(p, body, strict=True))
    choices = TouchChoices(tuple(f"P{k + 1}" for k in range(len(p))), words, own, p, rows)
    return advise_moved(model, choices, seams, HowMany(count, tolerance_mm), teaching=TeachingError(sigma_mm))
