"""What a joint inside one solid is called: by how thick the two members are there, and how far they go on.

At a concave edge either face may be that of the member that stands on the other one. It is measured just behind that
face, where the member is: how thick it is, how far up it goes, and whether the other member goes on behind it. The
words are those of two solids (`joint.JointView`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph
from wpcal.brep.surfaces import part_across, project_to_faces, unit
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.seam.find.built_up import way_out
from wpcal.seam.find.formed import are_inside
from wpcal.seam.find.joint import JoinedPieces, JointView
from wpcal.seam.seam import JointType

SKIN_MM = 0.05
"""How far inside a member, and above or below the other one, it is measured: less than the thinnest sheet."""
BEYOND = 0.1  #: How far behind a member the other one goes on, as a share of the thickness of the member.
RANK = (JointType.TEE, JointType.LAP, JointType.CORNER, JointType.UNKNOWN)
"""Seen from the other member, a tee and a lap are corners: the earlier word is right."""


def with_inner_joints(graph: BrepGraph, trimmed: TrimmedFaces, joined: JoinedPieces) -> JoinedPieces:
    """Return pieces between faces of one solid with the words for their joints.

    Returns JoinedPieces. Where no thickness can be measured, the word stays as it is.
    """
    pieces = joined.pieces
    if len(pieces) == 0:
        return joined
    p, slope = evaluate_edges(graph, pieces.edge, (pieces.t0 + pieces.t1) / 2)
    x = slope / np.linalg.norm(slope, axis=1, keepdims=True)
    normals = [project_to_faces(graph, face, p).normal for face in (pieces.wall, pieces.base)]
    solid = graph.face_solid[pieces.wall]
    ways = [_words(trimmed, solid, p, x, own, other) for own, other in (normals, normals[::-1])]
    best = [min(pair, key=RANK.index) for pair in zip(*ways, strict=True)]
    words = (was if word is JointType.UNKNOWN else word for word, was in zip(best, joined.joint, strict=True))
    return replace(joined, joint=tuple(words))


def _words(
    trimmed: TrimmedFaces, solid: IntArray, p: FloatArray, x: FloatArray, n_member: FloatArray, n_base: FloatArray
) -> list[JointType]:
    """Return the word for each joint if the member with the first normal stands on the other one."""
    graph = trimmed.graph
    behind, up = unit(part_across(-n_member, n_base)), unit(part_across(n_base, n_member))
    inside = p + SKIN_MM * (behind + up)
    through = way_out(graph, trimmed, solid, inside, behind)[0]
    along = sum(way_out(graph, trimmed, solid, inside, way)[0] for way in (x, -x))
    thickness, height = np.minimum(through, along), way_out(graph, trimmed, solid, inside, up)[0]
    known = np.isfinite(thickness) & np.isfinite(height) & np.isfinite(through)
    beyond = p + np.where(known, (1.0 + BEYOND) * through, 0.0)[:, None] * behind - SKIN_MM * n_base
    goes_on = are_inside(graph, trimmed, solid, beyond)
    words = []
    for is_known, upright, base_beyond in zip(known, height >= thickness, goes_on, strict=True):
        view = JointView(
            base_continues=True,
            base_below=True,
            member_upright=bool(upright),
            other_upright=True,
            base_beyond=bool(base_beyond),
            side_by_side=False,
            concave=True,
        )
        words.append(view.words[0] if is_known else JointType.UNKNOWN)
    return words
