"""Pairs of solids that hold each other: a pane in the groove of its frame, a ball between races, a cell in its case.

Where two solids touch, one can move away from the other only along directions that no contact forbids. If there is no
such direction, the two cannot have been put together as they are: one of them was closed, moulded or bent round the
other one, or is made of several. Members of a weldment are put in place and then welded, so they can be taken apart by
a straight move. A frame that was fused to one body may hold a panel so; this is a doubt only.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.hits import find_hits
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.built_up import sampled_surface

OPPOSED = -0.9998
"""Faces are in contact if the cosine between their outward normals is below this: within one degree, as `INTO`.
Beside the line in which a ring of wire touches a pipe, its face is near and slants: it does not hold."""
ALIKE = 0.12  #: Of normals that agree within this, one is taken: every 7 degrees.
MOST_NORMALS = 80  #: Of more different normals (a sphere in a bowl) only this many are compared, spread evenly.
INTO = -0.02  #: A move is forbidden if it runs into a contact by more than this cosine: one degree.
FLAT = 1e-3  #: Normals in one plane, or on one line, leave a direction free: their least singular value is below this.


def find_held(graph: BrepGraph, trimmed: TrimmedFaces, solids: IntArray, gap_mm: float) -> BoolArray:
    """Tell for pairs of solids whether no straight move takes one of the two away from the other, shape (n,).

    `solids`: shape (n, 2). Numbers of the solids of each pair.
    """
    found = np.zeros(len(solids), dtype=bool)
    low, high = trimmed.solid_boxes
    shared = high[solids].min(axis=1) - low[solids].max(axis=1)  # what holds another goes round it
    for row in np.flatnonzero((shared > 2.0 * gap_mm).all(axis=1)).tolist():
        one, other = solids[row].tolist()
        there = _touching(graph, trimmed, one, other, gap_mm)
        normals = np.concatenate([there, -_touching(graph, trimmed, other, one, gap_mm)])
        _, first = np.unique(np.round(normals / ALIKE), axis=0, return_index=True)
        found[row] = not _leaves_a_way(normals[first])
    return found


def _touching(graph: BrepGraph, trimmed: TrimmedFaces, solid: int, other: int, gap_mm: float) -> FloatArray:
    """Return the outward normals of another solid at random points where a solid touches it, shape (k, 3)."""
    own = sampled_surface(graph, trimmed, solid)
    hits = find_hits(trimmed, own.p - gap_mm * own.normal, own.normal, length_mm=2.0 * gap_mm, solid=other)
    at = own.p[hits.ray] + (hits.at_mm - gap_mm)[:, None] * own.normal[hits.ray]
    normal = project_to_faces(graph, hits.face, at).normal
    return np.asarray(normal[np.einsum("ki,ki->k", normal, own.normal[hits.ray]) < OPPOSED])


def _leaves_a_way(normals: FloatArray) -> bool:
    """Tell whether some direction runs into none of the contacts, whose normals point away from them.

    The directions that are left form a cone. Its edges are where two contacts slide, so it is enough to try the cross
    products of all pairs.
    """
    if len(normals) > MOST_NORMALS:
        normals = normals[np.linspace(0, len(normals) - 1, MOST_NORMALS).astype(int)]
    if len(normals) < 4 or np.linalg.svd(normals, compute_uv=False)[-1] < FLAT * np.sqrt(len(normals)):
        return True
    first, second = np.triu_indices(len(normals), 1)
    edge = np.cross(normals[first], normals[second])
    size = np.linalg.norm(edge, axis=1)
    edge = edge[size > FLAT] / size[size > FLAT, None]
    heights = edge @ normals.T
    return bool((heights.min(axis=1) >= INTO).any() or (heights.max(axis=1) <= -INTO).any())
