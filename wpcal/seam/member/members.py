"""What a solid was made of: plates, bars, tubes, rolled profiles and formed sheets that together explain its surface.

Every plate, stretch, round and formed sheet that can be read from the faces is a hypothesis. Of all of them, those are
chosen that explain most of the surface with the fewest members (a small integer programme). A corner between two
members is a joint, and one inside a member was rolled, bent or cut.
"""

from itertools import combinations

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.trim import TrimmedFaces, once_per_solid
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.seam.find.built_up import Surface, sampled_surface
from wpcal.seam.member.hypotheses import find_hypotheses
from wpcal.seam.member.member import COST, Decomposition, Member, MemberKind

COST_ROOT = 0.02  #: Of two that explain as much, the one with fewer inner corners is taken.
COST_UNEXPLAINED = 0.6  #: A face of which nothing is explained costs as much as this many members.
COST_SURFACE = 20.0  #: The whole surface, unexplained, costs as much as this many members.
LEAST_OF_FACE = 0.8  #: A member explains a face if it explains more than this share of it.
MOST_HYPOTHESES = 400  #: Of a solid; the largest are kept.


@once_per_solid
def members_of(graph: BrepGraph, trimmed: TrimmedFaces, solid: int) -> Decomposition:
    """Take a solid apart."""
    if not (graph.face_solid == solid).any():
        return Decomposition((), 0.0, 0.0)
    surface = sampled_surface(graph, trimmed, solid)
    pairs = [*find_hypotheses(graph, trimmed, solid, surface)]
    pairs = sorted((pair for pair in pairs if pair[1].any()), key=lambda pair: -int(pair[1].sum()))[:MOST_HYPOTHESES]
    if not pairs or not len(surface.p):
        return Decomposition((), 0.0, 0.0)
    covers = np.array([cover for _, cover in pairs])
    cost = np.array([COST[member.kind] + COST_ROOT * len(member.roots) for member, _ in pairs])
    chosen = _cheapest(cost, covers, surface.face)
    members = tuple(pairs[row][0] for row in np.flatnonzero(chosen))
    straight = _are_straight(graph, members)
    share, straight_share = (float(own.any(axis=0).mean()) for own in (covers[chosen], covers[chosen][straight]))
    explained = _explained(graph, surface, members, covers[chosen])
    return Decomposition(members, share, straight_share, explained)


def are_inside_one(graph: BrepGraph, trimmed: TrimmedFaces, wall: IntArray, base: IntArray) -> BoolArray:
    """Tell which pairs of faces of one solid, shape (n,) each, one member of it explains, shape (n,)."""
    pairs = zip(graph.face_solid[wall].tolist(), wall.tolist(), base.tolist(), strict=True)
    return np.array([members_of(graph, trimmed, solid).is_inside(*faces) for solid, *faces in pairs], dtype=bool)


def _are_straight(graph: BrepGraph, members: tuple[Member, ...]) -> list[bool]:
    """Tell which members are no formed sheets, or pieces of rings beside slender ones, which others cover in part.

    A ring in a foot as thick was cast with it; so were walls of which more pieces of rings are left than other members.
    """
    sheet = [member.kind is MemberKind.SHEET for member in members]
    ring = [is_sheet and _is_ring(graph, member) for is_sheet, member in zip(sheet, members, strict=True)]
    built = any(member.is_slender for member in members) and COST[MemberKind.SHEET] * sum(ring) <= sheet.count(False)
    return [not is_sheet or (built and is_ring) for is_sheet, is_ring in zip(sheet, ring, strict=True)]


def _is_ring(graph: BrepGraph, member: Member) -> bool:
    """Tell whether a formed sheet is round about one axis and hollow: a stud is as thick as it is wide."""
    faces = list(member.faces)
    is_hollow = member.thickness_mm < graph.face_param[faces, 0]
    return bool((is_hollow & (graph.face_kind[faces] == SurfaceKind.CYLINDER)).all())


def _explained(
    graph: BrepGraph, surface: Surface, members: tuple[Member, ...], covers: BoolArray
) -> tuple[frozenset[int], ...]:
    """Return, of each member, its sides and the faces of which it explains nearly all points."""
    count = np.bincount(surface.face, minlength=graph.face_count)
    found = []
    for one, own in zip(members, covers, strict=True):
        on = np.bincount(surface.face[own], minlength=len(count))
        faces = one.faces | one.rims
        if one.rims & one.faces:  # it was cut across a body: a face that goes on is not of a plate
            faces = faces.difference(np.flatnonzero(on <= LEAST_OF_FACE * count).tolist())
        found.append(faces.union(np.flatnonzero(on > LEAST_OF_FACE * count).tolist()))
    return tuple(found)


def _cheapest(cost: FloatArray, covers: BoolArray, face: IntArray) -> BoolArray:
    """Return which hypotheses explain the points at least cost; points that the same ones explain count as one.

    One alone needs no programme if three of the cheapest cost as much, and no two cost less.
    """
    per_point = COST_UNEXPLAINED / np.bincount(face)[face] + COST_SURFACE / len(face)
    alone = cost + ~covers @ per_point
    least = float(alone.min())
    pairs = combinations(np.flatnonzero(cost < least - cost.min()).tolist(), 2)
    if least <= 3.0 * cost.min() and all(
        cost[[*two]].sum() + per_point[~covers[[*two]].any(axis=0)].sum() >= least for two in pairs
    ):
        last = len(cost) - 1 - int(alone[::-1].argmin())  # of equal ones a stretch, of which the section is known
        return np.asarray(np.arange(len(cost)) == last, dtype=bool)
    from scipy.optimize import Bounds, LinearConstraint, milp
    from scipy.sparse import csr_array, eye_array, hstack

    groups, of = np.unique(covers.T, axis=0, return_inverse=True)
    weight = np.bincount(of.ravel(), weights=per_point, minlength=len(groups))
    n, m = len(cost), len(groups)
    matrix = hstack([csr_array(groups.astype(np.float64)), eye_array(m)])
    answer = milp(
        np.concatenate([cost, weight]),
        integrality=np.concatenate([np.ones(n), np.zeros(m)]),
        bounds=Bounds(0.0, 1.0),
        constraints=LinearConstraint(matrix, lb=1.0),
        options={"node_limit": 2000, "mip_rel_gap": 1e-3},
    )
    return np.asarray(answer.x[:n] > 0.5) if answer.x is not None else np.zeros(n, dtype=bool)
