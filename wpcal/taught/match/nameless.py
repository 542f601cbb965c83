"""Taught points without names: which feature each of them is, or why that cannot be told."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from wpcal.calibrate.errors.robot_field import USUAL_SIGMA_MM
from wpcal.calibrate.solve.least_squares import kabsch
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.linked import near_tree
from wpcal.core.options import opt
from wpcal.core.progress import Progress
from wpcal.core.transform import RigidTransform
from wpcal.taught.features.reference import POINT_KINDS, FeatureKind, ReferenceFeature, feature_named
from wpcal.taught.match.places import Places
from wpcal.taught.match.search import MOST_ANSWERS, Assignments, find_assignments
from wpcal.taught.match.symmetry import EXACT_MM, PartMotion, best_next_point
from wpcal.taught.table import TaughtPoints

if TYPE_CHECKING:
    from scipy.spatial import cKDTree

DECISIVE_ODDS = 1e5  #: An answer is taken when it is this many times as probable as all others together.
COMPARED_ANSWERS = 20
"""The next point is chosen to distinguish this many answers. With Gaussian errors the rest have no weight."""
MOST_TRIED = 500  #: Features tried as the next point. Trying more hardly finds a better one.
LEFT_OVER = 0.01
"""Expected number of wrong answers that still fit, below which a further point is said to settle the matter."""
MATCH_SCHEMA = "wpcal/match/1"


@dataclass(frozen=True, slots=True, eq=False)
class Answer:
    """One way in which the taught points can be features."""

    features: tuple[str, ...]  #: length n. Name of the feature that each taught point is.
    T_base_part: RigidTransform  #: Least-squares fit.
    rms_mm: float  #: Root mean square distance of that fit, mm.
    probability: float  #: Among all answers, for Gaussian errors.


@dataclass(frozen=True, slots=True, eq=False)
class Match:
    """All answers, and the one that is taken."""

    points: tuple[str, ...]  #: length n. Names of the taught points.
    answers: tuple[Answer, ...]  #: The best fit first.
    chosen: int | None  #: Which of them is taken; None when that cannot be told.
    reason: str  #: Why it is taken, or why none is and what would settle it.
    complete: bool  #: False when there are more answers than are kept.

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {
            "schema": MATCH_SCHEMA,
            "points": list(self.points),
            "chosen": self.chosen,
            "reason": self.reason,
            "complete": self.complete,
            "answers": [
                {
                    "features": list(answer.features),
                    "rms_mm": answer.rms_mm,
                    "probability": answer.probability,
                    "T_base_part": answer.T_base_part.matrix.tolist(),
                }
                for answer in self.answers
            ],
        }


@dataclass(frozen=True, slots=True, kw_only=True)
class MatchOptions:
    """What is known of points without a name."""

    #: By default the largest that the points state themselves, or `wpcal.calibrate.errors.prediction.USUAL_SIGMA_MM`.
    sigma_mm: float | None = opt(None, "Teaching error: standard deviation per axis.  [default: 0.3]")
    T_nominal_part: RigidTransform | None = None  #: Of several answers the nearest is taken.
    kinds: tuple[FeatureKind, ...] = opt(
        POINT_KINDS,
        "Only these kinds of features. For points without a name.  [default: all]",
        "--kind",
        many=True,
        choices=POINT_KINDS,
    )


USUAL_MATCH = MatchOptions()


def match_points(
    taught: TaughtPoints,
    features: Sequence[ReferenceFeature],
    options: MatchOptions = USUAL_MATCH,
    *,
    progress: Progress | None = None,
) -> Match:
    """Find which feature each taught point is.

    Raises `GeometryError` when no assignment fits, or the points are too few or on one line.
    Raises `InputError` when a feature's name is unknown.
    """
    used = [row for row, use in enumerate(taught.use) if use != "no"]
    sigma = _stated_sigma(taught, used) if options.sigma_mm is None else options.sigma_mm
    named = {feature_named(features, taught.features[row]).name for row in used if taught.features[row]}
    places = Places.of([each for each in features if each.kind in options.kinds or each.name in named])
    allowed = [_allowed(taught, row, features, places, options.kinds) for row in used]
    points = tuple(taught.names[row] for row in used)
    p_base = taught.p_base[used]
    found = find_assignments(places.p, p_base, sigma_mm=sigma, allowed=allowed, progress=progress)
    if len(found.rows) == 0:
        raise GeometryError(
            f"no features of the part have the distances of the taught points {', '.join(points)} within a teaching "
            f"error of {sigma:g} mm per axis: a point is mis-taught or no feature, or the error is larger"
        )
    return _Decision(places, points, p_base, found, sigma).match(options.T_nominal_part)


def name_points(
    taught: TaughtPoints,
    features: Sequence[ReferenceFeature],
    *,
    sigma_mm: float | None = None,
    T_nominal_part: RigidTransform | None = None,
    progress: Progress | None = None,
) -> TaughtPoints:
    """Fill in the features of points that have no name. If all have one, the points are returned unchanged.

    Raises `GeometryError` when there are several answers; the message says what would settle it. Otherwise as
    `match_points`.
    """
    used = [row for row, use in enumerate(taught.use) if use != "no"]
    if not any(not taught.features[row] and np.isnan(taught.p_part[row]).any() for row in used):
        return taught
    asked = MatchOptions(sigma_mm=sigma_mm, T_nominal_part=T_nominal_part)
    match = match_points(taught, features, asked, progress=progress)
    if match.chosen is None:
        raise GeometryError(match.reason)
    names = list(taught.features)
    for row, name in zip(used, match.answers[match.chosen].features, strict=True):
        names[row] = name
    return replace(taught, features=tuple(names))


def _stated_sigma(taught: TaughtPoints, used: Sequence[int]) -> float:
    if taught.covariances is None or not used:
        return USUAL_SIGMA_MM
    return math.sqrt(float(np.linalg.eigvalsh(taught.covariances[list(used)]).max()))


def _allowed(
    taught: TaughtPoints, row: int, features: Sequence[ReferenceFeature], places: Places, kinds: Sequence[FeatureKind]
) -> IntArray | None:
    if not np.isnan(taught.p_part[row]).any():
        raise InputError("points without names and points with model coordinates cannot be in one file")
    if not taught.features[row]:
        rows = places.of_kinds(kinds)
        return None if len(rows) == len(places.p) else rows
    return np.array([places.holding(feature_named(features, taught.features[row]).name)])


@dataclass(frozen=True, slots=True, eq=False)
class _Decision:
    """Takes one of the answers, or says why none."""

    places: Places
    points: tuple[str, ...]
    p_base: FloatArray
    found: Assignments
    sigma_mm: float

    def match(self, T_nominal_part: RigidTransform | None) -> Match:
        p = self.places.p[self.found.rows]
        R, t = kabsch(p, np.broadcast_to(self.p_base, p.shape), np.full(p.shape[:2], 1.0 / p.shape[1]))
        weights = self._weights()
        chosen, reason = self._choose(R, t, weights, T_nominal_part)
        n = self.found.rows.shape[1]
        answers = tuple(
            Answer(
                tuple(self.places.names[p] for p in rows),
                RigidTransform(R[k], t[k], "base", "part"),
                math.sqrt(float(self.found.squares_mm2[k]) / n),
                float(weights[k]),
            )
            for k, rows in enumerate(self.found.rows)
        )
        return Match(self.points, answers, chosen, reason, self.found.complete)

    def _weights(self) -> FloatArray:
        """Probabilities of the answers: equal before the touch, then by exp(-S / 2σ²)."""
        scale = max(self.sigma_mm, EXACT_MM) ** 2
        squares = self.found.squares_mm2
        w = np.exp(-(squares - squares[0]) / (2.0 * scale))
        return np.asarray(w / w.sum())

    @property
    def _tolerance_mm(self) -> float:
        """What a distance may be off, mm."""
        return math.sqrt(2.0 * self.found.limit_mm2)

    def _choose(
        self, R: FloatArray, t: FloatArray, weights: FloatArray, T_nominal_part: RigidTransform | None
    ) -> tuple[int | None, str]:
        if len(weights) == 1:
            return 0, "no other features fit"
        if self.found.complete and weights[0] >= DECISIVE_ODDS * weights[1:].sum():
            return 0, f"{len(weights) - 1} other answers fit, all of them less probable by more than {DECISIVE_ODDS:g}"
        near = self._near(R, t, 0)
        if near.all() and self.found.complete:
            return None, self._twins()
        if T_nominal_part is not None and self.found.complete:
            return self._nearest(R, t, weights, T_nominal_part)
        return None, self._refusal(R, t, weights)

    def _near(self, R: FloatArray, t: FloatArray, k: int) -> BoolArray:
        """Tell which answers put all taught features at the same place as answer k, within the tolerance."""
        p = self.places.p[self.found.rows[k]]
        moved = np.einsum("aij,fj->afi", R, p) + t[:, None]
        return np.asarray(np.linalg.norm(moved - moved[k], axis=2).max(axis=1) <= self._tolerance_mm)

    def _nearest(
        self, R: FloatArray, t: FloatArray, weights: FloatArray, nominal: RigidTransform
    ) -> tuple[int | None, str]:
        moved = np.einsum("aij,fj->afi", R, self.places.p) + t[:, None]
        away = np.sqrt(np.mean(np.sum((moved - nominal.apply(self.places.p)) ** 2, axis=2), axis=1))
        k = int(np.argmin(away))
        same = np.flatnonzero(self._near(R, t, k))
        best = int(same[np.argmax(weights[same])])
        rivals = weights[same].sum() - weights[best]
        others = np.setdiff1d(np.arange(len(away)), same)
        second = float(away[others].min(initial=np.inf))
        if second - away[k] <= self._tolerance_mm:
            return None, (
                f"the nominal pose does not tell: two answers are {away[k]:.4g} and {second:.4g} mm from it; "
                + self._refusal(R, t, weights)
            )
        if rivals * DECISIVE_ODDS > weights[best]:
            return None, self._twins()
        rest = (
            f"{away[k]:.4g} mm from it" if math.isinf(second) else f"{away[k]:.4g} mm from it, the next {second:.4g} mm"
        )
        return best, f"of {len(away)} answers the nearest to the nominal pose ({rest})"

    def _twins(self) -> str:
        """Say which points may be one of several features that lie close together."""
        unclear = []
        for column, point in enumerate(self.points):
            rows = np.unique(self.found.rows[:, column])
            if len(rows) > 1:
                unclear.append(f"{point} may be {' or '.join(self.places.names[r] for r in rows[:4])}")
        return (
            f"the place of the part is known, but not which of close features was touched: {'; '.join(unclear[:4])}; "
            "write the name into the column feature, or state a smaller teaching error"
        )

    def _refusal(self, R: FloatArray, t: FloatArray, weights: FloatArray) -> str:
        """Say why it cannot be told, and what would settle it."""
        count = f"{len(weights)}" if self.found.complete else f"more than {MOST_ANSWERS}"
        said = [f"ambiguous: {count} answers fit the taught points within {self.sigma_mm:g} mm per axis"]
        tree = near_tree(self.places.p)
        top = slice(0, COMPARED_ANSWERS)
        alike, motions = self._alike(tree, R[top], t[top])
        if motions:
            exact = all(motion.is_symmetry(self.places.p, tree, within_mm=EXACT_MM) for motion in motions)
            words = " and ".join(dict.fromkeys(motion.in_words() for motion in motions[:3]))
            said.append(f"the part looks {'' if exact else 'nearly '}the same after {words}")
            said.append("give the nominal pose, or write the feature's name of one point that this moves")
        if not alike.all():
            tried = self.places.easy_to_touch(MOST_TRIED)
            share = weights[top] / weights[top].sum()
            p = self.places.p[tried]
            best = best_next_point(p, tree, R[top], t[top], share, alike=alike, tolerance_mm=self._tolerance_mm)
            name = self.places.names[tried[best.row]]
            settles = best.others_left < LEFT_OVER
            what = ("would settle the rest" if motions else "would settle it") if settles else "would tell most"
            said.append(f"teach one more: {name} {what}")
        return "; ".join(said)

    def _alike(self, tree: cKDTree, R: FloatArray, t: FloatArray) -> tuple[BoolArray, list[PartMotion]]:
        """Tell which answers a symmetry of the part, or nothing, sets apart; and the symmetries of the best one."""
        rows, p = self.found.rows, self.places.p
        alike = np.array([self._near(R, t, k) for k in range(len(R))])
        motions = []
        for i, j in zip(*np.nonzero(~alike), strict=True):
            motion = PartMotion.between(p, rows[i], rows[j])
            if motion.is_symmetry(p, tree, within_mm=self._tolerance_mm):
                alike[i, j] = True
                motions += [motion] if i == 0 else []
        return alike, motions
