"""How far a cut wire can be pushed along a line until it meets triangles.

The wire is a cylinder with a flat end. What of it can meet a triangle first: its end or its side at a corner of a
triangle, a point of a rim at the inside of a triangle, or a rim or side at an edge. Rims are polygons whose first
corner is on the side to which the wire is pushed, so that a push straight into a plane is exact.
"""

import numpy as np

from tests.touch_robots.solid import Array

CORNERS = 90  #: Of a rim; 1 µm less than round at most, at the other places than the first.
TINY = 1e-12


def way_to_contact(near: Array, tip: Array, tail: Array, radius: float, along: Array) -> float:
    """Return how far the wire is pushed along the unit vector `along` until it meets a triangle; infinite if never."""
    if len(near) == 0:
        return np.inf
    axis = (tip - tail) / np.linalg.norm(tip - tail)
    first = along - (along @ axis) * axis
    if np.linalg.norm(first) < 1e-9:
        first = np.cross(axis, np.eye(3)[np.argmin(np.abs(axis))])
    first /= np.linalg.norm(first)
    angle = 2 * np.pi * np.arange(CORNERS) / CORNERS
    ring = radius * (np.cos(angle)[:, None] * first + np.sin(angle)[:, None] * np.cross(axis, first))
    front, back = tip + ring, tail + ring
    edges = np.concatenate([near[:, [0, 1]], near[:, [1, 2]], near[:, [2, 0]]])
    edges = np.unique(np.round(edges, 9), axis=0)
    return min(
        _points_to_triangles(np.concatenate([front, back, tip[None]]), near, along),
        _corners_to_wire(near.reshape(-1, 3), tip, tail, axis, radius, along),
        _edges_to_edges(front, np.roll(front, -1, axis=0), edges, along),
        _edges_to_edges(back, front, edges, along),
    )


def _points_to_triangles(points: Array, near: Array, along: Array) -> float:
    """Rays against triangles (Möller and Trumbore 1997)."""
    u, v = near[:, 1] - near[:, 0], near[:, 2] - near[:, 0]
    across = np.cross(along, v)
    size = np.einsum("ni,ni->n", u, across)
    hit = np.abs(size) > TINY
    near, u, v, across, size = near[hit], u[hit], v[hit], across[hit], size[hit]
    offset = points[:, None] - near[None, :, 0]
    a = np.einsum("mni,ni->mn", offset, across) / size
    turned = np.cross(offset, u[None])
    b = np.einsum("mni,i->mn", turned, along) / size
    way = np.einsum("mni,ni->mn", turned, v) / size
    inside = (a >= -TINY) & (b >= -TINY) & (a + b <= 1.0 + TINY) & (way >= 0.0)
    return float(way[inside].min(initial=np.inf))


def _corners_to_wire(corners: Array, tip: Array, tail: Array, axis: Array, radius: float, along: Array) -> float:
    """Corners of triangles against the side and the end of the wire."""
    length = float(np.linalg.norm(tip - tail))
    w = corners - tip
    height, fall = w @ axis, float(along @ axis)
    round_w, round_u = w - height[:, None] * axis, along - fall * axis
    a, b = float(round_u @ round_u), round_w @ round_u
    c = np.einsum("ni,ni->n", round_w, round_w) - radius**2
    found = np.inf
    root = b * b - a * c
    if a > TINY:
        good = root >= 0.0
        way = (b[good] - np.sqrt(root[good])) / a
        z = height[good] - way * fall
        found = float(way[(way >= 0.0) & (z <= 0.0) & (z >= -length)].min(initial=found))
    if fall > TINY:
        way = height / fall
        at = round_w - way[:, None] * round_u
        found = float(way[(way >= 0.0) & (np.einsum("ni,ni->n", at, at) <= radius**2)].min(initial=found))
    return found


def _edges_to_edges(starts: Array, ends: Array, edges: Array, along: Array) -> float:
    """Segments of the wire against edges of triangles: where both meet after a push."""
    d, e = ends - starts, edges[:, 1] - edges[:, 0]
    normal = np.cross(e, along)
    size = np.einsum("mi,ni->mn", d, normal)
    offset = edges[None, :, 0] - starts[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.einsum("mni,ni->mn", offset, normal) / size
        turned = np.cross(d[:, None], along)
        q = np.einsum("mni,mi->mn", offset, turned[:, 0]) / -np.einsum("ni,mi->mn", e, turned[:, 0])
        met = offset + q[..., None] * e[None] - s[..., None] * d[:, None]
        way = np.einsum("mni,i->mn", met, along)
    inside = (np.abs(size) > TINY) & (s >= 0.0) & (s <= 1.0) & (q >= 0.0) & (q <= 1.0) & (way >= 0.0)
    return float(way[inside].min(initial=np.inf))
