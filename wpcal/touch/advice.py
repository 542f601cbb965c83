"""The features from which a set is chosen: the easiest to touch that leave a choice."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import islice
from typing import Any

import numpy as np

from wpcal.calibrate.errors.budget import farthest_ends
from wpcal.calibrate.errors.linear_fit import budget_of_design
from wpcal.calibrate.errors.prediction import LEAST_ERROR_MM, Sigma, TeachingError
from wpcal.calibrate.errors.robot_field import USUAL_SIGMA_MM, RobotField
from wpcal.calibrate.trust.criteria import Criterion
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.csv_text import csv_text
from wpcal.core.errors import ErrorCode, GeometryError, InputError
from wpcal.core.progress import Progress, no_progress
from wpcal.core.wording import listed, short
from wpcal.seam.seam import Seam
from wpcal.taught.features.reference import FeatureKind, ReferenceFeature
from wpcal.taught.features.touchable import Ease, Touchable
from wpcal.taught.match.places import Places
from wpcal.taught.match.search import squares_limit
from wpcal.touch.design import Design, farthest_rows, least_swap

MOST_PLACES = 400
"""Of larger parts this many features are judged, far from one another: the best sets lie at the outside."""
SAME_HEIGHT_MM = 0.01  #: The corners of a flat foot are at one height but for round-off.
ON_A_LINE = 1e-3
"""Points whose second spread is a smaller share of the first leave the rotation about their line to chance."""


def easiest_places(candidates: Sequence[Touchable], have: Sequence[ReferenceFeature], points: int) -> Places:
    """Take the easiest features that leave a choice: harder ones only if these are too few or on one line.

    Raises `GeometryError` when all features are too few or on one line.
    """
    for ease in Ease:
        names = {feature.name for feature in have}
        own = (each.feature for each in candidates if each.ease <= ease and each.feature.name not in names)
        places = Places.of([*have, *own])
        if len(places.p) >= points and fills_a_plane(places.p):
            return places if len(places.p) <= MOST_PLACES else _farthest(places, have)
    raise GeometryError(
        f"{points} points are asked for, and the part has {len(places.p)} places to touch that are not on one line"
    )


def fills_a_plane(p: FloatArray) -> bool:
    """Tell whether points, shape (n, 3), mm, fix a rotation."""
    if len(p) < 3:
        return False
    spread = np.linalg.svd(p - p.mean(axis=0), compute_uv=False)
    return bool(spread[1] > ON_A_LINE * spread[0])


def _farthest(places: Places, have: Sequence[ReferenceFeature]) -> Places:
    kept = {places.names[k] for k in farthest_rows(places.p, MOST_PLACES)}
    kept |= {places.names[places.holding(feature.name)] for feature in have}
    return Places.of([feature for group in places.features if group[0].name in kept for feature in group])


USUAL_COUNTS = (3, 4, 5, 6)
"""Numbers of points that are compared: three are the least, and people rarely touch more than six."""
MOST_SEAM_POINTS = 48
"""Seam points that the search looks at, far from one another; the figures reported are those over all of them."""
FINALISTS = 24
"""Best sets of the search whose error is then predicted for the criterion asked for, over all seam points."""
CLEAR_SWAP = 4.0
"""An exchange of names is seen in the residuals if it leaves this many times the sum of squares of teaching errors."""
FEW_SEAM_POINTS = 1024  #: Along more points the error is first predicted at those farthest out, and then for few sets.
DRAWN = 1.03  #: Errors that are drawn are good to this factor.
ROUND_OFF = 1e-4  #: The search looks quantiles up in a table, which is far more exact than this share.
SWAP_PRICE = 1.25
"""A set whose names can be exchanged unseen is advised only if every other set has an error larger by this factor. On a
frame whose only free corners are those of a box, the others have 1.6 times the error."""
ADVICE_SCHEMA = "wpcal/advice/1"


@dataclass(frozen=True, slots=True, eq=False)
class AdvisedSet:
    """Features to teach together."""

    features: tuple[ReferenceFeature, ...]
    #: No point of all seams is off by more, with 95 % probability: the figure that the verdict compares.
    error_95_mm: float
    seam: str  #: The seam with the largest error of its own.
    swap_rms_mm: float  #: Root mean square residual that the most hidden exchange of names would leave, mm.
    swap: tuple[str, ...]  #: The features that it exchanges.
    is_clear: bool  #: Whether that residual is larger than the teaching error can leave.

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the features."""
        return tuple(feature.name for feature in self.features)

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {
            "features": list(self.names),
            "error_95_mm": self.error_95_mm,
            "seam": self.seam,
            "swap_rms_mm": self.swap_rms_mm,
            "swap": list(self.swap),
            "swap_is_seen": self.is_clear,
        }


@dataclass(frozen=True, slots=True, eq=False)
class Advice:
    """What to teach."""

    chosen: AdvisedSet  #: With as many points as asked for.
    by_count: tuple[AdvisedSet, ...]  #: The best set of each number of points.
    with_next: AdvisedSet | None  #: The chosen set and the single best point to add to it.
    next_point: ReferenceFeature | None  #: That point.
    notes: tuple[str, ...]  #: What to watch when these features are touched.
    sigma_mm: float
    criterion: Criterion

    def template_rows(self) -> list[tuple[str, str]]:
        """Return name and place of each point, for `template_csv`."""
        return [(feature.name, where_it_is(feature)) for feature in self.chosen.features]

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {
            "schema": ADVICE_SCHEMA,
            "sigma_mm": self.sigma_mm,
            "criterion": self.criterion.value,
            "chosen": self.chosen.to_record(),
            "points": [{**f.to_record(), "where": where_it_is(f)} for f in self.chosen.features],
            "by_count": [{"points": len(s.features), **s.to_record()} for s in self.by_count],
            "next_point": None if self.next_point is None else self.next_point.name,
            "with_next": None if self.with_next is None else self.with_next.to_record(),
            "notes": list(self.notes),
        }


def advise(
    candidates: Sequence[Touchable],
    seams: Sequence[Seam],
    *,
    points: int = 4,
    sigma_mm: float = USUAL_SIGMA_MM,
    robot: RobotField | None = None,
    criterion: Criterion = Criterion.LEAST_SQUARES,
    have: Sequence[ReferenceFeature] = (),
    seed: int = 0,
    progress: Progress | None = None,
) -> Advice:
    """Choose the features to teach so that the largest predicted error along the seams is smallest.

    Raises `InputError` when `points` is below 3 or not above the number in `have`, or `sigma_mm` is not a positive
    length.
    Raises `GeometryError` when there is no seam, or the candidates are too few or all on one line.

    The search is by the closed-form error of least squares; the last choice among the `FINALISTS` best sets, and every
    figure reported, by the criterion asked for.
    """
    _require_usable(points, sigma_mm, have, criterion)
    require_seams(seams)
    teaching = TeachingError(sigma_mm=sigma_mm, robot=robot)
    choice = _Choice.over(easiest_places(candidates, have, points), seams, teaching, criterion, seed)
    places = choice.places
    say = progress or no_progress
    held = tuple(places.holding(feature.name) for feature in have)
    counts = sorted({points, *(n for n in USUAL_COUNTS if n >= max(3, len(held)))} & set(range(len(places.p) + 1)))
    by_count = {n: choice.best(n, held, say) for n in counts}
    chosen = by_count[points]
    with_next, next_point = None, None
    if points < len(places.p):
        rows = tuple(places.holding(name) for name in chosen.names)
        with_next = choice.best(points + 1, rows, say)
        next_point = next(f for f in with_next.features if f.name not in chosen.names)
    eases = {item.feature.name: item.ease for item in candidates}
    lowest_mm = min(item.feature.p_mm[2] for item in candidates)
    notes = (*_ease_notes(chosen, eases), *_table_notes(chosen, lowest_mm), *_swap_notes(chosen))
    return Advice(chosen, tuple(by_count.values()), with_next, next_point, notes, sigma_mm, criterion)


def advise_set(
    candidates: Sequence[Touchable],
    seams: Sequence[Seam],
    *,
    points: int,
    shares: Sequence[float] = (1.0,),
    sigma_mm: float,
    robot: RobotField | None = None,
    criterion: Criterion = Criterion.LEAST_SQUARES,
    have: Sequence[ReferenceFeature] = (),
    seed: int = 0,
) -> AdvisedSet:
    """Choose one set of `points` features, without comparing other numbers; parameters and errors as in `advise`.

    `shares`: Which share of the error that `have` leaves may be left with `points` features, with one more, and so on;
    the first number that reaches its share is taken, otherwise the last.
    Returns: Only `have` itself if no feature added to it makes the error smaller. That can happen with the minimax
    criterion and Gaussian errors.
    """
    _require_usable(points, sigma_mm, have, criterion)
    require_seams(seams)
    teaching = TeachingError(sigma_mm=sigma_mm, robot=robot)
    choice = _Choice.over(easiest_places(candidates, have, points), seams, teaching, criterion, seed)
    held = tuple(choice.places.holding(feature.name) for feature in have)
    if not fills_a_plane(choice.places.p[list(held)]):
        return choice.best(points, held, no_progress)
    found = now = choice.predicted(np.array([held]))
    for n, share in enumerate(shares[: len(choice.places.p) - points + 1], points):
        found = min(found, choice.best(n, held, no_progress), key=lambda each: each.error_95_mm)
        if found.error_95_mm <= share * now.error_95_mm:
            break
    return found


def require_seams(seams: Sequence[Seam]) -> None:
    """Refuse a part without a seam where the error counts. Raises `GeometryError` when no seam has a frame."""
    if not any(len(seam.frames) for seam in seams):
        raise GeometryError(
            "the part has no seam to advise for; `wpcal seams` lists the candidates. Or take the notches inside one "
            "solid as seams",
            code=ErrorCode.NO_SEAM,
        )


def where_it_is(feature: ReferenceFeature) -> str:
    """Say in words where a feature is: ``hole of 10 mm on base plate at (20 20 10)``."""
    place = " ".join(f"{round(v, 3) + 0.0:g}" for v in feature.p_mm)
    return f"{what_it_is(feature)} at ({place})"


def what_it_is(feature: ReferenceFeature) -> str:
    """Say in words what a feature is: ``hole of 10 mm on base plate``."""
    words = {FeatureKind.VERTEX: "corner", FeatureKind.EDGE_MIDPOINT: "middle of the edge"}
    kind = words.get(feature.kind, feature.kind.word.replace("_", " "))
    size = "" if feature.diameter_mm is None else f" of {feature.diameter_mm:g} mm"
    return f"{kind}{size}{f' on {feature.solid}' if feature.solid else ''}"


def template_csv(points: Sequence[tuple[str, str]]) -> str:
    """Return the file of taught points for `calibrate`, its coordinates to be filled in."""
    rows = [[name, "", "", "", "yes", where] for name, where in points]
    return csv_text([["name", "x_mm", "y_mm", "z_mm", "use", "where"], *rows])


@dataclass(frozen=True, slots=True, eq=False)
class _Choice:
    """The search over one part's features and seams."""

    places: Places
    design: Design
    seam_points: FloatArray
    outer: FloatArray  #: shape (k, 3). Those of them that are farthest out; all of them if they are few.
    seam_names: tuple[str, ...]
    teaching: TeachingError
    criterion: Criterion
    seed: int

    @classmethod
    def over(
        cls, places: Places, seams: Sequence[Seam], teaching: TeachingError, criterion: Criterion, seed: int
    ) -> _Choice:
        points = np.concatenate([seam.frames.p for seam in seams])
        names = tuple(seam.name for seam in seams for _ in range(len(seam.frames)))
        far = farthest_rows(points, MOST_SEAM_POINTS)
        outer = points if len(points) <= FEW_SEAM_POINTS else points[np.union1d(farthest_ends(points), far)]
        return cls(places, Design(places.p, points[far]), points, outer, names, teaching, criterion, seed)

    @property
    def sigma_mm(self) -> float:
        """Teaching error per axis."""
        return Sigma.expected(self.teaching.per_axis_mm).mm

    def best(self, n: int, held: tuple[int, ...], progress: Progress) -> AdvisedSet:
        """Return the best set of n points, preferably one whose names cannot be exchanged unseen."""
        rng = np.random.default_rng(self.seed)
        rows, errors = self.design.best_sets(n, held=held, rng=rng, progress=progress)
        if len(rows) == 0:
            raise GeometryError("the features to choose from lie on one line: no set of them fixes the part")
        affordable = np.flatnonzero(errors <= SWAP_PRICE * errors[0])
        most = self._clear_squares(n)  # below it an exchange of names is not seen in the residuals
        clear = islice((k for k in affordable.tolist() if least_swap(self.places.p[rows[k]])[0] >= most), FINALISTS)
        progress(f"predicting the error of the best sets of {n} points")
        if self.criterion is Criterion.MINIMAX:
            finalists = list(clear)
            return self.predicted(rows[finalists] if finalists else rows[:FINALISTS])
        bounds = (1.0 - ROUND_OFF) * self.sigma_mm * errors
        return self._least(rows, bounds, clear) or self.predicted(rows[:FINALISTS])

    def _least(self, rows: IntArray, bounds: FloatArray, finalists: Iterable[int]) -> AdvisedSet | None:
        """Return the set of least error by least squares.

        `rows`: shape (m, n).
        `bounds`: shape (m,). Ascending; no set has a smaller error along all seams than at the points by which the
        search judged it.
        """
        outer = {k: self._error(rows[k], self.outer) for k in finalists}
        best, least = len(rows), (0, math.inf)
        for k in sorted(outer, key=lambda k: outer[k][1]):
            if max(bounds[k], outer[k][1] / DRAWN) <= least[1]:
                error = outer[k] if self.outer is self.seam_points else self._error(rows[k], self.seam_points)
                best, least = (k, error) if (error[1], k) < (least[1], best) else (best, least)
        return self._advised(rows[best], *least) if outer else None

    def _error(self, row: IntArray, seam_points: FloatArray) -> tuple[int, float]:
        """Return the seam point with the largest error of its own, and the 95 % error of all together, mm."""
        with_minimax = self.criterion is Criterion.MINIMAX
        budget = budget_of_design(self.places.p[row], self.teaching, with_minimax=with_minimax, seed=self.seed)
        every = budget.joint_errors(seam_points)
        return every.row, every.error_95_mm

    def predicted(self, sets: IntArray) -> AdvisedSet:
        """Predict the errors of sets along all seams, and return the best; `sets` has the shape (m, n)."""
        errors = [self._error(each, self.seam_points) for each in sets]
        best = min(range(len(sets)), key=lambda row: errors[row][1])
        return self._advised(sets[best], *errors[best])

    def _advised(self, rows: IntArray, worst: int, error_mm: float) -> AdvisedSet:
        p = self.places.p[rows]
        squares, order = least_swap(p)
        features = tuple(self.places.features[row][0] for row in rows)
        swap = tuple(features[k].name for k, other in enumerate(order) if k != other)
        return AdvisedSet(
            features,
            error_mm,
            self.seam_names[worst],
            math.sqrt(squares / len(p)),
            swap,
            squares >= self._clear_squares(len(p)),
        )

    def _clear_squares(self, n: int) -> float:
        return CLEAR_SWAP * squares_limit(n, self.sigma_mm) if n > 2 else 0.0


def _require_usable(points: int, sigma_mm: float, have: Sequence[ReferenceFeature], criterion: Criterion) -> None:
    if points < 3:
        raise InputError(f"a fit needs at least 3 points, got {points}")
    if len(have) >= points:
        raise InputError(f"{len(have)} points are there already; ask for more than that, got {points}")
    if not LEAST_ERROR_MM <= sigma_mm < math.inf:
        raise InputError(f"the teaching error is a length of at least {LEAST_ERROR_MM:g} mm, got {sigma_mm} mm")
    if criterion not in (Criterion.MINIMAX, Criterion.LEAST_SQUARES):
        raise InputError(f"points are advised for minimax or least_squares, got {criterion.value}")


def _ease_notes(chosen: AdvisedSet, eases: dict[str, Ease]) -> list[str]:
    words = {
        Ease.ROUND: "nothing to touch at its centre: take several touches around it",
        Ease.HIDDEN: "in a notch, against another solid or behind one",
        Ease.VAGUE: "the middle of an edge has to be measured out",
    }
    found = [(name, eases.get(name, Ease.SHARP)) for name in chosen.names]
    return [f"{name}: {words[ease]}" for name, ease in found if ease in words]


def _table_notes(chosen: AdvisedSet, lowest_mm: float) -> list[str]:
    low = [feature.name for feature in chosen.features if feature.p_mm[2] < lowest_mm + SAME_HEIGHT_MM]
    if not low:
        return []
    return [f"{listed(low)}: lowest in z of the model; if the part lies on a table there: --exclude {','.join(low)}"]


def _swap_notes(chosen: AdvisedSet) -> list[str]:
    if chosen.is_clear:
        return []
    return [
        f"names exchanged among {', '.join(chosen.swap)} would leave an RMS of only {short(chosen.swap_rms_mm)} mm: "
        "the features are too symmetric to show the exchange; take care with the names"
    ]
