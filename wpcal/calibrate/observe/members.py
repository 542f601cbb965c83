"""The members of a weldment that was modelled as one solid: it is cut at its concave edges.

Where a plate stands on another, the two meet in concave edges. Faces that are joined over other edges are one member.
Not every concave edge is a weld: the floor of a pocket is cut off, too. What cannot be a member by itself goes with its
neighbour.
"""

from __future__ import annotations

import numpy as np

from wpcal.brep.concavity import are_concave
from wpcal.brep.graph import SurfaceKind
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import IntArray
from wpcal.core.linked import linked_groups

LEAST_FACES = 4
"""A plate on another has five faces left, or four in a corner. The floor of a pocket or a step has fewer."""


def find_members(trimmed: TrimmedFaces) -> tuple[tuple[str, ...], IntArray]:
    """Cut the faces of one solid into members.

    Returns `names`: tuple of str. ``member 1`` is the largest.
    Returns `face_member`: shape (F,).
    """
    graph, n = trimmed.graph, trimmed.graph.face_count
    edges = np.flatnonzero((graph.edge_faces >= 0).all(axis=1))
    concave = are_concave(graph, edges)
    cut = linked_groups(n, *graph.edge_faces[edges[~concave]].T)
    member = _joined(trimmed, cut, int(cut.max()) + 1, graph.edge_faces[edges[concave]])
    own, (low, high) = [member == k for k in range(member.max() + 1)], trimmed.face_box
    sizes = [float(np.linalg.norm(high[faces].max(axis=0) - low[faces].min(axis=0))) for faces in own]  # diagonals
    rank = np.argsort(np.argsort([-size for size in sizes], kind="stable"), kind="stable")
    return tuple(f"member {k + 1}" for k in range(len(sizes))), np.asarray(rank[member], dtype=np.int64)


def _joined(trimmed: TrimmedFaces, member: IntArray, count: int, across: IntArray) -> IntArray:
    """Join what cannot be a member by itself to the neighbour with most faces, across concave edges."""
    faces = np.bincount(member, minlength=count)
    graph = trimmed.graph
    is_bar = np.isin(graph.face_kind, [SurfaceKind.CYLINDER, SurfaceKind.CONE]) & (graph.face_outward > 0)
    is_own = (faces >= LEAST_FACES) | np.isin(np.arange(count), member[is_bar])  # a bar may have no other face
    ends = member[across]
    ends = np.concatenate([ends, ends[:, ::-1]])
    into = np.arange(count)
    for small in np.flatnonzero(~is_own).tolist():
        others = ends[(ends[:, 0] == small) & (ends[:, 1] != small), 1]
        if len(others):
            into[small] = max(set(others.tolist()), key=lambda k: (bool(is_own[k]), int(faces[k]), -k))
    # a small one whose neighbours are small, too, follows them
    return linked_groups(count, np.arange(count), into)[member]
