"""Pairs of solids that hold each other: a pane in the groove of its frame, a ball between races, a cell in its case.

Where two solids touch, one can move away from the other only along directions that no contact forbids. If there is no
such direction, the two cannot have been put together as they are: one of them was closed, moulded or bent round the
other one, or is made of several. Members of a weldment are put in place and then welded, so they can be taken apart by
a straight move. A frame that was fused to one body may hold a panel so; this is a doubt only.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import NamedTuple

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

OPPOSED = -0.99
"""Faces are in contact if the cosine between their outward normals is below this: within 8 degrees of opposite."""
INSET_MM = 0.3
"""Points of the boundary of a face are moved into the face by this much before they are felt: grooves are deeper."""
MOST_POINTS = 36  #: Points on the boundary of a face: every 10 degrees of a circle.
DIGITS = 3  #: Normals that agree to so many digits are one.
MOST_NORMALS = 80  #: Of more different normals (a sphere in a bowl) only so many are compared, spread evenly.
INTO = -0.02  #: A move is forbidden if it runs into a contact by more than this cosine: one degree.
FLAT = 1e-3  #: Normals in one plane, or on one line, leave a direction free: their least singular value is below this.
MOST_SAMPLES = 200_000  #: Pairs of a sample and a face handled in one array: some 20 MB.


class _Contacts(NamedTuple):
    """Places where faces touch: the number of the pair, shape (k,), and the outward normal of the second, (k, 3)."""

    pair: IntArray
    normal: FloatArray


def find_held(graph: BrepGraph, trimmed: TrimmedFaces, solids: IntArray, gap_mm: float) -> BoolArray:
    """Tell for pairs of solids whether no straight move takes one of the two away from the other, shape (n,).

    `solids`: shape (n, 2). Numbers of the solids of each pair; no pair is there twice.

    Notes
    -----
    The normals of planes are known before anybody feels whether the planes touch. If all planes that may touch leave
    a way, those that do touch leave it, too. So planes are felt only where they decide.
    """
    if len(solids) == 0:
        return np.zeros(0, dtype=bool)
    pair, face, other = _near_faces(graph, trimmed, solids, gap_mm)
    is_flat = (graph.face_kind[np.stack([face, other])] == SurfaceKind.PLANE).all(axis=0)
    round_, flat = np.flatnonzero(~is_flat), np.flatnonzero(is_flat)
    flat = flat[_may_touch(graph, trimmed, face[flat], other[flat], gap_mm)]
    felt = _feel(graph, trimmed, pair[round_], face[round_], other[round_], gap_mm)
    normal = graph.face_frame[:, 3] * graph.face_outward[:, None]
    perhaps = [_Contacts(pair[flat], normal[other[flat]]), _Contacts(pair[flat], -normal[face[flat]])]
    normals = _by_pair([felt, *perhaps], len(solids))
    is_open = np.array([len(own) > MOST_NORMALS or not _leaves_a_way(own) for own in normals], dtype=bool)
    flat = flat[is_open[pair[flat]]]
    normals = _by_pair([felt, _feel(graph, trimmed, pair[flat], face[flat], other[flat], gap_mm)], len(solids))
    is_held = np.array([not _leaves_a_way(own) for own in normals], dtype=bool)
    return np.asarray(is_open & is_held, dtype=bool)


def _near_faces(
    graph: BrepGraph, trimmed: TrimmedFaces, solids: IntArray, gap_mm: float
) -> tuple[IntArray, IntArray, IntArray]:
    """Return the pairs of faces whose boxes are near: the row in `solids`, one face of each solid."""
    low, high = trimmed.face_box
    count = len(graph.solid_names)
    asked = solids[:, 0] * count + solids[:, 1]
    order = np.argsort(asked)
    own = np.flatnonzero(np.isin(graph.face_solid, solids[:, 0]))
    row, other = trimmed.box_tree.meeting(low[own] - gap_mm, high[own] + gap_mm)
    face = own[row]
    key = graph.face_solid[face] * count + graph.face_solid[other]
    at = np.searchsorted(asked[order], key)
    known = np.flatnonzero(at < len(asked))
    known = known[asked[order][at[known]] == key[known]]
    return order[at[known]], face[known], other[known]


def _may_touch(graph: BrepGraph, trimmed: TrimmedFaces, faces: IntArray, others: IntArray, gap_mm: float) -> BoolArray:
    """Tell which planes look at each other and have the box of each other's face near them, shape (n,)."""
    normal = graph.face_frame[:, 3] * graph.face_outward[:, None]
    near = np.einsum("ki,ki->k", normal[faces], normal[others]) < OPPOSED
    low, high = trimmed.face_box
    for plane, box in ((faces, others), (others, faces)):
        off = np.einsum("ki,ki->k", (low[box] + high[box]) / 2 - graph.face_frame[plane, 0], normal[plane])
        reach = np.einsum("ki,ki->k", (high[box] - low[box]) / 2, np.abs(normal[plane]))
        near &= np.abs(off) - reach <= gap_mm
    return np.asarray(near, dtype=bool)


def _feel(
    graph: BrepGraph, trimmed: TrimmedFaces, pair: IntArray, faces: IntArray, others: IntArray, gap_mm: float
) -> _Contacts:
    """Feel where the boundaries of faces touch other faces, and theirs touch the first ones."""
    there = _touching(graph, trimmed, faces, others, gap_mm)
    back = _touching(graph, trimmed, others, faces, gap_mm)
    return _Contacts(np.concatenate([pair[there.pair], pair[back.pair]]), np.concatenate([there.normal, -back.normal]))


def _touching(graph: BrepGraph, trimmed: TrimmedFaces, faces: IntArray, others: IntArray, gap_mm: float) -> _Contacts:
    """Return the outward normals of other faces where boundaries of faces touch them; a pair is a row of `faces`."""
    found = [_Contacts(np.zeros(0, dtype=np.int64), np.zeros((0, 3)))]
    counts = np.minimum(np.diff(trimmed.start)[faces], MOST_POINTS)
    chunk = np.cumsum(counts) // MOST_SAMPLES
    for rows in np.split(np.arange(len(faces)), np.flatnonzero(np.diff(chunk)) + 1):
        row, piece = _spread(trimmed, faces[rows])
        near = _are_near(trimmed, others[rows[row]], (trimmed.p0[piece] + trimmed.p1[piece]) / 2, gap_mm + 2 * INSET_MM)
        own = _touching_pieces(graph, trimmed, faces, others, rows[row[near]], piece[near], gap_mm)
        found.append(own)
    return _Contacts(*(np.concatenate(column) for column in zip(*found, strict=True)))


def _touching_pieces(
    graph: BrepGraph,
    trimmed: TrimmedFaces,
    faces: IntArray,
    others: IntArray,
    row: IntArray,
    piece: IntArray,
    gap_mm: float,
) -> _Contacts:
    """Return where points beside pieces of boundary, which belong to rows of `faces`, touch the other faces."""
    once, first, back = np.unique(piece, return_index=True, return_inverse=True)
    of, p0, p1 = faces[row[first]], trimmed.p0[once], trimmed.p1[once]
    middle = (p0 + p1) / 2
    side = np.cross(project_to_faces(graph, of, middle).normal, p1 - p0)
    side *= INSET_MM / np.maximum(np.linalg.norm(side, axis=1), INSET_MM * FLAT)[:, None]
    own = project_to_faces(graph, np.tile(of, 2), np.concatenate([middle + side, middle - side]))  # one is in the face
    row, at = np.tile(row, 2), np.concatenate([back, back + len(once)])
    near = _are_near(trimmed, others[row], own.p[at], gap_mm + INSET_MM)
    row, at = row[near], at[near]
    foot = project_to_faces(graph, others[row], own.p[at])
    touches = np.linalg.norm(foot.p - own.p[at], axis=1) <= gap_mm
    touches &= np.einsum("ki,ki->k", foot.normal, own.normal[at]) < OPPOSED
    for asked, uv in ((faces, own.uv[at]), (others, foot.uv)):
        touches[touches] = trimmed.contains(asked[row[touches]], uv[touches])
    return _Contacts(row[touches], foot.normal[touches])


def _spread(trimmed: TrimmedFaces, faces: IntArray) -> tuple[IntArray, IntArray]:
    """Return the row of each face and pieces of its boundary, spread evenly if there are many; two arrays (k,)."""
    whole = np.diff(trimmed.start)[faces]
    count = np.minimum(whole, MOST_POINTS)
    row = np.repeat(np.arange(len(faces)), count)
    step = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    return row, trimmed.start[faces[row]] + step * (whole[row] - 1) // np.maximum(count[row] - 1, 1)


def _are_near(trimmed: TrimmedFaces, faces: IntArray, points: FloatArray, within_mm: float) -> BoolArray:
    """Tell which points are in the box around a face, or within a distance beside it."""
    low, high = trimmed.face_box
    return np.asarray(((points >= low[faces] - within_mm) & (points <= high[faces] + within_mm)).all(axis=1))


def _by_pair(contacts: Sequence[_Contacts], count: int) -> Iterator[FloatArray]:
    """Yield the different normals of each pair, shape (k, 3)."""
    pair = np.concatenate([own.pair for own in contacts])
    normal = np.round(np.concatenate([own.normal for own in contacts]), DIGITS) + 0.0  # no negative zero
    order = np.lexsort((*normal.T[::-1], pair))
    pair, normal = pair[order], normal[order]
    is_new = np.append(True, (np.diff(pair) != 0) | (np.diff(normal, axis=0) != 0).any(axis=1))[: len(pair)]
    yield from np.split(normal[is_new], np.searchsorted(pair[is_new], np.arange(1, count)))


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
