"""`plan_touches`: which searches a robot makes to locate a part, and how it moves between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.material import ExactMaterial, Material
from wpcal.calibrate.errors.prediction import error_95
from wpcal.calibrate.trust.held_motions import free_words
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import ErrorCode, GeometryError
from wpcal.core.progress import Progress, no_progress
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import counted
from wpcal.seam.seam import Seam
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
from wpcal.touch.searches import PlannedBody, SeamPrediction, Search, Served, TouchPlan
from wpcal.touch.weldment import Tacked


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

    Raises
    ------
    GeometryError
        When the part has no seam, no face can be touched, or the touches leave a motion free. The message names it and
        what would help.
    """
    if not any(len(seam.frames) for seam in part.seams):
        raise GeometryError(
            "the part has no seam to locate it for; `wpcal seams` lists the candidates", code=ErrorCode.NO_SEAM
        )
    T = T_base_part or RigidTransform.identity(target="base", source="part")
    up = T.R.T @ (np.array(options.up_base) / np.linalg.norm(options.up_base))
    place = PartPlace.of(part.trimmed, up, part.tacked)
    materials = [part.material or ExactMaterial(part.graph, part.trimmed), *bodies]
    found = find_searches(part.graph, part.trimmed, materials, place, options, progress)
    notes: tuple[str, ...] = ()
    displaced = _displaced(part, materials[0], place, options)
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
    _require_held(part.graph, design, found, place, options)
    progress(f"choosing touches from {len(strokes)}")
    made = _chosen(part, strokes, design, place, options)
    progress("ordering the searches and finding the ways between them")
    strokes = strokes.select(made.rows)
    clear = float(strokes.contacts.normal_mm.max())
    air = Air(materials, options.torch, options.wire_mm, up, found.safe_mm, clear, displaced)
    order = _in_order if reach is None else _unordered
    searches = order(part, strokes, air, made, options)
    if options.post_base is not None:
        searches = (post_search(options, T, up, found.safe_mm), *searches)
    plan = TouchPlan(
        part.name,
        searches,
        T,
        options.wire_mm,
        options.torch.wire_mm,
        predicted=made.predicted,
        notes=(*notes, *_notes(part.graph, found, T_base_part is None)),
        bodies=made.bodies,
    )
    return plan if reach is None else reach.with_joints(plan, air)


def design_of(part: TouchPart, strokes: Strokes, place: PartPlace, options: TouchOptions) -> TouchDesign:
    """Return what sets of searches on a part are judged by."""
    contacts = strokes.contacts
    return TouchDesign.of(
        contacts.p - place.centre,
        contacts.normal,
        contacts.wire,
        options.setup,
        np.concatenate([seam.frames.p for seam in part.seams]) - place.centre,
        stick_out_sigma_mm=stick_out_sigma_mm(options),
    )


def _require_held(
    graph: BrepGraph,
    design: TouchDesign,
    found: Candidates,
    place: PartPlace,
    options: TouchOptions,
) -> None:
    free, count = design.free_motions(), options.count(1 if place.tacked is None else len(place.tacked.bodies))
    if len(free) == 0 and len(design) >= count:
        return
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
    raise GeometryError(f"the touches that are possible leave the part free: it {words}; {help_}")


def _displaced(part: TouchPart, material: Material, place: PartPlace, options: TouchOptions) -> DisplacedPart:
    if part.tacked is None:
        return DisplacedPart.of(material, place.centre, options.nominal)
    return DisplacedPart.of_bodies(material, part.graph, place, part.tacked, options.nominal)


@dataclass(frozen=True, slots=True, eq=False)
class _Chosen:
    """The rows of the strokes that are made, what they promise, and what each of them is for."""

    rows: IntArray
    predicted: SeamPrediction
    bodies: tuple[PlannedBody, ...] = ()
    of_each: tuple[tuple[str, Served | None], ...] = ()

    def search(
        self, part: TouchPart, strokes: Strokes, row: int, name: str, via: FloatArray, options: TouchOptions
    ) -> Search:
        """Return a row of the strokes, which are these rows in their order, as a search."""
        search = search_of(part, strokes, row, name, via, options)
        return search if not self.of_each else replace(search, body=self.of_each[row][0], serves=self.of_each[row][1])


def _chosen(part: TouchPart, strokes: Strokes, design: TouchDesign, place: PartPlace, options: TouchOptions) -> _Chosen:
    if part.tacked is not None:
        return _chosen_for_bodies(part.graph, strokes, design, part.tacked, options)
    points, why = np.concatenate([seam.frames.p for seam in part.seams]) - place.centre, ""
    if options.tolerance_mm is None:
        rows = choose_touches(design, strokes.contacts.p, strokes.contacts.normal, options)
    else:
        rows, why = fewest_set(design, points, options, np.random.default_rng(options.seed))
    return _Chosen(rows, replace(_prediction(part.seams, design, rows, place.centre), why_not=why))


def _chosen_for_bodies(
    graph: BrepGraph, strokes: Strokes, design: TouchDesign, tacked: Tacked, options: TouchOptions
) -> _Chosen:
    advice = advise_searches(graph, strokes, design, tacked, options)
    names, tolerances = tacked.bodies.names, tacked.bodies.tolerances
    return _Chosen(
        np.array([touch.index for touch in advice.touches]),
        advice,
        tuple(PlannedBody(name, each.mm, each.mrad) for name, each in zip(names, tolerances, strict=True)),
        tuple((touch.body, touch) for touch in advice.touches),
    )


def _prediction(seams: Sequence[Seam], design: TouchDesign, chosen: IntArray, centre: FloatArray) -> SeamPrediction:
    covariance = design.covariances(chosen[None])[0][0]
    by_seam = tuple(
        (seam.name, float(error_95(seam.frames.p - centre, covariance).max())) for seam in seams if len(seam.frames)
    )
    worst = max(by_seam, key=lambda each: each[1])
    every = np.concatenate([seam.frames.p for seam in seams]) - centre
    return SeamPrediction(worst[1], worst[0], by_seam, joint_error_of(design, chosen, every))


def _in_order(part: TouchPart, strokes: Strokes, air: Air, made: _Chosen, options: TouchOptions) -> tuple[Search, ...]:
    R = tool_axes(strokes)
    ends = np.stack([strokes.approach, strokes.at(strokes.before_mm)], axis=1)
    order, ways = order_searches(strokes.approach, R, air)
    searches = list[Search]()
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
        searches.append(made.search(part, strokes, row, f"T{number + 1}", via, options))
    return tuple(searches)


def _unordered(part: TouchPart, strokes: Strokes, _: Air, made: _Chosen, options: TouchOptions) -> tuple[Search, ...]:
    """Return the searches as they come: the arm orders them by its joints."""
    none = np.empty((0, 3))
    return tuple(made.search(part, strokes, row, f"T{row + 1}", none, options) for row in range(len(strokes)))


def _words(p: FloatArray) -> str:
    return f"({' '.join(f'{round(float(v), 1) + 0.0:g}' for v in p)})"


def _notes(graph: BrepGraph, found: Candidates, is_unplaced: bool) -> tuple[str, ...]:
    notes = list[str]()
    small = list(dict.fromkeys(found.small.face.tolist()))
    if small:
        which = face_words(graph, found.small, small[0])
        notes.append(f"{counted(len(small), 'face')} too small for the displacement of the part, such as {which}")
    if is_unplaced:
        notes.append("the place of the part is not given (--nominal or --cell): z of the part counts as up")
    return tuple(notes)
