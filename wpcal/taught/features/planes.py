"""Datum planes: the plane faces of a solid; faces in one plane are one datum."""

from __future__ import annotations

import numpy as np

from wpcal.brep.curves import evaluate_edges, piece_counts
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.core.arrays import FloatArray, IntArray, numbered_rows
from wpcal.taught.features.columns import (
    AXIS_ROUND,
    NAMING_MM,
    FeatureColumns,
    first_rows,
    label_equal,
    members_of,
    sums,
)
from wpcal.taught.features.reference import FeatureKind

LEAST_AREA_MM2 = 1.0  #: Three touches of a tip cannot determine the plane of a smaller face.


def find_planes(graph: BrepGraph) -> FeatureColumns:
    """Find the datum planes.

    Returns: One row per solid, plane and side: faces in one plane that face the same way are one datum. The point is
    the centroid of their area, which may be over an opening. The direction is outward.
    """
    faces = np.flatnonzero(graph.face_kind == SurfaceKind.PLANE)
    normal = graph.face_frame[faces, 3] * graph.face_outward[faces][:, None]
    height = np.einsum("ki,ki->k", graph.face_frame[faces, 0], normal)
    area, moment = _areas(graph, faces, normal)
    label = label_equal(graph.face_solid[faces], np.round(normal / AXIS_ROUND), np.round(height / NAMING_MM)[:, None])
    first = first_rows(label)
    total = sums(label, area, len(first))
    kept = np.flatnonzero(total >= LEAST_AREA_MM2)
    summed = sums(label, moment, len(first))
    of_label = members_of(label, faces)
    return FeatureColumns(
        kind=FeatureKind.PLANE,
        p=summed[kept] / total[kept, None],
        solid=graph.face_solid[faces[first[kept]]],
        direction=normal[first[kept]],
        area_mm2=total[kept],
        faces=[of_label[k] for k in kept],
    )


def _areas(graph: BrepGraph, faces: IntArray, normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return area and first moment (area times centroid) of plane faces, from triangles between a point and the border.

    Seen from outside, the face lies to the left of its border, so that holes count as negative.
    """
    row = np.full(graph.face_count, -1)
    row[faces] = np.arange(len(faces))
    used = np.flatnonzero((row[graph.coedge_face] >= 0) & (graph.edge_kind[graph.coedge_edge] != CurveKind.DEGENERATE))
    edge, sign = graph.coedge_edge[used], np.where(graph.coedge_forward[used], 1.0, -1.0)
    samples = piece_counts(graph)[edge] + 1
    of, number = numbered_rows(samples)
    share = number / (samples[of] - 1)
    t0, t1 = graph.edge_range[edge[of]].T
    points = evaluate_edges(graph, edge[of], t0 * (1.0 - share) + t1 * share)[0]
    low = np.flatnonzero(share < 1.0)
    of = of[low]
    face = row[graph.coedge_face[used]][of]
    pivot = graph.face_frame[faces, 0]
    a, b = points[low] - pivot[face], points[low + 1] - pivot[face]
    signed = 0.5 * sign[of] * np.einsum("ki,ki->k", np.cross(a, b), normal[face])
    area = sums(face, signed, len(faces))
    moment = sums(face, signed[:, None] * (a + b) / 3.0, len(faces))
    return area, moment + area[:, None] * pivot
