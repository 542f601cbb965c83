"""`plan_touches`: which searches a robot makes to locate a part, and how it moves between them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.material import ExactMaterial, Material
from wpcal.brep.trim import TrimmedFaces
from wpcal.calibrate.touches.held_motions import free_words
from wpcal.calibrate.uncertainty import error_95
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import ErrorCode, GeometryError
from wpcal.core.progress import Progress, no_progress
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import counted
from wpcal.features.reference import FeatureKind, ReferenceFeature
from wpcal.seam.seam import Seam
from wpcal.searches import Contact, SeamPrediction, Search, SearchKind, TouchPlan
from wpcal.touchplan.candidates import (
    Candidates,
    PartPlace,
    face_words,
    find_candidates,
    thinned,
    too_small_words,
)
from wpcal.touchplan.choose import TouchDesign
from wpcal.touchplan.contacts import word_of
from wpcal.touchplan.displaced import DisplacedPart
from wpcal.touchplan.free import APPROACH_MM, Strokes, tool_axes
from wpcal.touchplan.options import TouchOptions
from wpcal.touchplan.order import Air, order_searches
from wpcal.touchplan.patterns import choose_touches

SAME_AXIS_MM = 0.01
"""A wall belongs to the hole whose axis is this near to its own."""
POST_ROOM_MM = 10.0
"""The search on the post begins and ends so far from it: more than the wire is ever too long or too short."""


class Reach(Protocol):
    """The arm that makes the searches."""

    def turned(self, strokes: Strokes) -> tuple[Strokes, tuple[str, ...]]:
        """Turn the tool about the wire so that the arm reaches; leave out what it cannot reach, and say so."""

    def with_joints(self, plan: TouchPlan, air: Air) -> TouchPlan:
        """Return the plan with the joints of the arm."""


@dataclass(frozen=True, slots=True, eq=False)
class TouchPart:
    """The part that is located.

    Parameters
    ----------
    name : str
        File name.
    graph : BrepGraph
    trimmed : TrimmedFaces
    seams : sequence of Seam
        Where the error counts; frames in `part`.
    features : sequence of ReferenceFeature
        Their names are written into the plan.
    material : Material or None
        Its solids, with which the torch is compared: triangles are fast. None: the exact faces.
    """

    name: str
    graph: BrepGraph
    trimmed: TrimmedFaces
    seams: Sequence[Seam]
    features: Sequence[ReferenceFeature] = ()
    material: Material | None = None


def plan_touches(
    part: TouchPart,
    *,
    options: TouchOptions,
    T_base_part: RigidTransform | None = None,
    bodies: Sequence[Material] = (),
    reach: Reach | None = None,
    progress: Progress = no_progress,
) -> TouchPlan:
    """Choose searches with the least predicted 95 % error of the seams, order them, and find the ways between them.

    Parameters
    ----------
    part : TouchPart
    options : TouchOptions
    T_base_part : RigidTransform, optional
        Where the part stands as planned. By default base and part coincide.
    bodies : sequence of Material
        Bodies of the cell, in `part`.
    reach : Reach, optional
        The arm; without it the joints of the plan stay empty.
    progress : callable

    Returns
    -------
    TouchPlan

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
    place = PartPlace.of(part.trimmed, up)
    materials = [part.material or ExactMaterial(part.graph, part.trimmed), *bodies]
    found = find_candidates(part.graph, part.trimmed, materials, place, options, progress)
    notes: tuple[str, ...] = ()
    displaced = DisplacedPart.of(materials[0], place.centre, options.nominal)
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
    progress(f"choosing {options.touches} touches from {len(strokes)}")
    chosen = choose_touches(design, strokes.contacts.p, strokes.contacts.normal, options)
    predicted = _prediction(part.seams, design, chosen, place.centre)
    progress("ordering the searches and finding the ways between them")
    strokes = strokes.select(chosen)
    clear = float(strokes.contacts.normal_mm.max())
    air = Air(materials, options.torch, options.wire_mm, up, found.safe_mm, clear, displaced)
    searches = _in_order(part, strokes, air, options) if reach is None else _unordered(part, strokes, options)
    if options.post_base is not None:
        searches = (_post(options, T, up, found.safe_mm), *searches)
    plan = TouchPlan(
        part.name,
        searches,
        T,
        options.wire_mm,
        options.torch.wire_mm,
        predicted=predicted,
        notes=(*notes, *_notes(part.graph, found, T_base_part is None)),
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


def stick_out_sigma_mm(options: TouchOptions) -> float:
    """Return what is not known of the stick-out: with a post, only the error of the touch on it."""
    return options.setup.repeatability_mm if options.post_base is not None else options.setup.stick_out_sigma_mm


def _require_held(
    graph: BrepGraph,
    design: TouchDesign,
    found: Candidates,
    place: PartPlace,
    options: TouchOptions,
) -> None:
    free = design.free_motions()
    if len(free) == 0 and len(design) >= options.touches:
        return
    if len(free) == 0:
        raise GeometryError(
            f"only {len(design)} searches are possible, and {options.touches} are asked for; ask for fewer with "
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


def _prediction(seams: Sequence[Seam], design: TouchDesign, chosen: IntArray, centre: FloatArray) -> SeamPrediction:
    covariance = design.covariances(chosen[None])[0][0]
    by_seam = tuple(
        (seam.name, float(error_95(seam.frames.p - centre, covariance).max())) for seam in seams if len(seam.frames)
    )
    worst = max(by_seam, key=lambda each: each[1])
    return SeamPrediction(worst[1], worst[0], by_seam)


def _in_order(part: TouchPart, strokes: Strokes, air: Air, options: TouchOptions) -> tuple[Search, ...]:
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
        searches.append(search_of(part, strokes, row, f"T{number + 1}", via, options))
    return tuple(searches)


def _unordered(part: TouchPart, strokes: Strokes, options: TouchOptions) -> tuple[Search, ...]:
    """Return the searches as they come: the arm orders them by its joints."""
    none = np.empty((0, 3))
    return tuple(search_of(part, strokes, row, f"T{row + 1}", none, options) for row in range(len(strokes)))


def _words(p: FloatArray) -> str:
    return f"({' '.join(f'{round(float(v), 1) + 0.0:g}' for v in p)})"


def search_of(part: TouchPart, strokes: Strokes, row: int, name: str, via: FloatArray, options: TouchOptions) -> Search:
    """Return one stroke as a search.

    Parameters
    ----------
    part : TouchPart
    strokes : Strokes
    row : int
    name : str
    via : ndarray, shape (k, 3)
        Points on the way to its approach, in `part`, mm.
    options : TouchOptions
    """
    one = strokes.select(np.array([row]))
    contacts, setup = one.contacts, options.setup
    face, wire, normal = int(contacts.face[0]), contacts.wire[0], contacts.normal[0]
    late = setup.latency_sigma_s * setup.search_speed_mm_s
    covariance = setup.repeatability_mm**2 * np.eye(3)
    covariance += stick_out_sigma_mm(options) ** 2 * np.outer(wire, wire) + late**2 * np.outer(normal, normal)
    return Search(
        name,
        word_of(part.graph, face),
        _feature(part, face),
        contacts.p[0],
        normal,
        Contact.END if contacts.cos_angle[0] > np.cos(np.radians(20.0)) else Contact.SIDE,
        float(one.radius_mm[0]),
        tool_axes(one)[0],
        via,
        one.approach[0],
        one.at(one.before_mm)[0],
        one.at(-one.after_mm)[0],
        one.approach[0],
        covariance,
    )


def _feature(part: TouchPart, face: int) -> str:
    """Return the name of the hole that a wall belongs to, or nothing."""
    if word_of(part.graph, face) != "hole":
        return ""
    origin, axis = part.graph.face_frame[face, 0], part.graph.face_frame[face, 3]
    solid = part.graph.solid_names[part.graph.face_solid[face]]
    for feature in part.features:
        if feature.kind is FeatureKind.HOLE and feature.solid == solid:
            off = feature.p_mm - origin
            same = feature.diameter_mm is None or abs(feature.diameter_mm / 2 - part.graph.face_param[face, 0]) < 1e-3
            if same and np.linalg.norm(off - (off @ axis) * axis) <= SAME_AXIS_MM:
                return feature.name
    return ""


def _post(options: TouchOptions, T_base_part: RigidTransform, up: FloatArray, safe_mm: float) -> Search:
    """Return the search down on the middle of the post's top."""
    p = T_base_part.inverse().apply(np.array(options.post_base))
    x = np.cross(up, np.eye(3)[np.argmin(np.abs(up))])
    x /= np.linalg.norm(x)
    R = np.stack([x, np.cross(-up, x), -up], axis=1)
    start, end = p + POST_ROOM_MM * up, p - POST_ROOM_MM * up
    approach = start + APPROACH_MM * up
    via = (approach + max(safe_mm - float(approach @ up), 0.0) * up)[None]
    covariance = options.setup.repeatability_mm**2 * np.eye(3)
    none = Search("POST", "plane", "", p, up, Contact.END, 0.0, R, via, approach, start, end, approach, covariance)
    return replace(none, kind=SearchKind.POST)


def _notes(graph: BrepGraph, found: Candidates, is_unplaced: bool) -> tuple[str, ...]:
    notes = list[str]()
    small = list(dict.fromkeys(found.small.face.tolist()))
    if small:
        which = face_words(graph, found.small, small[0])
        notes.append(f"{counted(len(small), 'face')} too small for the displacement of the part, such as {which}")
    if is_unplaced:
        notes.append("the place of the part is not given (--nominal or --cell): z of the part counts as up")
    return tuple(notes)
