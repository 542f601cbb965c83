"""Mitres of tubes and rolled profiles inside one solid: two of one section that end in the plane between them.

Inside the corner the edge is hollow, outside it bulges, and round tubes run smoothly into each other in between: it is
found as a whole. Where one of two goes on (a tee), no edge in the plane bulges. Flush sides have no edge.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np

from wpcal.brep.concavity import LEAST_TURN_SIN, inner_edges
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind
from wpcal.brep.surfaces import project_to_faces, unit
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.find.joint import JoinedPieces
from wpcal.seam.find.tubes import find_tubes
from wpcal.seam.member.member import ON_COS, MemberKind
from wpcal.seam.member.members import members_of
from wpcal.seam.seam import JointType, SeamPieces, WeldType

SHARES = (np.arange(9) + 0.5) / 9  #: Places along an edge at which it is compared with the plane between two members.
OFF_PLANE_MM = 0.1  #: How far these places may be from the plane: twice what kernels are off.
BUTT_COS = float(np.cos(np.radians(22.5)))  #: Of half of the turn: at 135 degrees or more it is a butt (ISO 17659).


def find_mitres(graph: BrepGraph, trimmed: TrimmedFaces, solids: IntArray) -> JoinedPieces:
    """Find the edges in which tubes and profiles of some solids, shape (n,), are mitred: butt or corner joints."""
    found = {edge: word for solid in solids.tolist() for edge, word in _of_solid(graph, trimmed, solid)}
    edges = np.array(sorted(found), dtype=np.int64)
    wall, base = graph.edge_faces[edges].T
    t0, t1 = graph.edge_range[edges].T
    pieces = SeamPieces(edges, t0, t1, wall, base, np.zeros((len(edges), 3)))
    return JoinedPieces(pieces, tuple(found[edge] for edge in edges.tolist()), (WeldType.GROOVE,) * len(edges))


def _of_solid(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> list[tuple[int, JointType]]:
    number, axis, has_bore = _sides(graph, trimmed, solid)
    edges = inner_edges(graph, np.arange(len(graph.solid_names)) == solid)
    pairs = number[graph.edge_faces[edges]]
    z = axis[graph.edge_faces[edges]]
    meets = (pairs >= 0).all(axis=1) & (np.abs(np.einsum("ki,ki->k", z[:, 0], z[:, 1])) < ON_COS)
    order = np.argsort(pairs[meets], axis=1)
    edges, pairs, z = (
        edges[meets],
        np.sort(pairs[meets], axis=1),
        np.take_along_axis(z[meets], order[..., None], axis=1),
    )
    groups, turn = _in_planes(graph, edges, pairs, z)
    straight = graph.edge_kind[edges] == CurveKind.LINE
    bulges, is_hollow = turn.max(axis=1, initial=0.0) > LEAST_TURN_SIN, turn.min(axis=1, initial=0.0) < -LEAST_TURN_SIN
    found = []
    for (a, b, sign, _), rows in groups.items():
        is_round = not straight[rows].all()
        least = 2 if has_bore[a] or has_bore[b] else 1  # the walls of a square tube have corners inside, too
        if min(bulges[rows].sum(), is_hollow[rows].sum()) >= least or (is_round and bulges[rows].any()):
            cos = abs(z[rows[0], 0] @ unit(z[rows[0], 0] + sign * z[rows[0], 1]))
            word = JointType.BUTT if cos >= BUTT_COS else JointType.CORNER
            found += [(int(edges[row]), word) for row in rows if is_round or bulges[row]]
    return found


def _in_planes(
    graph: BrepGraph, edges: IntArray, pairs: IntArray, z: FloatArray
) -> tuple[dict[tuple[int, ...], list[int]], FloatArray]:
    """Return the rows of edges in each plane in which two members, (k, 2), mirror each other, and their turns."""
    low, high = graph.edge_range[edges, :, None].transpose(1, 0, 2)
    p, slope = evaluate_edges(graph, np.repeat(edges, len(SHARES)), (low + (high - low) * SHARES).ravel())
    faces = np.repeat(graph.edge_faces[edges], len(SHARES), axis=0)
    left, right = (project_to_faces(graph, faces[:, k], p).normal.reshape(-1, len(SHARES), 3) for k in (0, 1))
    turn = np.einsum("ksi,ksi->ks", np.cross(left, right), unit(slope).reshape(left.shape))
    groups: dict[tuple[int, ...], list[int]] = defaultdict(list)
    for sign in (1, -1):
        plane = unit(z[:, 0] + sign * z[:, 1])[:, None]
        height = np.einsum("ksi,koi->ks", p.reshape(left.shape), plane)
        mirrored = left - 2.0 * np.einsum("ksi,koi->ks", left, plane)[..., None] * plane
        fits = (np.einsum("ksi,ksi->ks", mirrored, right) > ON_COS).all(axis=1) & (
            np.ptp(height, axis=1) < OFF_PLANE_MM
        )
        for row in np.flatnonzero(fits).tolist():
            groups[*pairs[row].tolist(), sign, round(float(height[row].mean()) / OFF_PLANE_MM)].append(row)
    return groups, turn


def _sides(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> tuple[IntArray, FloatArray, dict[int, bool]]:
    """Return the member of which each face is a side (F,) or -1, its axis (F, 3), and which have square bores."""
    number, axis = np.full(graph.face_count, -1), np.ones((graph.face_count, 3))
    has_bore = dict[int, bool]()
    for k, one in enumerate(members_of(graph, trimmed, solid).members):
        if one.kind in (MemberKind.TUBE, MemberKind.PROFILE):
            own = list(one.faces)
            number[own], axis[own], has_bore[k] = k, one.axis, one.kind is MemberKind.TUBE
    tubes = find_tubes(graph, trimmed, solid)
    for row in np.flatnonzero(tubes.outer).tolist():
        number[tubes.face[row]] = graph.face_count + int(tubes.axis[row])
        axis[tubes.face[row]] = graph.face_frame[tubes.face[row], 3]
        has_bore[graph.face_count + int(tubes.axis[row])] = False
    largest = np.take_along_axis(axis, np.abs(axis).argmax(axis=1)[:, None], axis=1)
    return number, axis * np.sign(largest), has_bore
