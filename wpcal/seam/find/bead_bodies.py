"""Weld beads that were drawn as bodies of their own: narrow prisms and rings that fill the corner between members.

Such a body is no member: the seam is the corner that it fills. So it is left out of the search, and of what a torch
meets.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from wpcal.brep.concavity import corner_turns, inner_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.hits import find_hits
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, IntArray
from wpcal.seam.find.built_up import SKIN_MM, sampled_surface
from wpcal.seam.find.strips import LEAST_CORNER_COS, WIDEST_MM
from wpcal.seam.seam import Seam, SeamSource

FEWEST_FACES, MOST_FACES = 3, 24  #: A ring with a triangular section has 3 faces, one round a square tube 12.
TOE_COS = -0.17  #: Cosine between the normals of the face of a bead and of a leg, at most: 80 degrees of material.
NEAR_MM = 0.3  #: The legs of a bead are this near to members.
LEAST_LEGS, MOST_LEGS = 0.4, 0.8  #: Shares of the surface that is on members: 0.59 of a flat bead with equal legs.
MOST_ENDS = 0.15  #: Share of the surface on the two ends of a bead that is twice as long as it is wide.
SLENDER = 1.5  #: A bead is this many times longer than it is wide.
ROOT_MM = 0.05  #: The way out of a bead is felt from this far above its root.
SHARPEST_COS = -0.8  #: Cosine between the outward normals of the two legs, at least: a wedge is thinner.


def bead_bodies(graph: BrepGraph, trimmed: TrimmedFaces) -> IntArray:
    """Return the solids that are beads; found once, and kept in `trimmed.known`."""
    found = trimmed.known.get(("beads", -1))
    if found is None:
        asked = _with_toes(graph) if len(graph.solid_names) > 1 else np.zeros(0, dtype=np.int64)
        own = [solid for solid in asked.tolist() if _is_bead(graph, trimmed, solid)]
        found = trimmed.known[("beads", -1)] = np.array(own, dtype=np.int64)
    return np.asarray(found, dtype=np.int64)


def as_drawn(graph: BrepGraph, trimmed: TrimmedFaces, seams: Sequence[Seam], beads: BoolArray) -> list[Seam]:
    """Return seams with the throats of the beads and rounds that are drawn in their corners.

    `trimmed`: Without the beads that are bodies.
    `beads`: shape (F,). The faces of beads inside solids.
    """
    own = [row for row, seam in enumerate(seams) if not seam.source.is_chosen and len(seam.frames)]
    shown = trimmed.known.get(("with beads", -1), trimmed)
    beads = beads | np.isin(graph.face_solid, bead_bodies(graph, trimmed))
    own = [row for row in own if beads.any() or seams[row].source.is_filled]
    middle = [len(seams[row].frames) // 2 for row in own]
    p = np.array([seams[row].frames.p[k] for row, k in zip(own, middle, strict=True)]).reshape(-1, 3)
    z = np.array([seams[row].frames.R[k, :, 2] for row, k in zip(own, middle, strict=True)]).reshape(-1, 3)
    hits = find_hits(shown, p + ROOT_MM * z, z, length_mm=WIDEST_MM)
    found = list(seams)
    for first in np.flatnonzero(np.diff(hits.ray, prepend=-1)).tolist():
        row, face = own[hits.ray[first]], int(hits.face[first])
        if hits.way[first] > 0 and (beads[face] or seams[row].source.is_filled):
            source = SeamSource.DRAWN if beads[face] else seams[row].source
            found[row] = replace(seams[row], source=source, bead_mm=round(ROOT_MM + float(hits.at_mm[first]), 2))
    return found


def without_beads(graph: BrepGraph, trimmed: TrimmedFaces) -> TrimmedFaces:
    """Return the faces of a part as if its beads were not there."""
    solids = bead_bodies(graph, trimmed)
    if len(solids) == 0:
        return trimmed
    trimmed.known.setdefault(("with beads", -1), trimmed)
    return trimmed.without(solids)


def _with_toes(graph: BrepGraph) -> IntArray:
    """Return the solids of few faces with at least two sharp edges, as the toes of a bead are."""
    faces = np.bincount(graph.face_solid, minlength=len(graph.solid_names))
    few = (faces >= FEWEST_FACES) & (faces <= MOST_FACES)
    edges = inner_edges(graph, few)
    sharp = edges[corner_turns(graph, edges)[1] < TOE_COS]
    return np.flatnonzero(np.bincount(graph.edge_solid[sharp], minlength=len(faces)) >= 2)


def _is_bead(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> bool:
    """Tell whether a solid fills a corner: two sides on members, and one free, not parallel to any of them."""
    surface = sampled_surface(graph, trimmed, solid)
    if not len(surface.p):
        return False
    hits = find_hits(trimmed, surface.p, surface.normal, length_mm=NEAR_MM + SKIN_MM)
    on = np.zeros(len(surface.p), dtype=bool)
    on[hits.ray[(graph.face_solid[hits.face] != solid) & (hits.way < 0)]] = True
    face, ends = ~on & ~surface.flat, ~on & surface.flat
    if not LEAST_LEGS <= on.mean() <= MOST_LEGS or ends.mean() > MOST_ENDS or not face.any():
        return False
    wide = 2.0 * float(np.quantile(surface.thick[face], 0.95))  # as deep as half of its width, with equal legs
    long = face.sum() * surface.mm2 / wide
    return wide <= WIDEST_MM and long >= SLENDER * wide and _has_root(graph, np.unique(surface.face[on]))


def _has_root(graph: BrepGraph, legs: IntArray) -> bool:
    """Tell whether two faces on members meet at an edge, at an angle."""
    edges = np.flatnonzero(np.isin(graph.edge_faces, legs).all(axis=1) & ~graph.is_seam_edge)
    cos = corner_turns(graph, edges)[1]
    return bool(((cos > SHARPEST_COS) & (cos < LEAST_CORNER_COS)).any())
