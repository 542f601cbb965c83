"""Pairs of solids that hold each other: a pane in the groove of its frame, a ball between races, a cell in its case.

Where two solids touch, one can move away from the other only along directions that no contact forbids. If there is no
such direction, the two cannot have been put together as they are: one of them was closed, moulded or bent round the
other one, or is made of several. Members of a weldment are put in place and then welded, so they can be taken apart by
a straight move. A frame that was fused to one body may hold a panel so; this is a doubt only.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray, IntArray

OPPOSED = -0.99
"""Faces are in contact if the cosine between their outward normals is below this: within 8 degrees of opposite."""
INSET_MM = 0.3
"""Points of the boundary of a face are moved into the face by this much before they are felt: grooves are deeper."""
MOST_POINTS = 36
"""Points on the boundary of a face: every 10 degrees of a circle."""
DIGITS = 3
"""Normals that agree to so many digits are one."""
MOST_NORMALS = 80
"""Of more different normals (a sphere in a bowl) only so many are compared, spread evenly."""
INTO = -0.02
"""A move is forbidden if it runs into a contact by more than this cosine: one degree."""
FLAT = 1e-3
"""Normals in one plane, or on one line, leave a direction free: their least singular value is below this."""


def hold_each_other(graph: BrepGraph, trimmed: TrimmedFaces, a: int, b: int, gap_mm: float) -> bool:
    """Tell whether no straight move takes one of two solids away from the other.

    Parameters
    ----------
    graph, trimmed :
        The part.
    a, b : int
        Numbers of two solids.
    gap_mm : float
        Faces nearer than this touch.
    """
    low, high = trimmed.face_box
    own, other = (np.flatnonzero(graph.face_solid == solid) for solid in (a, b))
    row, column = np.nonzero(
        ((low[own][:, None] - gap_mm <= high[other]) & (high[own][:, None] + gap_mm >= low[other])).all(axis=2)
    )
    away = np.concatenate(
        [
            _contact_normals(graph, trimmed, own[row], other[column], gap_mm),
            -_contact_normals(graph, trimmed, other[column], own[row], gap_mm),
        ]
    )
    return len(away) > 0 and not _leaves_a_way(away)


def _contact_normals(
    graph: BrepGraph, trimmed: TrimmedFaces, faces: IntArray, others: IntArray, gap_mm: float
) -> FloatArray:
    """Return the outward normals of the other solid where boundaries of faces touch it, shape (n, 3)."""
    pieces = [_spread(trimmed, face) for face in faces.tolist()]
    pair = np.repeat(np.arange(len(faces)), [len(own) for own in pieces])
    piece = np.concatenate([np.zeros(0, dtype=np.int64), *pieces])
    middle, way = (trimmed.p0[piece] + trimmed.p1[piece]) / 2, trimmed.p1[piece] - trimmed.p0[piece]
    side = np.cross(project_to_faces(graph, faces[pair], middle).normal, way)
    side *= INSET_MM / np.maximum(np.linalg.norm(side, axis=1), INSET_MM * FLAT)[:, None]
    pair = np.tile(pair, 2)
    own = project_to_faces(graph, faces[pair], np.concatenate([middle + side, middle - side]))  # one is in the face
    foot = project_to_faces(graph, others[pair], own.p)
    touches = np.linalg.norm(foot.p - own.p, axis=1) <= gap_mm
    touches &= np.einsum("ki,ki->k", foot.normal, own.normal) < OPPOSED
    for asked, place in ((faces, own), (others, foot)):
        touches[touches] = trimmed.contains(asked[pair[touches]], place.uv[touches])
    return np.asarray(foot.normal[touches], dtype=np.float64)


def _spread(trimmed: TrimmedFaces, face: int) -> IntArray:
    """Return pieces of the boundary of a face, spread evenly if there are many."""
    first, end = int(trimmed.start[face]), int(trimmed.start[face + 1])
    return np.unique(np.linspace(first, end - 1, min(end - first, MOST_POINTS)).astype(np.int64))


def _leaves_a_way(away: FloatArray) -> bool:
    """Tell whether some direction runs into none of the contacts, whose normals point away from them.

    The directions that are left form a cone. Its edges are where two contacts slide, so it is enough to try the cross
    products of all pairs.
    """
    normals = np.unique(np.round(away, DIGITS), axis=0)
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
