"""The searches that a plan is chosen from: places to touch, thinned out, with room for the torch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.material import Material
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import IntArray
from wpcal.core.errors import GeometryError
from wpcal.core.progress import Progress
from wpcal.core.wording import counted, listed
from wpcal.touch.design import farthest_rows
from wpcal.touch.plan.contacts import BORDER_MM, TouchPlaces, face_words, find_places
from wpcal.touch.plan.free import SAFE_MM, Strokes, find_strokes, keeps_above_floor, with_free_torch
from wpcal.touch.plan.options import TouchOptions, displacement_mm
from wpcal.touch.plan.part import PartPlace

MOST_FOLLOWED = 1500  #: Places whose wire is followed: far from one another in place, normal and wire.
MOST_FELT = 420  #: Searches whose torch is compared with the part.
MOST_CHOSEN_FROM = 200
"""Searches that sets are chosen from: all exchanges of eight of them take some tenths of a second."""
LEAST_PER_BODY = 15
"""Searches on each body that may move, at every stage: its six motions and its seams leave less choice."""


@dataclass(frozen=True, slots=True, eq=False)
class Candidates:
    """What a plan can be chosen from, and what was left out."""

    strokes: Strokes
    small: TouchPlaces  #: Places on faces that are too small for the displacement.
    safe_mm: float  #: Level along `up` on which the torch crosses the part.


def find_searches(
    graph: BrepGraph,
    trimmed: TrimmedFaces,
    materials: Sequence[Material],
    place: PartPlace,
    options: TouchOptions,
    progress: Progress,
) -> Candidates:
    """Find the searches that the torch can make. Raises `GeometryError` when there is none: what would help."""
    progress(f"looking for places to touch on {counted(graph.face_count, 'face')}")
    held, small = find_places(graph, trimmed, place, options)
    if len(held) == 0:
        raise GeometryError(too_small_words(graph, small, options))
    held = held.select(_spread(held, MOST_FOLLOWED, place))
    progress(f"following the wire to {counted(len(held), 'place')}")
    strokes = find_strokes(graph, trimmed, held, options)
    spread = place.covariances(strokes.contacts.p, strokes.contacts.face, options.nominal)
    rise = displacement_mm(spread, np.tile(place.up, (len(strokes), 1)))
    strokes = strokes.select(keeps_above_floor(strokes, place.up, place.floor_mm, rise))
    strokes = strokes.select(_spread(strokes.contacts, MOST_FELT, place))
    progress(f"comparing the torch with the part on {len(strokes)} searches")
    safe = place.top_mm + float(np.max(rise, initial=0.0)) + SAFE_MM
    strokes = with_free_torch(materials, strokes, options.torch, options.wire_mm, place.up, safe)
    if len(strokes) == 0:
        raise GeometryError(
            f"no face can be touched with {options.torch.name}: the torch or the wire meets the part or a body of the "
            "cell first; a slimmer --torch or a longer wire would help"
        )
    return Candidates(strokes, small, safe)


def thinned(strokes: Strokes, place: PartPlace) -> Strokes:
    """Keep at most `MOST_CHOSEN_FROM` searches, far from one another."""
    return strokes.select(_spread(strokes.contacts, MOST_CHOSEN_FROM, place))


def too_small_words(graph: BrepGraph, small: TouchPlaces, options: TouchOptions) -> str:
    """Say which faces are too small for the displacement of the part, and what would help."""
    if len(small) == 0:
        return "the part has no face that can be touched from above; check how it stands (--nominal)"
    faces = list(dict.fromkeys(small.face.tolist()))
    need = float(np.median(np.hypot(small.along_mm, small.across_mm))) + BORDER_MM
    words = listed([face_words(graph, small, face) for face in faces[:3]])
    return (
        f"too small for a displacement of {need - BORDER_MM:.1f} mm and {BORDER_MM:g} mm more to the border: {words}; "
        f"a smaller --uncertainty-mm (now {options.nominal.sigma_mm:g}) or --uncertainty-deg would help"
    )


def _spread(contacts: TouchPlaces, most: int, place: PartPlace) -> IntArray:
    """Return contacts far from one another in place, normal and wire, of every body that may move as many."""
    size_mm, body = place.size_mm, place.body_of(contacts.face)
    if place.tacked is not None:
        most = max(most, LEAST_PER_BODY * len(place.tacked.bodies))
    if len(contacts) <= most:
        return np.arange(len(contacts))
    features = np.concatenate([contacts.p, size_mm * contacts.normal, 0.5 * size_mm * contacts.wire], axis=1)
    kept, left = [], most
    bodies, counts = np.unique(body, return_counts=True)
    for number, k in enumerate(np.argsort(counts, kind="stable").tolist()):  # what small bodies leave, others take
        own = np.flatnonzero(body == bodies[k])
        kept.append(own[farthest_rows(features[own], left // (len(bodies) - number))])
        left -= len(kept[-1])
    return np.sort(np.concatenate(kept))
