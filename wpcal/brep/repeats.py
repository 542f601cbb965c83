"""Groups of solids that a part holds several times: the same shapes at other places, with nothing else near them.

What depends only on shapes that are near is found once for such a group, and the copies get the same answer, moved.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from wpcal.brep.boxes import BoxTree
from wpcal.brep.extend import FreeEdge, add_edges
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.nurbs import NurbsCurve, NurbsSurface
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.linked import linked_groups

SAME = 1e-10
"""Two groups are the same if their numbers (mm, rad, directions) differ by less: round-off of coordinates of 100 m.
What is found about them then differs by less than 1e-9 mm."""


@dataclass(frozen=True, slots=True, eq=False)
class SolidGroup:
    """Solids with nothing else near them."""

    #: `solids`, `faces`, `edges`, `coedges`: Numbers in the graph, ascending.
    solids: IntArray
    faces: IntArray
    edges: IntArray
    coedges: IntArray
    low: FloatArray  #: shape (3,). Least corner of the box around them, mm.


@dataclass(frozen=True, slots=True, eq=False)
class Copy:
    """A group that is the same as another one at another place. Equal positions in their arrays are the same thing."""

    #: `first`, `group`: The group that stands for both, and this one.
    first: SolidGroup
    group: SolidGroup

    @property
    def shift_mm(self) -> FloatArray:
        """From the first group to this one, shape (3,)."""
        return np.asarray(self.group.low - self.first.low, dtype=np.float64)

    def faces_of(self, faces: IntArray) -> IntArray:
        """Return the faces of this group that are copies of faces of the first, shape (k,); -1 stays -1."""
        at = np.searchsorted(self.first.faces, np.maximum(faces, self.first.faces[0]))
        return np.where(faces < 0, -1, self.group.faces[at])

    def edges_of(self, edges: IntArray) -> IntArray:
        """Return the edges of this group that are copies of edges of the first, shape (k,)."""
        return np.asarray(self.group.edges[np.searchsorted(self.first.edges, edges)])


def find_copies(graph: BrepGraph, trimmed: TrimmedFaces, *, within_mm: float) -> tuple[Copy, ...]:
    """Find the groups of solids that are moved copies of other groups. A copy is not turned.

    Returns: Solids, faces and edges of a copy have the same order as those of the first group. Copies with another
    order are not found.
    """
    like: dict[bytes, list[SolidGroup]] = defaultdict(list)
    copies = []
    for group in _groups(graph, trimmed, within_mm):
        alike = like[_kinds(graph, group)]
        first = next((other for other in alike if _are_same(graph, other, group)), None)
        if first is None:
            alike.append(group)
        else:
            copies.append(Copy(first, group))
    return tuple(copies)


def solid_shapes(graph: BrepGraph, trimmed: TrimmedFaces) -> IntArray:
    """Return, for each solid, the first one of its shape; shape (S,)."""
    if ("shape", 0) not in trimmed.known:
        shape = np.arange(len(graph.solid_names))
        for copy in find_copies(graph, trimmed, within_mm=-np.inf):
            shape[copy.group.solids] = copy.first.solids
        trimmed.known["shape", 0] = shape
    return np.asarray(trimmed.known["shape", 0])


def solid_copies(graph: BrepGraph, trimmed: TrimmedFaces) -> dict[int, tuple[int, FloatArray]]:
    """Return the solids that are an earlier one at another place: that one, and the way from it, shape (3,), mm."""
    shape = solid_shapes(graph, trimmed)
    low, _ = trimmed.solid_boxes
    copied = np.flatnonzero(shape != np.arange(len(shape))).tolist()
    return {solid: (int(shape[solid]), low[solid] - low[shape[solid]]) for solid in copied}


def _groups(graph: BrepGraph, trimmed: TrimmedFaces, within_mm: float) -> Iterator[SolidGroup]:
    """Yield the groups of solids; a solid without faces belongs to none."""
    count = len(graph.solid_names)
    low, high = trimmed.solid_boxes
    a, b = BoxTree.of(low, high).meeting(low - within_mm, high + within_mm)
    number = linked_groups(count, a, b)
    of_face = number[graph.face_solid]
    owned = np.flatnonzero(graph.edge_solid >= 0)
    solids, faces = _divided(number, np.arange(count)), _divided(of_face, np.arange(graph.face_count))
    edges = _divided(number[graph.edge_solid[owned]], owned)
    coedges = _divided(of_face[graph.coedge_face], np.arange(len(graph.coedge_face)))
    none = np.zeros(0, dtype=np.int64)
    for key, own in faces.items():
        inside = solids[key]
        yield SolidGroup(inside, own, edges.get(key, none), coedges.get(key, none), low[inside].min(axis=0))


def _divided(key: IntArray, rows: IntArray) -> dict[int, IntArray]:
    """Return the rows of each key, ascending."""
    order = np.argsort(key, kind="stable")
    ends = [0, *(np.flatnonzero(np.diff(key[order])) + 1).tolist(), len(order)]
    return {int(key[order[a]]): rows[order[a:b]] for a, b in pairwise(ends) if b > a}


def _kinds(graph: BrepGraph, group: SolidGroup) -> bytes:
    """Return what is whole numbers in a group: equal bytes for groups that may be the same."""
    faces, edges, coedges = group.faces, group.edges, group.coedges
    columns = (
        np.searchsorted(group.solids, graph.face_solid[faces]),
        graph.face_kind[faces],
        graph.face_outward[faces] > 0,
        graph.edge_kind[edges],
        np.unique(graph.edge_vertices[edges], return_inverse=True)[1].ravel(),
        np.searchsorted(faces, graph.coedge_face[coedges]),
        np.searchsorted(edges, graph.coedge_edge[coedges]),
        graph.coedge_forward[coedges],
    )
    return b"|".join(np.asarray(column, dtype=np.int64).tobytes() for column in columns)


def _are_same(graph: BrepGraph, a: SolidGroup, b: SolidGroup) -> bool:
    """Tell whether two groups of the same kinds have the same shapes, one of them moved."""
    shift, pairs = b.low - a.low, []
    if not _are_near(graph.edge_range[a.edges], graph.edge_range[b.edges]):  # most that differ do so here
        return False
    for name, one, other, free in (
        ("face", a.faces, b.faces, (SurfaceKind.NURBS, SurfaceKind.NONE)),
        ("edge", a.edges, b.edges, (CurveKind.NURBS, CurveKind.DEGENERATE)),
    ):
        frame, param, kind = (getattr(graph, f"{name}_{column}") for column in ("frame", "param", "kind"))
        has_place = ~np.isin(kind[one], free)
        pairs += [(frame[one, 0][has_place] + shift, frame[other, 0][has_place])]
        pairs += [(frame[one, 1:], frame[other, 1:]), (param[one], param[other])]
    ends = [graph.edge_vertices[group.edges] for group in (a, b)]
    pairs += [(graph.vertex_p[ends[0]][ends[0] >= 0] + shift, graph.vertex_p[ends[1]][ends[1] >= 0])]
    if not all(_are_near(one, other) for one, other in pairs):
        return False
    surfaces = [[graph.nurbs_surfaces[i] for i in graph.face_nurbs[g.faces].tolist() if i >= 0] for g in (a, b)]
    curves = [[graph.nurbs_curves[i] for i in graph.edge_nurbs[g.edges].tolist() if i >= 0] for g in (a, b)]
    return all(
        _are_same_surface(one, other, shift) for one, other in zip(surfaces[0], surfaces[1], strict=True)
    ) and all(_are_same_curve(one, other, shift) for one, other in zip(curves[0], curves[1], strict=True))


def _are_near(one: FloatArray, other: FloatArray) -> bool:
    return one.shape == other.shape and bool((np.abs(one - other) <= SAME).all())


def _are_same_surface(a: NurbsSurface, b: NurbsSurface, shift: FloatArray) -> bool:
    columns = [(np.array(a.bounds), np.array(b.bounds)), (a.knots_u, b.knots_u), (a.knots_v, b.knots_v)]
    columns += [(a.weights, b.weights), (a.poles + shift, b.poles)]
    return a.degrees == b.degrees and all(_are_near(one, other) for one, other in columns)


def _are_same_curve(a: NurbsCurve, b: NurbsCurve, shift: FloatArray) -> bool:
    columns = [(a.knots, b.knots), (a.weights, b.weights), (a.poles + shift, b.poles)]
    return a.degree == b.degree and all(_are_near(one, other) for one, other in columns)


@dataclass(frozen=True, slots=True, eq=False)
class Firsts:
    """A graph without the faces and edges of copies. Solids and vertices are all there, with their numbers.

    So are free-form surfaces and curves, with what was computed for them.
    """

    graph: BrepGraph
    #: `faces`, `edges`: The number of each face and edge in the whole graph.
    faces: IntArray
    edges: IntArray

    @classmethod
    def of(cls, whole: BrepGraph, copies: tuple[Copy, ...]) -> Firsts:
        """Leave out the copies of a graph."""
        keeps_face, keeps_edge = np.ones(whole.face_count, dtype=bool), np.ones(whole.edge_count, dtype=bool)
        for copy in copies:
            keeps_face[copy.group.faces] = False
            keeps_edge[copy.group.edges] = False
        keeps_coedge = keeps_face[whole.coedge_face]
        columns = {
            f"face_{name}": getattr(whole, f"face_{name}")[keeps_face]
            for name in ("solid", "kind", "frame", "param", "outward", "nurbs")
        }
        columns |= {
            f"edge_{name}": getattr(whole, f"edge_{name}")[keeps_edge]
            for name in ("kind", "frame", "param", "range", "vertices", "nurbs")
        }
        if whole.nurbs_surfaces:
            _ = whole.nurbs_cells  # computed once, for both
        graph = whole.with_columns(
            **columns,
            coedge_face=_renumbered(keeps_face)[whole.coedge_face[keeps_coedge]],
            coedge_edge=_renumbered(keeps_edge)[whole.coedge_edge[keeps_coedge]],
            coedge_forward=whole.coedge_forward[keeps_coedge],
            edge_ball_mm=None if whole.edge_ball_mm is None else whole.edge_ball_mm[keeps_edge],
        )
        return cls(graph, np.flatnonzero(keeps_face), np.flatnonzero(keeps_edge))


def _renumbered(keeps: BoolArray) -> IntArray:
    return np.cumsum(keeps) - 1


def copy_added_edges(
    whole: BrepGraph, firsts: Firsts, wider: BrepGraph, solid: IntArray, copies: tuple[Copy, ...]
) -> tuple[BrepGraph, IntArray, tuple[Copy, ...]]:
    """Add to a whole graph the edges that were added to its first groups, and their copies.

    Returns `graph`: BrepGraph. The whole graph with more edges.
    Returns `edges`: ndarray of int. The number in it of each edge of `wider`.
    Returns `copies`: tuple of Copy. The same copies, which have these edges, too.

    `solid`: shape (m,). The solid that each of these edges belongs to, -1 for none.
    """
    added = [_free_edge(wider, edge) for edge in range(firsts.graph.edge_count, wider.edge_count)]
    rows_of = [np.flatnonzero(np.isin(solid, copy.first.solids)) for copy in copies]
    moved = [_moved(added[row], copy.shift_mm) for copy, rows in zip(copies, rows_of, strict=True) for row in rows]
    graph, numbers = add_edges(whole, [*added, *moved])
    own, others = numbers[: len(added)], numbers[len(added) :]
    ends = np.cumsum([0, *(len(rows) for rows in rows_of)]).tolist()
    more = [
        Copy(_with_edges(copy.first, own[rows]), _with_edges(copy.group, others[a:b]))
        for copy, rows, (a, b) in zip(copies, rows_of, pairwise(ends), strict=True)
    ]
    return graph, np.concatenate([firsts.edges, own]), tuple(more)


def _with_edges(group: SolidGroup, edges: IntArray) -> SolidGroup:
    return replace(group, edges=np.concatenate([group.edges, edges]))


def _free_edge(graph: BrepGraph, edge: int) -> FreeEdge:
    nurbs = int(graph.edge_nurbs[edge])
    curve = None if nurbs < 0 else graph.nurbs_curves[nurbs]
    (a, b), (first, last) = graph.edge_param[edge].tolist(), graph.edge_range[edge].tolist()
    kind, frame = int(graph.edge_kind[edge]), graph.edge_frame[edge]
    return FreeEdge(kind, frame, (a, b), (first, last), curve, float(graph.balls_mm[edge]))


def _moved(edge: FreeEdge, shift_mm: FloatArray) -> FreeEdge:
    curve = None if edge.nurbs is None else replace(edge.nurbs, poles=edge.nurbs.poles + shift_mm)
    frame = edge.frame.copy()
    frame[0] += shift_mm if curve is None else 0.0
    return replace(edge, frame=frame, nurbs=curve)
