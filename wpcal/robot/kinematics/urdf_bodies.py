"""The bodies of a robot from its URDF file: the collision shapes of its links, as corners of convex hulls.

Meshes are STL files, binary or text. A link that is far from convex, as the frame of a positioner, becomes several
hulls: slices of its surface across one axis. Boxes, cylinders and spheres become their corners, the round ones those of
a polyhedron around them.
"""

from __future__ import annotations

import struct
import xml.etree.ElementTree as ET
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull, QhullError

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes
from wpcal.core.numbers import parse_number
from wpcal.core.same_bits import length, product
from wpcal.core.wording import shown
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.forward import start_frames, walk
from wpcal.robot.kinematics.urdf import LARGEST_M, MM_PER_M, link_places, origin_pose, urdf_root
from wpcal.robot.surface_points import surface_points

STL_HEAD, STL_TRIANGLE = 84, 50  #: Bytes of the head of a binary STL file, and of each triangle.
ROUND_CORNERS = 24  #: Corners around a cylinder or a sphere.
SLICES = 8  #: Slices of a link that is not convex.
SAMPLE_MM = 5.0
"""Points on a mesh are this close; slices overlap by as much, so that nothing of the surface is between two."""
LEAST_SAVED = 0.6  #: Slices are taken if they hold less than this part of the volume of one hull.
NEAR_MM = 0.5  #: Corners of a hull that are nearer than this to a corner that is kept are left out ...
HULL_DIGITS = 2  #: ... and the others are written with this many decimals of a millimetre.


@dataclass(frozen=True, slots=True, eq=False)
class LinkHull:
    """A convex hull of one link, or of a slice of it."""

    name: str  #: Of the link in the URDF file, with a number if it has several hulls.
    link: int  #: 0 for the base, i for the link that joint i moves.
    #: shape (m, 3). Corners in the frame after link i of the arm's chain (0: the base; the last: the flange), mm.
    hull: FloatArray


def read_link_hulls(path: Path, arm: Arm) -> tuple[LinkHull, ...]:
    """Read the collision shapes of a URDF file, or its visual shapes where a link has no other, shapes are left out..

    Raises `InputError` when a mesh cannot be opened.
    Raises `FormatError` when a mesh is not an STL file, or a shape is not as the format says.
    """
    root = urdf_root(path)
    places, frames = link_places(root), _frames_at_zero(arm)
    found = []
    for element in root.findall("link"):
        name = element.get("name", "?")
        shapes = element.findall("collision") or element.findall("visual")
        if not shapes or name not in places:
            continue
        moving, T_base_link = places[name]
        if moving >= len(frames):
            continue
        T = np.linalg.inv(frames[moving]) @ T_base_link
        hulls = [
            hull_corners(piece @ T[:3, :3].T + T[:3, 3])
            for shape in shapes
            for piece in _convex_pieces(_points(shape, path, name))
        ]
        names = [name] if len(hulls) == 1 else [f"{name} {row + 1}" for row in range(len(hulls))]
        found += [LinkHull(each, moving, hull) for each, hull in zip(names, hulls, strict=True)]
    return tuple(found)


def _convex_pieces(corners: FloatArray) -> list[FloatArray]:
    """Return points whose hulls together hold triangles (m, 3, 3): all of them, or slices if these hold much less."""
    points = corners.reshape(-1, 3)
    try:
        whole = ConvexHull(points).volume
    except (QhullError, ValueError):
        return [points]
    every = np.concatenate(surface_points(corners, SAMPLE_MM))
    best, least = [points], LEAST_SAVED * whole
    for axis in range(3):
        edges = np.linspace(every[:, axis].min(), every[:, axis].max(), SLICES + 1)
        pieces = [
            every[(every[:, axis] >= low - SAMPLE_MM) & (every[:, axis] <= high + SAMPLE_MM)]
            for low, high in pairwise(edges)
        ]
        try:
            volume = sum(ConvexHull(piece).volume for piece in pieces)
        except (QhullError, ValueError):
            continue
        if volume < least:
            best, least = pieces, volume
    return best


def _frames_at_zero(arm: Arm) -> list[FloatArray]:
    """Return the base, the frames after the links and the flange with all joints at zero, each (4, 4), mm."""
    motions = list(walk(start_frames(arm.chain.T_base_dh0, 1), arm.chain.table, np.zeros((len(arm.joints), 1))))
    last = motions[-1].frame.then(arm.chain.T_dhn_flange)
    return [np.eye(4), *(motion.frame.matrices()[0] for motion in motions[:-1]), last.matrices()[0]]


def hull_corners(points: FloatArray) -> FloatArray:
    """Return the corners of the convex hull of points, thinned to `NEAR_MM` and rounded.

    `points`: shape (n, 3). Any frame, mm.
    Returns ndarray, shape (m, 3). mm. The hull of these corners is inside the true one by less than `NEAR_MM`.
    Raises `FormatError` when the points lie in a plane.
    """
    try:
        corners = points[np.sort(ConvexHull(points).vertices)]
    except (QhullError, ValueError):
        raise FormatError("the points of a mesh lie in one plane or are too few") from None
    _, first = np.unique(np.floor(corners / NEAR_MM), axis=0, return_index=True)
    return np.asarray(np.round(corners[np.sort(first)], HULL_DIGITS) + 0.0, dtype=np.float64)


def _points(shape: ET.Element, path: Path, link: str) -> FloatArray:
    """Return the triangles of a shape in the frame of its link, shape (m, 3, 3), mm."""
    origin, geometry = shape.find("origin"), shape.find("geometry")
    T = np.eye(4) if origin is None else origin_pose(origin)
    kinds = [] if geometry is None else list(geometry)
    if not kinds:
        raise FormatError(f"link {link}: a shape without geometry", path=str(path))
    corners = _mesh(kinds[0], path, link) if kinds[0].tag == "mesh" else _primitive(kinds[0], path, link)
    return np.asarray(corners @ T[:3, :3].T + T[:3, 3], dtype=np.float64)


def _mesh(element: ET.Element, path: Path, link: str) -> FloatArray:
    name = element.get("filename", "")
    file = path.parent / name.removeprefix("file://")
    if name.startswith("package://"):
        raise InputError(f"{path}: link {link}: {name}: give the meshes by a path beside the file, not by a package")
    if file.suffix.lower() != ".stl":
        raise FormatError(f"link {link}: {shown(name)}: only meshes in STL files are read", path=str(path))
    scale = np.array([parse_number(cell, most=LARGEST_M) for cell in element.get("scale", "1 1 1").split()])
    if scale.shape != (3,):
        raise FormatError(f"link {link}: scale: expected three numbers", path=str(path))
    return np.asarray((read_stl(file) * scale * MM_PER_M).reshape(-1, 3, 3), dtype=np.float64)


def read_stl(path: Path) -> FloatArray:
    """Return the corners of the triangles of an STL file, shape (3 m, 3), in the file's unit.

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when it is neither a binary nor a text STL file.
    """
    raw = read_bytes(path)
    count = struct.unpack_from("<I", raw, STL_HEAD - 4)[0] if len(raw) >= STL_HEAD else -1
    if count > 0 and len(raw) == STL_HEAD + STL_TRIANGLE * count:
        rows = np.frombuffer(raw, dtype=np.uint8, offset=STL_HEAD).reshape(count, STL_TRIANGLE)
        points = rows[:, 12:48].copy().view("<f4").reshape(-1, 3).astype(np.float64)
    else:
        words = [line.split() for line in raw.decode("latin-1").splitlines()]
        cells = [word[1:4] for word in words if word[:1] == ["vertex"]]
        try:
            points = np.array(cells, dtype=np.float64).reshape(-1, 3)
        except ValueError:
            points = np.zeros((0, 3))
    if not len(points) or not np.isfinite(points).all():
        raise FormatError("is not an STL file", path=str(path))
    return points


def _primitive(element: ET.Element, path: Path, link: str) -> FloatArray:
    def number(text: str) -> float:
        return MM_PER_M * parse_number(text, most=LARGEST_M)

    around = 2 * np.pi * np.arange(ROUND_CORNERS) / ROUND_CORNERS
    out = 1.0 / np.cos(np.pi / ROUND_CORNERS)  # the polygon is around the circle
    ring = np.column_stack([np.cos(around), np.sin(around)]) * out
    if element.tag == "box":
        half = np.array([number(cell) for cell in element.get("size", "").split()]) / 2
        if half.shape == (3,):
            return _hull_triangles(np.array(np.meshgrid(*((-h, h) for h in half))).reshape(3, -1).T)
    elif element.tag == "cylinder":
        r, h = number(element.get("radius", "")), number(element.get("length", "")) / 2
        return _hull_triangles(
            np.concatenate([np.column_stack([ring * r, np.full(ROUND_CORNERS, z)]) for z in (-h, h)])
        )
    elif element.tag == "sphere":
        r = number(element.get("radius", "")) * out
        tilt = np.linspace(-np.pi / 2, np.pi / 2, ROUND_CORNERS // 2 + 1)
        rings = [np.column_stack([ring * r * np.cos(t), np.full(ROUND_CORNERS, r * out * np.sin(t))]) for t in tilt]
        return _hull_triangles(np.concatenate(rings))
    raise FormatError(f"link {link}: cannot read the shape {shown(element.tag)}", path=str(path))


def _hull_triangles(points: FloatArray) -> FloatArray:
    """Return the triangles of the convex hull of points, shape (m, 3, 3)."""
    return np.asarray(points[ConvexHull(points).simplices], dtype=np.float64)


UNEVEN = 1.0 + 1e-7 * np.arange(3.0)
"""Scales that tell the two equal directions of a round body apart, where otherwise round-off would."""


def capsule_around(points: ArrayLike) -> tuple[FloatArray, FloatArray, float]:
    """Return a capsule that contains points, and so their convex hull.

    The axis is parallel to a principal direction of the points, through the middle of their extent across it. Of the
    three principal directions the one with the least volume is taken. The capsule is not the smallest one.

    `points`: shape (n, 3). mm.
    Returns `p, q`: ndarray, shape (3,). Ends of the axis, mm.
    Returns `radius`: float. mm.
    """
    x = np.asarray(points, dtype=np.float64)
    directions = np.linalg.svd((x - x.mean(axis=0)) * UNEVEN, full_matrices=len(x) < 3)[2]
    return min((_capsule_along(x, np.roll(directions, -i, axis=0)) for i in range(3)), key=_volume)


def _capsule_along(x: FloatArray, axes: FloatArray) -> tuple[FloatArray, FloatArray, float]:
    """Return the capsule along the first of three axes (rows)."""
    local = product(x, axes.T)
    middle = (local.min(axis=0) + local.max(axis=0)) / 2
    across = np.sqrt((local[:, 1] - middle[1]) ** 2 + (local[:, 2] - middle[2]) ** 2)
    radius = float(across.max())
    cap = np.sqrt(np.maximum(radius**2 - across**2, 0.0))
    low, high = (local[:, 0] + cap).min(), (local[:, 0] - cap).max()  # both ends as far inwards as all points allow
    if low > high:
        low = high = (low + high) / 2
    ends = product(np.array([[low, middle[1], middle[2]], [high, middle[1], middle[2]]]), axes)
    return ends[0], ends[1], radius


def _volume(capsule: tuple[FloatArray, FloatArray, float]) -> float:
    p, q, radius = capsule
    return float(np.pi * radius**2 * (length(q - p) + 4.0 / 3.0 * radius))
