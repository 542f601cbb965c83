"""Where a part can be touched: points on faces, and how the wire is held there.

The wire makes the angle φ with the way of the search, which is the reversed outward normal. At φ = 0 its end meets the
face. At 90° its side would lie along the face. Below that the rim of its end meets the face, the tool centre point
``sin φ`` radii away from it, and an error of the stick-out counts with ``cos φ``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wpcal.brep.curves import evaluate_edges
from wpcal.brep.graph import BrepGraph, CurveKind, SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, Columns, FloatArray, IntArray
from wpcal.touch.plan.options import NominalError, TouchOptions, displacement_mm
from wpcal.touch.plan.part import PartPlace

BORDER_MM = 3.0  #: A touch stays this much farther from the border of its face than the part may be displaced.
LEAST_FACE_MM = 4.0
"""No face whose box is shorter than this along its longest side is touched: rounds, chamfers, screws."""
ANGLES = np.radians([0.0, 35.0, 60.0, 85.0])
"""φ: the end of the wire, two ways of leaning, and the side. All but the first are 20° and more away from the way.

At the side the tip is 5° nearer. Of a wire along the face any place would touch first when the part is turned: 0.05 mm
off at 10 mm of wire and 0.3°.
"""
FLAT_SIN = math.sin(math.radians(20.0))
"""A face whose normal is nearer to the vertical than this has no direction downwards: the wire leans four ways."""
GRID = 9
"""Points along each side of a face. Those at its corners count most, and the others are there for faces with holes."""
EDGE_SHARES = np.linspace(0.06, 0.94, 9)
"""Places along an edge from which touches with the side of the wire are sunk into the face below it."""
LEAST_LEAN_RAD = math.radians(4.5)
"""The tip touches first if the wire leans by more than the part may be turned, and a round face turns away under it."""
FREE_FORM_TURN_RAD = math.radians(20.0)
"""A free-form face is taken to turn by this within a displacement: it is touched with the end or a leaning wire."""
CLOSE_MM = 1.0  #: A place whose nearest point on the face is farther away has left the face.
WORDS = {SurfaceKind.PLANE: "plane", SurfaceKind.SPHERE: "sphere"}
"""What a face is in the words of a taught table; a cylinder is a hole if it is hollow."""


@dataclass(frozen=True, slots=True, eq=False)
class TouchPlaces(Columns):
    """n places to touch with a way to hold the wire; all in `part`."""

    face: IntArray  #: shape (n,).
    p: FloatArray  #: shape (n, 3). On the face, mm.
    normal: FloatArray  #: shape (n, 3). Outward.
    wire: FloatArray  #: shape (n, 3). Unit vectors that leave the tip of the wire: z of the tool.
    #: `normal_mm`, `along_mm`, `across_mm`: shape (n,). 99 % displacement of the part there: along the normal, along
    #: the wire in the face, and across it.
    normal_mm: FloatArray
    along_mm: FloatArray
    across_mm: FloatArray
    #: shape (n,). 99 % displacement along the normal of another body that moves as far as this one; 0 if none moves.
    apart_mm: FloatArray

    def __len__(self) -> int:
        return len(self.face)

    @property
    def cos_angle(self) -> FloatArray:
        """Cosine of φ, shape (n,)."""
        return np.asarray(-np.einsum("ni,ni->n", self.wire, self.normal))

    @property
    def ways(self) -> tuple[FloatArray, FloatArray]:
        """Unit vectors in the face, (n, 3) each: along the wire, or any where its end touches; and across it."""
        along = self.wire + self.cos_angle[:, None] * self.normal
        end = np.linalg.norm(along, axis=1) < 1e-6
        along[end] = np.cross(self.normal[end], np.eye(3)[np.argmin(np.abs(self.normal[end]), axis=1)])
        along = _unit(along)
        return along, np.cross(self.normal, along)

    @property
    def is_side(self) -> BoolArray:
        """Whether the wire lies along the face."""
        return np.asarray(self.cos_angle < math.cos(math.radians(80.0)))


def word_of(graph: BrepGraph, face: int) -> str:
    """Return what a face is in the words of a taught table."""
    kind = SurfaceKind(int(graph.face_kind[face]))
    if kind is SurfaceKind.CYLINDER:
        return "hole" if graph.face_outward[face] < 0 else "cylinder"
    return WORDS.get(kind, "surface")


def face_words(graph: BrepGraph, contacts: TouchPlaces, face: int) -> str:
    """Say which face is meant: ``the plane of web at (100 60 50)``."""
    p = contacts.p[contacts.face == face].mean(axis=0)
    at = " ".join(f"{round(float(v), 1) + 0.0:g}" for v in p)
    return f"the {word_of(graph, face)} of {graph.solid_names[graph.face_solid[face]]} at ({at})"


def find_places(
    graph: BrepGraph, trimmed: TrimmedFaces, place: PartPlace, options: TouchOptions
) -> tuple[TouchPlaces, TouchPlaces]:
    """Find the places that a displaced part is still touched at.

    Returns `held, small`: TouchPlaces. Those with room around them, and those on faces where no place has it.
    """
    low, high = trimmed.face_box
    with np.errstate(invalid="ignore"):
        size = (high - low).max(axis=1)
    faces = np.flatnonzero((graph.face_kind != SurfaceKind.NONE) & (size >= LEAST_FACE_MM) & np.isfinite(size))
    face, p, normal = _grid(graph, trimmed, faces)
    sunk_face, sunk = _below_edges(graph, faces, place, options.nominal)
    foot = project_to_faces(graph, sunk_face, sunk)
    face = np.concatenate([face, sunk_face])
    p, normal = np.concatenate([p, foot.p]), np.concatenate([normal, foot.normal])
    inside = trimmed.contains(face, project_to_faces(graph, face, p).uv)
    face, p, normal = face[inside], p[inside], normal[inside]
    found = _with_wires(graph, face, p, normal, place, options)
    room = _has_room(graph, trimmed, found)
    held = found.select(room)
    return held, found.select(~np.isin(found.face, held.face))


def _grid(graph: BrepGraph, trimmed: TrimmedFaces, faces: IntArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return points on faces: a grid in the box around each one, projected on its surface."""
    low, high = (corner[faces] for corner in trimmed.face_box)
    middle, half = (low + high) / 2.0, (high - low) / 2.0
    frame = graph.face_frame[faces, 1:]
    flat = graph.face_kind[faces] == SurfaceKind.PLANE
    step = np.linspace(-0.97, 0.97, GRID)
    a, b = (axis.ravel() for axis in np.meshgrid(step, step))
    zero = np.zeros_like(a)
    found_face, found = [], []
    reach = np.einsum("mij,mj->mi", np.abs(frame), half)  # of the box along the axes of the face
    plane = np.stack([a, b, zero], axis=1)
    own = np.flatnonzero(flat)
    found.append(np.einsum("kj,mj,mji->mki", plane, reach[own], frame[own]) + middle[own, None])
    found_face.append(np.repeat(faces[own], len(a)))
    coarse = np.linspace(-0.97, 0.97, 5)
    cube = np.stack([axis.ravel() for axis in np.meshgrid(coarse, coarse, coarse)], axis=1)
    own = np.flatnonzero(~flat)
    found.append(np.einsum("kj,mj,mji->mki", cube, reach[own], frame[own]) + middle[own, None])
    found_face.append(np.repeat(faces[own], len(cube)))
    face = np.concatenate(found_face)
    foot = project_to_faces(graph, face, np.concatenate([each.reshape(-1, 3) for each in found]))
    return face, foot.p, foot.normal


def _below_edges(
    graph: BrepGraph, faces: IntArray, place: PartPlace, nominal: NominalError
) -> tuple[IntArray, FloatArray]:
    """Return places in steep faces, as far below their edges as a touch with the side of the wire needs at least."""
    row = np.flatnonzero(
        np.isin(graph.coedge_face, faces) & (graph.edge_kind[graph.coedge_edge] != CurveKind.DEGENERATE)
    )
    face, edge = (np.repeat(values[row], len(EDGE_SHARES)) for values in (graph.coedge_face, graph.coedge_edge))
    share = np.tile(EDGE_SHARES, len(row))
    t = graph.edge_range[edge, 0] * (1 - share) + graph.edge_range[edge, 1] * share
    p = evaluate_edges(graph, edge, t)[0]
    normal = project_to_faces(graph, face, p).normal
    down = _downwards(normal, place.up)
    steep = np.linalg.norm(np.cross(normal, place.up), axis=1) > FLAT_SIN
    face, p, down = face[steep], p[steep], down[steep]
    along = displacement_mm(place.covariances(p, face, nominal), down)
    return face, p + (along + BORDER_MM + 0.1)[:, None] * down


def _downwards(normal: FloatArray, up: FloatArray) -> FloatArray:
    """Return the steepest way down in faces, shape (n, 3); any direction in a level face."""
    down = -(up - (normal @ up)[:, None] * normal)
    length = np.linalg.norm(down, axis=1, keepdims=True)
    other = np.cross(normal, np.eye(3)[np.argmin(np.abs(normal), axis=1)])
    return np.asarray(np.where(length > FLAT_SIN / 10, down / np.maximum(length, 1e-12), _unit(other)))


def _unit(v: FloatArray) -> FloatArray:
    return np.asarray(v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-12))


def _with_wires(
    graph: BrepGraph, face: IntArray, p: FloatArray, normal: FloatArray, place: PartPlace, options: TouchOptions
) -> TouchPlaces:
    """Hold the wire in all ways at places, those with the torch too low left out."""
    up = place.up
    down = _downwards(normal, up)
    level = np.linalg.norm(np.cross(normal, up), axis=1) <= FLAT_SIN
    looks_up = normal @ up >= -FLAT_SIN  # no wire searches upwards below an overhang
    hollow = (graph.face_kind[face] == SurfaceKind.CYLINDER) & (graph.face_outward[face] < 0)
    rows, wires = [], []
    for angle in ANGLES:
        for turn in range(4 if angle > 0 else 1):
            tangent = math.cos(turn * math.pi / 2) * down + math.sin(turn * math.pi / 2) * np.cross(normal, down)
            wire = -math.cos(angle) * normal + math.sin(angle) * tangent
            upright = wire @ up <= -math.cos(options.most_tilt_rad) + 1e-9
            upright &= ((turn == 0) | level) & looks_up & (~hollow | (angle == ANGLES[-1]))
            if angle > 0:
                upright &= math.pi / 2 - angle >= LEAST_LEAN_RAD + _turn_along(graph, face, p, tangent, place, options)
            rows.append(np.flatnonzero(upright))
            wires.append(wire[upright])
    row, wire = np.concatenate(rows), np.concatenate(wires)
    p, normal = p[row], normal[row]
    tangent = _unit(wire - np.einsum("ni,ni->n", wire, normal)[:, None] * normal)
    end = np.linalg.norm(wire + normal, axis=1) < 1e-6
    tangent[end] = _unit(np.cross(normal[end], np.eye(3)[np.argmin(np.abs(normal[end]), axis=1)]))
    own = place.of_bodies(p, face[row])
    covariance = options.nominal.covariances(p, place.centre) + own
    moved, aside = displacement_mm(covariance, tangent), displacement_mm(covariance, np.cross(normal, tangent))
    apart = displacement_mm(2.0 * own, normal)
    return TouchPlaces(face[row], p, normal, wire, displacement_mm(covariance, normal), moved, aside, apart)


def _turn_along(
    graph: BrepGraph, face: IntArray, p: FloatArray, way: FloatArray, place: PartPlace, options: TouchOptions
) -> FloatArray:
    """Return by how much round faces turn away under a wire that is displaced along it, rad, shape (n,).

    A free-form face may turn by any angle that a leaning wire still allows, so its side does not touch it.
    """
    kind, (a, b) = graph.face_kind[face], graph.face_param[face].T
    radius = np.where(kind == SurfaceKind.TORUS, b, a)
    axis = graph.face_frame[face, 3]
    straight = np.einsum("ni,ni->n", way, axis) ** 2 * np.isin(kind, (SurfaceKind.CYLINDER, SurfaceKind.CONE))
    moved = displacement_mm(place.covariances(p, face, options.nominal), way)
    turn = (1.0 - straight) * moved / np.maximum(radius, 1e-3)
    turn[(kind == SurfaceKind.PLANE) | (graph.face_outward[face] < 0)] = 0.0
    turn[kind == SurfaceKind.NURBS] = FREE_FORM_TURN_RAD
    return np.asarray(turn)


def surface_labels(graph: BrepGraph) -> IntArray:
    """Return a number for each face, the same for faces of one solid on one plane, cylinder, cone, ball or ring."""
    origin, axis = graph.face_frame[:, 0], graph.face_frame[:, 3]
    round_ = np.isin(graph.face_kind, (SurfaceKind.CYLINDER, SurfaceKind.CONE))
    along = np.einsum("ni,ni->n", origin, axis)[:, None] * axis
    foot = np.where(
        round_[:, None], origin - along, np.where(graph.face_kind[:, None] == SurfaceKind.PLANE, along, origin)
    )
    own = np.where(graph.face_kind >= SurfaceKind.NURBS, np.arange(graph.face_count), -1)
    sense = np.where(axis[np.arange(len(axis)), np.argmax(np.abs(axis), axis=1)] < 0, -1.0, 1.0)[:, None]
    columns = [graph.face_solid, graph.face_kind, graph.face_outward, own]
    rows = np.column_stack([*columns, np.round(np.column_stack([foot, sense * axis, graph.face_param]), 3) + 0.0])
    return np.asarray(np.unique(rows, axis=0, return_inverse=True)[1]).ravel()


def _has_room(graph: BrepGraph, trimmed: TrimmedFaces, contacts: TouchPlaces) -> BoolArray:
    """Tell where a displaced part is still touched on the same face.

    The tip or rim of the wire needs its room on all sides. The side of the wire needs room across; along the wire it
    reaches over the border, so the face only has to begin below it.
    """
    side = contacts.is_side
    room = np.ones(len(contacts), dtype=bool)
    rows = np.flatnonzero(~side)
    need = np.hypot(contacts.along_mm, contacts.across_mm)[rows] + BORDER_MM
    far = float(need.max()) if len(rows) else 0.0
    room[rows] = trimmed.boundary_distance(contacts.face[rows], contacts.p[rows], within_mm=far) >= need
    rows = np.flatnonzero(side)
    own = contacts.select(rows)
    along, across = own.ways
    hollow = (graph.face_kind[own.face] == SurfaceKind.CYLINDER) & (graph.face_outward[own.face] < 0)
    above = own.p - (own.along_mm + BORDER_MM)[:, None] * along
    for share in (-1.0, 0.0, 1.0):
        aside = np.where(hollow, 0.0, share * (own.across_mm + BORDER_MM))[:, None] * across
        room[rows] &= _is_on(graph, trimmed, own.face, above + aside)
    below = _is_on(graph, trimmed, own.face, own.p + own.along_mm[:, None] * along)
    sure = np.isin(contacts.face, own.face[room[rows] & below])  # on a thin plate the tip may also pass below
    room[rows] &= below | ~sure[rows]
    return room


def _is_on(graph: BrepGraph, trimmed: TrimmedFaces, face: IntArray, points: FloatArray) -> BoolArray:
    """Tell which points, shape (m, 3), are beside their plane face or at any distance of their round one, inside it."""
    foot = project_to_faces(graph, face, points)
    near = np.linalg.norm(foot.p - points, axis=1) <= CLOSE_MM
    round_ = graph.face_kind[face] != SurfaceKind.PLANE
    return np.asarray(trimmed.contains(face, foot.uv) & (round_ | near), dtype=bool)
