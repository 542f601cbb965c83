"""`plan_touches`: which searches a robot makes to locate a part, and how it moves between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.material import ExactMaterial, Material
from wpcal.calibrate.trust.held_motions import free_words
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import ErrorCode, GeometryError
from wpcal.core.progress import Progress, no_progress
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import counted
from wpcal.seam.seam import Seam
from wpcal.touch.moved_advice import MovedAdvice
from wpcal.touch.plan.candidates import Candidates, find_searches, thinned, too_small_words
from wpcal.touch.plan.choose import TouchDesign, advise_searches, fewest_set, joint_error_of
from wpcal.touch.plan.contacts import face_words
from wpcal.touch.plan.displaced import DisplacedPart
from wpcal.touch.plan.free import Strokes, tool_axes
from wpcal.touch.plan.options import TouchOptions
from wpcal.touch.plan.order import Air, order_searches
from wpcal.touch.plan.part import PartPlace, TouchPart
from wpcal.touch.plan.patterns import choose_touches
from wpcal.touch.plan.searches_of import post_search, search_of, stick_out_sigma_mm
from wpcal.touch.plan.stages import first_stage
from wpcal.touch.searches import FirstStage, PlannedBody, SeamPrediction, Search, TouchPlan


class SearchingArm(Protocol):
    """The arm that makes the searches."""

    def turned(self, strokes: Strokes) -> tuple[Strokes, tuple[str, ...]]:
        """Turn the tool about the wire so that the arm reaches; leave out what it cannot reach, and say so."""

    def with_joints(self, plan: TouchPlan, air: Air) -> TouchPlan:
        """Return the plan with the joints of the arm."""


def plan_touches(
    part: TouchPart,
    *,
    options: TouchOptions,
    T_base_part: RigidTransform | None = None,
    bodies: Sequence[Material] = (),
    reach: SearchingArm | None = None,
    progress: Progress = no_progress,
) -> TouchPlan:
    """Choose searches with the least predicted 95 % error of the seams, order them, and find the ways between them.

    Raises `GeometryError` when the part has no seam, no face can be touched, or the touches leave a motion free. The
    message names it and what would help.
    Raises `InputError` when the tool centre point is not on the torch.
    """
    if not any(len(seam.frames) for seam in part.seams):
        raise GeometryError(
            "the part has no seam to locate it for; `wpcal seams` lists the candidates", code=ErrorCode.NO_SEAM
        )
    T = T_base_part or RigidTransform.identity(target="base", source="part")
    up = T.R.T @ (np.array(options.up_base) / np.linalg.norm(options.up_base))
    place = PartPlace.of(part.trimmed, up, part.tacked)
    materials = [part.material or ExactMaterial(part.graph, part.trimmed), *bodies]
    displaced = _displaced(part, materials[0], place, options)
    found = find_searches(part.graph, part.trimmed, materials, place, options, progress)
    notes: tuple[str, ...] = ()
    strokes = found.strokes.select(displaced.lets_start(found.strokes, options.torch, options.wire_mm))
    if len(strokes) == 0:
        raise GeometryError(
            "at the start of every search the torch or the wire would meet the part where it may stand; a smaller "
            "--uncertainty-mm or --uncertainty-deg, a slimmer --torch or a longer wire would help"
        )
    if reach is not None:
        progress(f"solving the joints of {len(strokes)} searches")
        strokes, notes = reach.turned(strokes)
    strokes = thinned(strokes, place)
    design = design_of(part, strokes, place, options)
    progress(f"choosing touches from {len(strokes)}")
    first = None
    if why := _why_free(part.graph, design, found, place, options):
        rows, first = first_stage(part.graph, strokes, place, options.nominal)
        is_second = part.tacked is not None or options.nominal.left is not None
        predicted = None if is_second else _second_stage(part, options, first, T_base_part, bodies, reach)
        if predicted is None:
            raise GeometryError(why)
        notes = (*notes, "the first of two stages: it does not hold the part; predicted errors are of the second")
    else:
        rows, predicted = _chosen(part, strokes, design, place, options)
    progress("ordering the searches and finding the ways between them")
    strokes = strokes.select(rows)
    clear = float(strokes.contacts.normal_mm.max())
    air = Air(materials, options.torch, options.wire_mm, up, found.safe_mm, clear, displaced)
    nowhere = np.empty((0, 3))  # an arm orders the searches by its joints, and finds its ways
    order = [(row, nowhere) for row in range(len(strokes))] if reach is not None else _in_order(strokes, air)
    searches = tuple(
        search_of(part, strokes, row, f"T{number}", via, options) for number, (row, via) in enumerate(order, 1)
    )
    tacked: tuple[PlannedBody, ...] = ()
    if isinstance(predicted, MovedAdvice):
        searches, tacked = _for_bodies(searches, predicted, [row for row, _ in order])
    if options.post_base is not None and first is None:
        searches = (post_search(options, T, up, found.safe_mm), *searches)
    plan = TouchPlan(
        part.name,
        searches,
        T,
        options.wire_mm,
        options.torch.wire_mm,
        predicted=predicted,
        notes=(*notes, *_notes(part.graph, found, strokes, options, T_base_part)),
        bodies=tacked,
        first_stage=first,
        standoff_mm=options.standoff_mm,
    )
    return plan if reach is None else reach.with_joints(plan, air)


def design_of(part: TouchPart, strokes: Strokes, place: PartPlace, options: TouchOptions) -> TouchDesign:
    """Return what sets of searches on a part are judged by."""
    contacts = strokes.contacts
    design = TouchDesign.of(
        contacts.p - place.centre,
        contacts.normal,
        contacts.wire,
        options.setup,
        np.concatenate([seam.frames.p for seam in part.seams]) - place.centre,
        stick_out_sigma_mm=stick_out_sigma_mm(options),
    )
    return replace(design, robot=options.robot)


def _second_stage(
    part: TouchPart,
    options: TouchOptions,
    first: FirstStage,
    T_base_part: RigidTransform | None,
    bodies: Sequence[Material],
    reach: SearchingArm | None,
) -> SeamPrediction | None:
    """Return what searches promise that are planned after a first stage; None if none hold the part then either."""
    left = replace(options, nominal=replace(options.nominal, left=first.covariance))
    try:
        return plan_touches(part, options=left, T_base_part=T_base_part, bodies=bodies, reach=reach).predicted
    except GeometryError:
        return None


def _why_free(graph: BrepGraph, design: TouchDesign, found: Candidates, place: PartPlace, options: TouchOptions) -> str:
    """Say which motion of the part no search sees, and what would help; empty if all are seen."""
    free, count = design.free_motions(), options.count(1 if place.tacked is None else len(place.tacked.bodies))
    if len(free) == 0 and len(design) >= count:
        return ""
    if len(free) == 0:
        raise GeometryError(
            f"only {len(design)} searches are possible, and {count} are asked for; ask for fewer with "
            "--touches, or give a smaller --uncertainty-mm"
        )
    words = free_words(free, place.centre, design.length_mm, ())
    help_ = "touch a further face, or fix it in the fixture"
    if len(found.small):
        small = found.small
        others = TouchDesign.of(
            small.p - place.centre, small.normal, small.wire, options.setup, np.zeros((1, 3)), stick_out_sigma_mm=1.0
        )
        scale = np.repeat([design.length_mm, 1.0], 3)
        holds = np.abs(others.rows / scale @ free[0])
        if holds.max() > 0.1:
            rows = np.flatnonzero(holds > 0.5 * holds.max())
            help_ = too_small_words(graph, small.select(rows), options)
    return f"the touches that are possible leave the part free: it {words}; {help_}"


def _displaced(part: TouchPart, material: Material, place: PartPlace, options: TouchOptions) -> DisplacedPart:
    options.torch.require_on_it(options.standoff_mm)
    if part.tacked is None:
        found = DisplacedPart.of(material, place.centre, options.nominal)
    else:
        found = DisplacedPart.of_bodies(material, part.graph, place, part.tacked, options.nominal)
    return replace(found, standoff_mm=options.standoff_mm)


def _chosen(
    part: TouchPart, strokes: Strokes, design: TouchDesign, place: PartPlace, options: TouchOptions
) -> tuple[IntArray, SeamPrediction]:
    """Return the rows of the strokes that are made, and what they promise."""
    if part.tacked is not None:
        advice = advise_searches(part.graph, strokes, design, part.tacked, options)
        return np.array([touch.index for touch in advice.touches]), advice
    points, why = np.concatenate([seam.frames.p for seam in part.seams]) - place.centre, ""
    if options.tolerance_mm is None:
        rows = choose_touches(design, strokes.contacts.p, strokes.contacts.normal, options)
    else:
        rows, why = fewest_set(design, points, options, np.random.default_rng(options.seed))
    return rows, replace(_prediction(part.seams, design, rows, place.centre), why_not=why)


def _for_bodies(
    searches: Sequence[Search], advice: MovedAdvice, rows: Sequence[int]
) -> tuple[tuple[Search, ...], tuple[PlannedBody, ...]]:
    """Return searches with the bodies they touch and the seams they serve, and the bodies that may move."""
    touches, bodies = [advice.touches[row] for row in rows], advice.model.bodies
    serving = tuple(replace(s, body=t.body, serves=t) for s, t in zip(searches, touches, strict=True))
    return serving, tuple(PlannedBody(n, t.mm, t.mrad) for n, t in zip(bodies.names, bodies.tolerances, strict=True))


def _prediction(seams: Sequence[Seam], design: TouchDesign, chosen: IntArray, centre: FloatArray) -> SeamPrediction:
    places = [(seam.name, seam.frames.p - centre) for seam in seams if len(seam.frames)]
    budget = design.budget(chosen)
    by_seam = tuple((name, float(budget.error_95_mm(p).max())) for name, p in places)
    worst = max(by_seam, key=lambda each: each[1])
    every = np.concatenate([seam.frames.p for seam in seams]) - centre
    return SeamPrediction(worst[1], worst[0], by_seam, joint_error_of(design, chosen, every))


def _in_order(strokes: Strokes, air: Air) -> list[tuple[int, FloatArray]]:
    """Return the rows of the strokes in the shortest order, each with the points on the way to it."""
    R = tool_axes(strokes)
    ends = np.stack([strokes.approach, strokes.at(strokes.before_mm)], axis=1)
    order, ways = order_searches(strokes.approach, R, air)
    found = list[tuple[int, FloatArray]]()
    for number, row in enumerate(order.tolist()):
        via: FloatArray | None = air.over(ends[row, 0], ends[row, 0])[:1]
        if number:
            before = int(order[number - 1])
            via = ways.get((before, row))
            via = None if via is None else air.safe_way(via, ends[before], R[before], ends[row], R[row])
        if via is None:
            raise GeometryError(
                f"the torch finds no way from the touch at {_words(strokes.contacts.p[before])} to that at "
                f"{_words(strokes.contacts.p[row])} that is free wherever the part may stand; a slimmer --torch or a "
                "smaller --uncertainty-mm or --uncertainty-deg would help",
                code=ErrorCode.NO_FREE_WAY,
            )
        found.append((row, via))
    return found


def _words(p: FloatArray) -> str:
    return f"({' '.join(f'{round(float(v), 1) + 0.0:g}' for v in p)})"


def _notes(
    graph: BrepGraph, found: Candidates, strokes: Strokes, options: TouchOptions, T_base_part: RigidTransform | None
) -> tuple[str, ...]:
    notes, left_mm = list[str](), float(strokes.contacts.normal_mm.max())
    if options.nominal.left is not None:
        notes.append(f"the second of two stages: strokes allow for {left_mm:.1f} mm that the first leaves unknown")
    small = list(dict.fromkeys(found.small.face.tolist()))
    if small:
        which = face_words(graph, found.small, small[0])
        notes.append(f"{counted(len(small), 'face')} too small for the displacement of the part, such as {which}")
    if T_base_part is None:
        notes.append("no place of the part (--nominal, --cell): programs have it at the origin of the base, z up")
    return tuple(notes)
