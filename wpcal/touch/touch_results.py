"""From what a controller stored to taught touches: each result is paired with its search by name, and checked."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.errors import FormatError
from wpcal.core.issue import Issue
from wpcal.core.tangent import log_rotation
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed, short
from wpcal.taught.kinds import KINDS, TouchKind
from wpcal.taught.table import TaughtPoints
from wpcal.touch.searches import (
    Contact,
    Outcome,
    Search,
    SearchKind,
    SearchResult,
    SearchResults,
    TouchPlan,
    TouchSetup,
)

BEYOND_MM = 2.0
"""A stored place may lie this far before the start or behind the end of its stroke: the robot brakes, and rounds."""
BESIDE_MM = 1.5
"""A stored place may lie so far from the line of its stroke: robots keep lines to some tenths of a millimetre."""
SAME_FRAME_MM = 0.05
SAME_FRAME_RAD = np.radians(0.05)
"""Frames of the program and of the plan agree within this: controllers print three or four decimals."""
SAME_POSTURE_RAD = np.radians(2.0)
"""The tool keeps its orientation during a search. A larger difference is another tool, or another program."""
TOUCH_LEFT_OUT = "touch-left-out"
STICK_OUT = "stick-out"
FREEDOMS = 6
NUMBERS = {"edge": 2, "point": 3}  #: How many numbers a touch gives that is not on a face.
MOST_STICK_OUT_MM = 20.0
"""A post that is found further along the wire is not the post, or the tool centre point is wrong."""
MOST_SHARED = 0.99
"""Share of the variance of a search that an error which all searches share can make up: each has errors of its own."""
REASONS = {
    Outcome.MISSED: "missed: the end of its stroke was reached without contact",
    Outcome.NOT_RUN: "was not run",
    Outcome.ACTIVE_AT_START: "was not made: the touch signal was already on at its start",
}


@dataclass(frozen=True, slots=True, eq=False)
class SilentRows:
    """Searches on the part that ran and found nothing."""

    ends: TaughtPoints  #: Rows with the ends of their strokes as places.
    starts: FloatArray  #: shape (n, 3). In `base`, mm.
    was_active: BoolArray  #: shape (n,). The touch signal was on at the start.


@dataclass(frozen=True, slots=True, eq=False)
class PairedTouches:
    """The touches of a run, ready to be fitted."""

    taught: TaughtPoints  #: One row per search that found the part.
    left_out: tuple[tuple[str, Outcome], ...]  #: Searches that found nothing.
    #: Error of the stick-out that touches on posts show: positive if the wire is longer than planned.
    stick_out_mm: float | None
    tool: str  #: Of the program.
    issues: tuple[Issue, ...]  #: What a person should know.
    silent: SilentRows | None = None  #: Searches that found nothing and may test the fit.


def pair_results(plan: TouchPlan, results: SearchResults, setup: TouchSetup | None = None) -> PairedTouches:
    """Pair the results of a run with the searches of its plan.

    Places are corrected by latency × speed of the touch setup, against the direction of the search. If posts were
    touched with the end of the wire, the mean error of the stick-out that they show corrects all touches along the
    wire.

    Raises `FormatError` when the results are those of another plan, frame or tool, a place is outside of its stroke, or
    no search on the part found anything.
    """
    cell = setup or TouchSetup()
    _require_same_plan(plan, results)
    by_name = {result.name.upper(): result for result in results.results}
    pairs = [(search, by_name[search.name.upper()]) for search in plan.searches]
    left_out = tuple((search.name, result.outcome) for search, result in pairs if result.p is None)
    found = [(search, result) for search, result in pairs if result.p is not None]
    _require_postures(plan, found, results.path)
    late = cell.latency_s * cell.search_speed_mm_s
    T_base_stored = plan.T_base_part if results.T_base_part is None else results.T_base_part
    places = [_place(plan, search, result, T_base_stored) - late * search.direction for search, result in found]
    outside = [text for (search, _), p in zip(found, places, strict=True) if (text := _outside(search, p))]
    if outside:
        raise FormatError(f"places outside of their strokes: {'; '.join(outside)}", path=results.path)
    searches = [search for search, _ in found]
    stick_out = _stick_out(plan, searches, places, results.path)
    rows = [k for k, search in enumerate(searches) if search.kind is SearchKind.PART]
    if not rows:
        raise FormatError(f"no search on the part found anything: {_told(left_out)}", path=results.path)
    taught = _taught(plan, [searches[k] for k in rows], [places[k] for k in rows], stick_out, cell, results.path)
    issues = [Issue(TOUCH_LEFT_OUT, f"left out: {_told(left_out)}", tuple(n for n, _ in left_out))] if left_out else []
    if stick_out is not None:
        longer = "longer" if stick_out > 0 else "shorter"
        message = f"the post shows that the wire is {abs(stick_out):.2f} mm {longer} than planned; this is corrected"
        issues.append(Issue(STICK_OUT, message))
    silent = _silent(plan, [(search, result) for search, result in pairs if result.p is None], results.path)
    return PairedTouches(taught, left_out, stick_out, results.tool, tuple(issues), silent)


def require_enough(plan: TouchPlan, paired: PairedTouches) -> None:
    """Refuse a run that left out so many searches that the others cannot hold the part.

    Raises `FormatError` that names what was left out.
    """
    used = set(paired.taught.names)
    numbers = sum(NUMBERS.get(search.target, 1) for search in plan.searches if search.name in used)
    if paired.left_out and numbers < FREEDOMS:
        raise FormatError(
            f"{_told(paired.left_out)}. The {len(used)} others cannot hold the part: a place has six freedoms, and a "
            "touch on a face takes one",
            path=paired.taught.path,
        )


def _require_same_plan(plan: TouchPlan, results: SearchResults) -> None:
    path = results.path
    if all(result.outcome is Outcome.NOT_RUN for result in results.results):
        raise FormatError("holds no results: none of its searches was run", path=path)
    if results.fingerprint != plan.fingerprint:
        was = f"of the plan {results.fingerprint}" if results.fingerprint else "of no plan"
        raise FormatError(
            f"holds results {was}, and these touches are the plan {plan.fingerprint}: give the touches.json from which "
            "the program was written, or write and run the program again",
            path=path,
        )
    planned, stored = ({each.name.upper() for each in rows} for rows in (plan.searches, results.results))
    if planned != stored or results.count not in (None, len(planned)):
        count = len(stored) if results.count is None else results.count
        odd = listed(sorted(planned ^ stored))
        raise FormatError(
            f"holds {count} searches, and the plan has {len(planned)}{f'; they differ in {odd}' if odd else ''}",
            path=path,
        )
    T = results.T_base_part
    if T is None:
        return
    apart = float(np.linalg.norm(T.t_mm - plan.T_base_part.t_mm))
    turned = _turn(T.R, plan.T_base_part.R)
    if apart > SAME_FRAME_MM or turned > SAME_FRAME_RAD:
        raise FormatError(
            f"the work object (user frame) of the results is {apart:.2f} mm and {np.degrees(turned):.2f} degrees from "
            "the place of the part in the plan: it was changed after the program was written",
            path=path,
        )


def _require_postures(plan: TouchPlan, found: Sequence[tuple[Search, SearchResult]], path: str) -> None:
    turned = {search.name: _turn(result.R, search.R_part_tool) for search, result in found if result.R is not None}
    wrong = [f"{name} ({np.degrees(angle):.3g} degrees)" for name, angle in turned.items() if angle > SAME_POSTURE_RAD]
    if wrong:
        raise FormatError(
            f"the tool was turned from its planned posture at {', '.join(wrong)}: another tool or frame was active",
            path=path,
        )


def _turn(one: FloatArray, other: FloatArray) -> float:
    return float(np.linalg.norm(log_rotation(one @ other.T)))


def _place(plan: TouchPlan, search: Search, result: SearchResult, T_base_stored: RigidTransform) -> FloatArray:
    """Return the tip of the wire at a stored place in the frame of its search: `part`, of a post `base`.

    Programs have the frame with the digits of their language, and store places relative to that.
    """
    p_base = T_base_stored.apply(np.asarray(result.p) + plan.ahead(search))
    return np.asarray(p_base if search.kind is SearchKind.POST else plan.T_base_part.inverse().apply(p_base))


def _outside(search: Search, p: FloatArray) -> str:
    """Say how a place is outside of its stroke; empty if it is not."""
    off = p - search.start
    along = float(off @ search.direction)
    beside = float(np.linalg.norm(off - along * search.direction))
    if beside > BESIDE_MM:
        return f"{search.name} is {short(beside)} mm beside it"
    if along < -BEYOND_MM:
        return f"{search.name} is {short(-along)} mm before its start"
    if along > search.stroke_mm + BEYOND_MM:
        return f"{search.name} is {short(along - search.stroke_mm)} mm behind its end"
    return ""


def _wire(plan: TouchPlan, search: Search) -> FloatArray:
    """Unit vector that leaves the tip of the wire, in the frame of the search."""
    wire = search.R_part_tool[:, 2]
    return np.asarray(plan.T_base_part.R @ wire) if search.kind is SearchKind.POST else wire


def _stick_out(plan: TouchPlan, searches: Sequence[Search], places: Sequence[FloatArray], path: str) -> float | None:
    """Mean error of the stick-out at the posts, mm: how much earlier than planned the wire met them."""
    errors = [
        float((search.planned - p) @ _wire(plan, search))
        for search, p in zip(searches, places, strict=True)
        if search.kind is SearchKind.POST and search.contact is Contact.END
    ]
    if not errors:
        return None
    mean = float(np.mean(errors))
    if abs(mean) > MOST_STICK_OUT_MM:
        raise FormatError(f"the post was found {short(abs(mean))} mm from its place along the wire", path=path)
    return mean


def _taught(
    plan: TouchPlan,
    searches: Sequence[Search],
    places: Sequence[FloatArray],
    stick_out: float | None,
    setup: TouchSetup,
    path: str,
) -> TaughtPoints:
    R = plan.T_base_part.R
    wires = np.array([_wire(plan, search) for search in searches])
    p_part = np.array(places) + (0.0 if stick_out is None else stick_out) * wires
    covariances = np.array([search.covariance_part for search in searches])
    if stick_out is not None:
        covariances = _known_stick_out(covariances, wires, setup)
    n = len(searches)
    return TaughtPoints(
        tuple(search.name for search in searches),
        plan.T_base_part.apply(p_part),
        tuple(search.feature for search in searches),
        np.array([search.contact_part for search in searches]),
        ("yes",) * n,
        path,
        (0,) * n,
        covariances=R @ covariances @ R.T,
        kinds=tuple(KINDS.get(search.target, TouchKind.SURFACE) for search in searches),
        radius_mm=np.array([search.radius_mm for search in searches]),
        R_base_tool=R @ np.array([search.R_part_tool for search in searches]),
        normal_part=np.array([search.normal_part for search in searches]),
        shared=R @ _shared(covariances, wires, searches, stick_out, setup),
    )


def _shared(
    covariances: FloatArray, wires: FloatArray, searches: Sequence[Search], stick_out: float | None, setup: TouchSetup
) -> FloatArray:
    """Return what each place sees of the errors of the stick-out and of the latency, shape (n, 3, 2), mm."""
    directions = np.array([search.direction for search in searches])
    sticks = setup.stick_out_sigma_mm if stick_out is None else setup.repeatability_mm
    own, found = covariances, []
    for along, sigma in ((wires, sticks), (directions, setup.latency_sigma_s * setup.search_speed_mm_s)):
        most = 1.0 / np.einsum("ni,nij,nj->n", along, np.linalg.inv(own), along)
        size = np.minimum(sigma, np.sqrt(MOST_SHARED * most))
        found.append(size[:, None] * along)
        own = own - found[-1][:, :, None] * found[-1][:, None, :]
    return np.stack(found, axis=2)


def _silent(plan: TouchPlan, pairs: Sequence[tuple[Search, SearchResult]], path: str) -> SilentRows | None:
    ran = [each for each in pairs if each[0].kind is SearchKind.PART and each[1].outcome is not Outcome.NOT_RUN]
    if not ran:
        return None
    searches = [search for search, _ in ran]
    ends = _taught(plan, searches, [search.end for search in searches], None, TouchSetup(), path)
    starts = plan.T_base_part.apply(np.array([search.start for search in searches]))
    return SilentRows(ends, starts, np.array([result.outcome is Outcome.ACTIVE_AT_START for _, result in ran]))


def _known_stick_out(covariances: FloatArray, wires: FloatArray, setup: TouchSetup) -> FloatArray:
    """Replace the variance of the stick-out along the wire by that of the touch on the post."""
    less = setup.stick_out_sigma_mm**2 - setup.repeatability_mm**2
    along = np.einsum("ni,nij,nj->n", wires, covariances, wires)
    taken = np.clip(np.minimum(less, along - setup.repeatability_mm**2), 0.0, None)
    return np.asarray(covariances - taken[:, None, None] * wires[:, :, None] * wires[:, None, :])


def nominal_place(plan: TouchPlan) -> RigidTransform:
    """Return ``T_nominal_part``: the place of the part in the plan."""
    return plan.T_base_part.relabelled(target="nominal", source="part")


def _told(left_out: Sequence[tuple[str, Outcome]]) -> str:
    return "; ".join(f"{name} {REASONS[outcome]}" for name, outcome in left_out)
