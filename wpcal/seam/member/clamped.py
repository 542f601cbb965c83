"""Where two members are held together by bolts: holes and slots of both that line up where they touch.

Such holes speak against a seam round the faces that the bolts press together, not against other seams of the same two
members. So only seams of the pair that lie in a plane across the axis of the bolt are doubted. A gusset with a hole
stays welded to the plate on which it stands.
"""

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from wpcal.brep.graph import BrepGraph, SurfaceKind
from wpcal.brep.surfaces import off_axis, part_across
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.linked import linked_groups, near_pairs, near_tree
from wpcal.seam.member.fasteners import BORE_RATIO, COAXIAL_MM, COAXIAL_SIN, LARGEST_RADIUS_MM, Fastener

LARGEST_HOLE_MM = LARGEST_RADIUS_MM * BORE_RATIO[1]  #: Radius of the largest hole for a bolt: clearance for M40.
SECTORS = 12  #: A face goes round an axis as far as its boundary passes through sectors of 30 degrees.
WHOLE, HALF = 11, (5, 8)
"""Sectors of a whole hole, and of one end of a slot. Rounds in the corner of a pocket pass through three or four."""
WIDEST_RATIO = 2.0
"""Largest ratio of two holes that line up: the counterbore for the head of a socket screw (18) over its hole (9)."""
MEETING_MM = 2.0
"""Holes meet if the end of one is this near to the begin of the other: rims may be chamfered, and a gasket or a washer
may be between."""
BESIDE_MM = 1.0  #: A seam is in a plane if it is this near to it: exporters round, and edges of plates are broken.
MOST_OF_SEAM = 0.9  #: Share of the stations of a seam that must be in the plane.
LONGEST_SLOT_MM = 100.0  #: Between the axes of the two ends of a slot for a bolt; a longer one is an opening.
APART = 0.9  #: The ends of a slot bulge along it, away from each other: cosine.
HINGED = 2  #: Bosses of two members that meet so often along one axis are the knuckles of a hinge.
PIECES_OF_ARC = 4  #: Points on each piece of boundary that are sorted into sectors.


@dataclass(frozen=True, slots=True, eq=False)
class Holes:
    """Holes and slots of all solids, one row each; a slot has two axes."""

    solid: IntArray  #: shape (n,).
    #: `o`, `end`: shape (n, 3). A point on the axis, and on the axis of the other end of a slot (the same point for a
    #: round hole), mm.
    o: FloatArray
    end: FloatArray
    z: FloatArray  #: shape (n, 3). Direction of the axis.
    radius: FloatArray  #: shape (n,).
    #: `low`, `high`: shape (n,). Where the hole begins and ends along the axis, measured from the origin of `part`, mm.
    low: FloatArray
    high: FloatArray
    #: shape (n,). Whether the solid is round about the same axis outside, too: a ring, a boss, the end of a lug, a
    #: pipe.
    is_boss: BoolArray
    pin: IntArray  #: shape (n,). A solid without a bore of which a round bar goes through it; -1 if there is none.
    face: tuple[IntArray, ...]  #: Its faces.

    def __len__(self) -> int:
        return len(self.solid)


@dataclass(frozen=True, slots=True, eq=False)
class Clamp:
    """A place at which two members are pressed together along an axis."""

    solids: tuple[int, int]  #: The two members, ascending.
    #: `o`, `z`: shape (3,). A point on the axis and its direction, in `part`, mm.
    o: FloatArray
    z: FloatArray
    #: `low`, `high`: Where the pressed faces may be along the axis, measured from `o`, mm.
    low: float
    high: float
    bolts: int  #: Number of bolts here that hold both members.
    holes: int  #: Number of their holes that line up here.
    far_walls: int  #: Number of the two members in which the hole goes on through the far wall of a tube.

    def holds(self, p: FloatArray, beside_mm: float) -> bool:
        """Tell whether most of the points p, shape (n, 3), are in one plane across the axis, between its two ends."""
        along = (p - self.o) @ self.z
        middle = float(np.median(along))
        flat = (np.abs(along - middle) <= beside_mm).mean() >= MOST_OF_SEAM
        return bool(flat and self.low - beside_mm <= middle <= self.high + beside_mm)


def find_bolt_holes(graph: BrepGraph, trimmed: TrimmedFaces) -> Holes:
    """Find the round holes and the slots for bolts in all solids."""
    round_ = graph.face_kind == SurfaceKind.CYLINDER
    faces = np.flatnonzero(round_ & (graph.face_outward < 0) & (graph.face_param[:, 0] <= LARGEST_HOLE_MM))
    z, foot = _axes(graph, faces)
    low, high, sectors, side = _extents(graph, trimmed, faces, z)
    place = np.column_stack([foot, z * (COAXIAL_MM / COAXIAL_SIN), low, high, graph.face_param[faces, 0]])
    groups = _alike(place, graph.face_solid[faces])
    found = [(own[0], own[0], faces[own]) for own in groups if _count(sectors, own) >= WHOLE]
    halves = [own for own in groups if HALF[0] <= _count(sectors, own) <= HALF[1]]
    found += _slots(halves, place, graph.face_solid[faces], foot, side, faces)
    r, e = (np.array([one[k] for one in found], dtype=np.int64) for k in (0, 1))
    return Holes(
        graph.face_solid[faces[r]], foot[r], foot[e], z[r], graph.face_param[faces[r], 0], low[r], high[r],
        _are_bosses(graph, faces[r], z[r], foot[r]) & (r == e),
        _pins(graph, trimmed, z[r], foot[r], (low[r] + high[r]) / 2), tuple(one[2] for one in found),
    )  # fmt: skip


def _count(sectors: BoolArray, own: IntArray) -> int:
    return int(sectors[own].any(axis=0).sum())


def _alike(place: FloatArray, solid: IntArray) -> list[IntArray]:
    """Return groups of rows of one solid at the same place, within `COAXIAL_MM`."""
    n = len(place)
    if n == 0:
        return []
    pairs = near_pairs(place, COAXIAL_MM)
    pairs = pairs[solid[pairs[:, 0]] == solid[pairs[:, 1]]]
    label = linked_groups(n, *pairs.T)
    order = np.argsort(label, kind="stable")
    return np.split(order, np.searchsorted(label[order], np.arange(1, label.max() + 1)))


def _slots(
    halves: list[IntArray], place: FloatArray, solid: IntArray, foot: FloatArray, side: FloatArray, faces: IntArray
) -> list[tuple[int, int, IntArray]]:
    """Return the slots: two half rounds of one solid that bulge away from each other, the nearest such pairs."""
    found, taken = [], set[int]()
    tree = near_tree(np.array([foot[own[0]] for own in halves]).reshape(-1, 3))
    for a, first in enumerate(halves):
        i = int(first[0])
        best = None
        for b in sorted(tree.query_ball_point(foot[i], LONGEST_SLOT_MM)):
            k = int(halves[b][0])
            run = foot[k] - foot[i]
            length = float(np.linalg.norm(run))
            if b == a or solid[i] != solid[k] or np.abs(place[i, 3:] - place[k, 3:]).max() > COAXIAL_MM or length == 0:
                continue
            apart = float(side[i] @ run) / length < -APART and float(side[k] @ run) / length > APART
            if apart and (best is None or length < best[0]):
                best = (length, b, k)
        if best is not None and not {a, best[1]} & taken:
            taken |= {a, best[1]}
            found.append((i, best[2], faces[np.concatenate([first, halves[best[1]]])]))
    return found


def _axes(graph: BrepGraph, faces: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return the directions of axes, the largest component positive, and their points nearest to the origin."""
    z = graph.face_frame[faces, 3]
    largest = np.take_along_axis(z, np.argmax(np.round(np.abs(z), 6), axis=1)[:, None], axis=1)
    z = z * np.where(largest < 0, -1.0, 1.0)
    o = graph.face_frame[faces, 0]
    return z, part_across(o, z)


def _extents(
    graph: BrepGraph, trimmed: TrimmedFaces, faces: IntArray, z: FloatArray
) -> tuple[FloatArray, FloatArray, BoolArray, FloatArray]:
    """Return where the boundary of each face begins and ends along its axis, its sectors, and where it bulges."""
    low, high = np.zeros(len(faces)), np.zeros(len(faces))
    sectors, side = np.zeros((len(faces), SECTORS), dtype=bool), np.zeros((len(faces), 3))
    share = np.linspace(0.0, 1.0, PIECES_OF_ARC, endpoint=False)[:, None, None]
    for row, face in enumerate(faces.tolist()):
        own = slice(trimmed.start[face], trimmed.start[face + 1])
        p0, p1 = trimmed.p0[own], trimmed.p1[own]
        if len(p0) == 0:
            continue
        along = np.concatenate([p0, p1]) @ z[row]
        low[row], high[row] = along.min(), along.max()
        arm = ((1.0 - share) * p0 + share * p1).reshape(-1, 3) - graph.face_frame[face, 0]
        across = arm.mean(axis=0) - (arm.mean(axis=0) @ z[row]) * z[row]
        side[row] = across / max(float(np.linalg.norm(across)), 1e-12)
        angle = np.arctan2(arm @ graph.face_frame[face, 2], arm @ graph.face_frame[face, 1])
        # The same sectors for every face about one axis: measured from a direction that depends on the axis only.
        turn = np.arctan2(_zero(z[row]) @ graph.face_frame[face, 2], _zero(z[row]) @ graph.face_frame[face, 1])
        hand = np.sign(z[row] @ graph.face_frame[face, 3])
        sectors[row, (np.mod(hand * (angle - turn), 2 * np.pi) / (2 * np.pi) * SECTORS).astype(int) % SECTORS] = True
    return low, high, sectors, side


def _zero(z: FloatArray) -> FloatArray:
    """Return a direction across an axis."""
    across: FloatArray = np.eye(3)[int(np.argmin(np.round(np.abs(z), 6)))]
    return across


def _are_bosses(graph: BrepGraph, faces: IntArray, z: FloatArray, foot: FloatArray) -> BoolArray:
    """Tell which holes have an outer round of the same solid about their axis."""
    outer = np.flatnonzero((graph.face_kind == SurfaceKind.CYLINDER) & (graph.face_outward > 0))
    of_solid: dict[int, list[int]] = defaultdict(list)
    for face in outer.tolist():
        of_solid[int(graph.face_solid[face])].append(face)
    found = np.zeros(len(faces), dtype=bool)
    for row, face in enumerate(faces.tolist()):
        own = np.array(of_solid[int(graph.face_solid[face])], dtype=np.int64)
        if len(own):
            off = off_axis(graph.face_frame[own, 0], foot[row], z[row])
            along = np.abs(graph.face_frame[own, 3] @ z[row]) > 1 - COAXIAL_SIN
            found[row] = bool((along & (off <= COAXIAL_MM)).any())
    return found


def _pins(graph: BrepGraph, trimmed: TrimmedFaces, z: FloatArray, foot: FloatArray, middle: FloatArray) -> IntArray:
    """Return the solid of which a round bar goes through each hole, one without a bore; -1 where there is none."""
    round_ = np.flatnonzero(graph.face_kind == SurfaceKind.CYLINDER)
    bored = graph.face_solid[round_[graph.face_outward[round_] < 0]]
    bars = round_[~np.isin(graph.face_solid[round_], bored)]
    found = np.full(len(z), -1)
    for row in range(len(z)):
        on = bars[off_axis(graph.face_frame[bars, 0], foot[row], z[row]) <= COAXIAL_MM]
        for bar in on[np.abs(graph.face_frame[on, 3] @ z[row]) > 1 - COAXIAL_SIN].tolist():
            at = trimmed.heights(bar, z[row]) - middle[row]
            found[row] = graph.face_solid[bar] if len(at) and at.min() < 0.0 < at.max() else found[row]
    return found


def find_clamps(holes: Holes, fasteners: Mapping[int, Fastener]) -> tuple[Clamp, ...]:
    """Find the places at which bolts, or holes for them, hold two members together.

    Returns: Those of bolts first. A bolt holds the members that it goes through, and those on which its head, its nuts
    and its washers lie. Of bores of rings, bosses and pipes only those of the knuckles of hinges count.
    """
    held: dict[int, set[int]] = defaultdict(set)
    for fastener in fasteners.values():
        held[fastener.pin] |= (fastener.through | fastener.on) - fasteners.keys()
    clamps: list[Clamp] = []
    for pin, members in sorted(held.items()):
        bolt = fasteners[pin]
        pairs = combinations(sorted(members), 2)
        clamps += [Clamp(pair, bolt.o, bolt.z, bolt.low, bolt.high, 1, 0, 0) for pair in pairs]
    return (*clamps, *_holes_in_line(holes, fasteners))


def _holes_in_line(holes: Holes, fasteners: Mapping[int, Fastener]) -> Iterator[Clamp]:
    """Yield where the holes of two members meet on one axis, the knuckles of hinges, and the pins of links."""
    knuckles, linked = defaultdict[object, list[Clamp]](list), set[tuple[int, float]]()
    for a, b in _coaxial(holes):
        pair, meets = tuple(sorted(holes.solid[[a, b]].tolist())), _meeting(holes, a, b)
        if meets is None or {*pair} & fasteners.keys():
            continue
        bosses = int(holes.is_boss[a]) + int(holes.is_boss[b])
        clamp = Clamp(pair, holes.o[a], holes.z[a], meets, meets, 0, max(bosses, 1), 0)
        if holes.pin[a] == holes.pin[b] >= 0 and int(holes.pin[a]) not in fasteners:
            yield replace(clamp, bolts=1, holes=0)
            linked.update((int(holes.solid[row]), round(float(holes.radius[row]), 2)) for row in (a, b))
        elif bosses == HINGED:
            knuckles[pair].append(clamp)
        elif bosses == 0:
            yield replace(clamp, far_walls=_has_far_wall(holes, a) + _has_far_wall(holes, b))
    for own in knuckles.values():
        yield from (one for one in own if sum(_is_on_axis_of(one, other) for other in own) >= HINGED)
    yield from _pins_of_links(holes, linked, fasteners)


def _pins_of_links(holes: Holes, linked: set[tuple[int, float]], fasteners: Mapping[int, Fastener]) -> Iterator[Clamp]:
    """Yield where pins hold links, members of two pins; `linked`: solid and radius of the holes that meet."""
    for row in np.flatnonzero(~np.isin(holes.pin, [-1, *fasteners])).tolist():
        solid, pin = int(holes.solid[row]), int(holes.pin[row])
        is_link = len(np.unique(holes.pin[(holes.solid == solid) & (holes.pin >= 0)])) > 1
        if is_link and (solid, round(float(holes.radius[row]), 2)) in linked:
            ends = float(holes.low[row]), float(holes.high[row])
            yield Clamp((min(solid, pin), max(solid, pin)), holes.o[row], holes.z[row], *ends, 1, 0, 0)


def _is_on_axis_of(one: Clamp, other: Clamp) -> bool:
    turn = np.linalg.norm(np.cross(one.z, other.z))
    return bool(turn <= COAXIAL_SIN and (off_axis(one.o[None], other.o, other.z) <= 2 * COAXIAL_MM).all())


def _has_far_wall(holes: Holes, row: int) -> bool:
    """Tell whether a hole goes on through another wall of its solid: equal holes on one axis, one after the other."""
    same = (holes.solid == holes.solid[row]) & (np.abs(holes.radius - holes.radius[row]) <= COAXIAL_MM)
    same &= np.linalg.norm(holes.o - holes.o[row], axis=1) <= COAXIAL_MM
    same &= np.linalg.norm(np.cross(holes.z, holes.z[row]), axis=1) <= COAXIAL_SIN
    return bool((same & ((holes.low > holes.high[row]) | (holes.high < holes.low[row]))).any())


def _coaxial(holes: Holes) -> list[tuple[int, int]]:
    """Return pairs of holes of different solids on one axis, of similar diameter; slots count along their length."""
    if len(holes) < 2:
        return []
    scaled = np.column_stack([(holes.o + holes.end) / 2, holes.z * (COAXIAL_MM / COAXIAL_SIN)])
    tree = near_tree(scaled)
    pairs = set(map(tuple, tree.query_pairs(3 * COAXIAL_MM, output_type="ndarray").tolist()))
    reach = np.linalg.norm(holes.end - holes.o, axis=1) / 2
    for slot in np.flatnonzero(reach > 0).tolist():
        near = tree.query_ball_point(scaled[slot], reach[slot] + 3 * COAXIAL_MM)
        pairs |= {(min(slot, other), max(slot, other)) for other in near if other != slot}
    found = []
    for a, b in sorted(pairs):
        ratio = holes.radius[a] / holes.radius[b]
        if holes.solid[a] == holes.solid[b] or not 1 / WIDEST_RATIO <= ratio <= WIDEST_RATIO:
            continue
        if np.linalg.norm(np.cross(holes.z[a], holes.z[b])) > COAXIAL_SIN:
            continue
        if _off(holes, a, b) <= 2 * COAXIAL_MM or _off(holes, b, a) <= 2 * COAXIAL_MM:
            found.append((a, b))
    return found


def _off(holes: Holes, slot: int, hole: int) -> float:
    """Return the distance of the middle of a hole from the line along which the axis of a slot runs, mm."""
    run = holes.end[slot] - holes.o[slot]
    arm = (holes.o[hole] + holes.end[hole]) / 2 - holes.o[slot]
    length = float(run @ run)
    share = min(max(float(arm @ run) / length, 0.0), 1.0) if length > 0 else 0.0
    return float(np.linalg.norm(arm - share * run))


def _meeting(holes: Holes, a: int, b: int) -> float | None:
    """Return where along the axis one hole ends and the other begins; None if they do not meet there."""
    for first, second in ((a, b), (b, a)):
        if abs(holes.high[first] - holes.low[second]) <= MEETING_MM and holes.low[first] < holes.high[second]:
            return float(holes.high[first] + holes.low[second]) / 2
    return None
