"""On which body each touch lies, and which touches are corners of two bodies alike."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from cad.workpiece.bodies import PartBodies
from wpcal.brep.curves import edge_polylines
from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.brep.trim import distance_to_segments
from wpcal.calibrate.observe.targets import GraphTargets, TargetKind
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.trust.criteria import TWO_BODIES
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.issue import Issue
from wpcal.core.linked import near_tree
from wpcal.core.wording import listed

NAMED_MM = 1e-3  #: A point this near to a vertex or to the centre of a circle is taken for it.


def bodies_touched(touches: Touches, face_body: IntArray, solid_of: Mapping[str, int] | None = None) -> IntArray:
    """Return the body that each touch lies on, shape (n,).

    A point is of the body of the solid that `solid_of` gives for its row; otherwise of the body whose vertex, circle or
    edge it is; where those of two bodies coincide, of the one of which it is a vertex or a centre.
    """
    targets = touches.targets
    assert isinstance(targets, GraphTargets)  # of `touches_of`
    graph = targets.graph
    kind, index = targets.kind[touches.rows], targets.index[touches.rows]
    edge_body = face_body[graph.edge_faces.max(axis=1)]
    body = np.full(len(touches), -1)
    is_face, is_edge = kind == TargetKind.FACE, kind == TargetKind.EDGE
    body[is_face] = face_body[index[is_face]]
    body[is_edge] = edge_body[index[is_edge]]
    is_point = kind == TargetKind.POINT
    if is_point.any():
        body[is_point] = bodies_at(graph, targets.point[touches.rows][is_point], face_body)
    for i in np.flatnonzero(is_point).tolist():
        own = np.unique(face_body[graph.face_solid == (solid_of or {}).get(touches.names[i], -1)])
        if len(own) == 1:  # a solid that is cut into members has several
            body[i] = own[0]
    return body


def on_two_bodies(touches: Touches, part: PartBodies, solid_of: Mapping[str, int]) -> tuple[Issue, ...]:
    """Return which touched points are corners of two bodies, where no row of `solid_of` says of which."""
    targets = touches.targets
    assert isinstance(targets, GraphTargets)  # of `touches_of`
    graph = targets.graph
    rows = np.flatnonzero(targets.kind[touches.rows] == TargetKind.POINT)
    rows = rows[[touches.names[i] not in solid_of for i in rows.tolist()]]
    edge_body = part.face_body[graph.edge_faces.max(axis=1)]
    start, _, points = edge_polylines(graph)
    ends, end_body = np.concatenate([points[start[:-1]], points[start[1:] - 1]]), np.tile(edge_body, 2)
    near = near_tree(ends).query_ball_point(targets.point[touches.rows][rows], NAMED_MM) if len(rows) else []
    told, names = [], []
    for i, own in zip(rows.tolist(), near, strict=True):
        bodies = [part.bodies.names[b] for b in np.unique(end_body[own]).tolist() if b >= 0]
        if len(bodies) > 1:
            names.append(touches.names[i])
            told.append(f"{names[-1]} ({listed(bodies)})")
    if not told:
        return ()
    what = (
        f"corners of two bodies coincide at {listed(told)}, and nothing says which body was touched: write the name of "
        "the corner into the column feature (`wpcal features` lists the names), or touch another place"
    )
    return (Issue(TWO_BODIES, what, tuple(names)),)


def bodies_at(graph: BrepGraph, p: FloatArray, face_body: IntArray) -> IntArray:
    """Return the body of each point, shape (n,), as `bodies_touched` does; `p` has the shape (n, 3), in `part`, mm."""
    edge_body = face_body[graph.edge_faces.max(axis=1)]
    start, _, points = edge_polylines(graph)
    edge = np.repeat(np.arange(len(start) - 1), np.diff(start))
    ends = np.concatenate([start[:-1], start[1:] - 1])
    circles = np.flatnonzero(graph.edge_kind == CurveKind.CIRCLE)
    named = np.concatenate([points[ends], graph.edge_frame[circles, 0]])
    named_edge = np.concatenate([edge[ends], circles])
    distances, row = near_tree(named).query(p)
    away, found = np.asarray(distances), named_edge[row]
    for k in np.flatnonzero(away > NAMED_MM).tolist():
        nearest, apart = _nearest_edge(points, edge, p[k])
        if apart < away[k] - NAMED_MM:
            found[k] = nearest
    return np.asarray(edge_body[found])


def _nearest_edge(points: FloatArray, edge: IntArray, p: FloatArray) -> tuple[int, float]:
    """Return the edge whose polyline is nearest to a point, and its distance, mm."""
    inside = np.flatnonzero(edge[1:] == edge[:-1])
    a, b = points[inside], points[inside + 1]
    away = distance_to_segments(np.broadcast_to(p, a.shape), a, b)
    k = int(np.argmin(away))
    return int(edge[inside[k]]), float(away[k])
