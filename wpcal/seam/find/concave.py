"""Concave edges inside one solid: where a part modelled as one piece was welded together from several."""

import numpy as np

from wpcal.brep.concavity import are_concave, inner_edges
from wpcal.brep.curves import edge_lengths
from wpcal.brep.graph import BrepGraph
from wpcal.core.arrays import BoolArray
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.limits import LEAST_SEAM_MM
from wpcal.seam.seam import JointType, SeamPieces, WeldType


def find_concave_edges(
    graph: BrepGraph,
    solids: BoolArray | None = None,
    *,
    but: BoolArray | None = None,
    min_length_mm: float = LEAST_SEAM_MM,
) -> JoinedPieces:
    """Find the concave edges between two faces of one solid.

    `solids`: shape (S,). Only these solids are searched; by default all.
    `but`: shape (F,). Faces whose edges do not count.
    Returns JoinedPieces. The left face of an edge as wall, the right one as base, gap zero; joint unknown, weld fillet.
    """
    edges = inner_edges(graph, solids)
    if but is not None:
        edges = edges[~but[graph.edge_faces[edges]].any(axis=1)]
    edges = edges[edge_lengths(graph)[edges] >= min_length_mm]
    edges = edges[are_concave(graph, edges)]
    wall, base = graph.edge_faces[edges].T
    t0, t1 = graph.edge_range[edges].T
    pieces = SeamPieces(edges, t0, t1, wall, base, np.zeros((len(edges), 3)))
    return JoinedPieces(pieces, (JointType.UNKNOWN,) * len(edges), (WeldType.FILLET,) * len(edges))
