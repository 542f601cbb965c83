"""Rays through a part: a turned box, for which the slabs give the answer, and a torus."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from tests.saved_graphs import saved_graph
from wpcal.brep import BrepGraph
from wpcal.brep.hits import find_hits, is_blocked
from wpcal.brep.torus_rays import torus_roots
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.rotations import rotation_from_zyx

HALF_MM = np.array([40.0, 30.0, 20.0])  #: Half the sides of the box around the origin.
CLEAR_MM = 1e-3  #: Rays that pass an edge of the box within this are not tested.


def turned_box(R: FloatArray) -> BrepGraph:
    graph = saved_graph("sharp-box")
    frames = {name: getattr(graph, name) @ R.T for name in ("face_frame", "edge_frame", "vertex_p")}
    return replace(graph, **frames)


def meets_box(origins: FloatArray, rays: FloatArray, length_mm: float, half: FloatArray) -> BoolArray:
    """Tell which rays meet a box around the origin along the axes: they are in all three slabs at once."""
    a, b = (-half - origins) / rays, (half - origins) / rays
    enter = np.maximum(np.minimum(a, b).max(axis=1), 0.0)
    leave = np.minimum(np.maximum(a, b).min(axis=1), length_mm)
    return np.asarray(enter < leave, dtype=bool)


@pytest.mark.parametrize("angles", [(0.0, 0.0, 0.0), (0.4, -0.7, 1.1), (2.0, 0.3, -0.5)])
def test_rays_meet_a_turned_box_where_its_slabs_say(angles: tuple[float, float, float]) -> None:
    rng, length_mm = np.random.default_rng(5), 400.0
    R = rotation_from_zyx(*angles)
    graph = turned_box(R)
    directions = rng.normal(size=(4000, 3))
    origins = 120.0 * directions / np.linalg.norm(directions, axis=1, keepdims=True)
    rays = rng.uniform(-1.4, 1.4, (4000, 3)) * HALF_MM - origins  # towards the box or just past it
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    inner, outer = (meets_box(origins, rays, length_mm, HALF_MM + grown) for grown in (-CLEAR_MM, CLEAR_MM))
    found = is_blocked(TrimmedFaces.of(graph), origins @ R.T, rays @ R.T, length_mm=length_mm)
    clear = inner == outer
    assert 0.2 < inner[clear].mean() < 0.95
    np.testing.assert_array_equal(found[clear], inner[clear])


def test_a_ray_ends_at_its_length() -> None:
    graph = saved_graph("sharp-box")
    origins, rays = np.tile([0.0, 0.0, 100.0], (2, 1)), np.tile([0.0, 0.0, -1.0], (2, 1))
    blocked = is_blocked(TrimmedFaces.of(graph), origins, rays, length_mm=np.array([79.0, 81.0]))
    assert blocked.tolist() == [False, True]


@pytest.mark.parametrize("solid", [1, np.array(1), [1], [1] * 50, np.full(50, 1)], ids=type)
def test_only_faces_of_the_solid_are_hit_however_it_is_given(solid: Any) -> None:
    graph, rng = saved_graph("joint-tee"), np.random.default_rng(3)
    low, high = graph.vertex_p.min(axis=0), graph.vertex_p.max(axis=0)
    rays = rng.normal(size=(50, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    origins, trimmed = rng.uniform(low, high, (50, 3)) - graph.size_mm * rays, TrimmedFaces.of(graph)
    every = find_hits(trimmed, origins, rays, length_mm=2.0 * graph.size_mm)
    own = graph.face_solid[every.face] == 1
    assert 0 < own.sum() < len(own)
    found = find_hits(trimmed, origins, rays, length_mm=2.0 * graph.size_mm, solid=solid)
    np.testing.assert_array_equal(found.face, every.face[own])


NEAR_MM = 1e-4  #: A line that touches the torus is this near to it over a millimetre.
COUNT = 4000


def lines(seed: int) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    rng = np.random.default_rng(seed)
    o, d = rng.normal(size=(COUNT, 3)) * 60.0, rng.normal(size=(COUNT, 3))
    special = np.eye(3)[rng.integers(0, 3, COUNT // 4)]
    d[: COUNT // 4] = special  # along axes: even quartics
    o[: COUNT // 8, :] *= special[: COUNT // 8]  # and through the centre
    return o, d / np.linalg.norm(d, axis=1, keepdims=True), rng.uniform(20, 60, COUNT), rng.uniform(1, 19, COUNT)


def height(o: FloatArray, d: FloatArray, major: FloatArray, minor: FloatArray, t: FloatArray) -> FloatArray:
    p = o[:, None] + t[..., None] * d[:, None]
    return np.hypot(np.hypot(p[..., 0], p[..., 1]) - major[:, None], p[..., 2]) - minor[:, None]


def test_every_root_is_on_the_torus() -> None:
    o, d, major, minor = lines(1)
    t = torus_roots(o, d, major, minor)
    off = np.abs(height(o, d, major, minor, t))
    assert np.isfinite(t).any(axis=1).mean() > 0.15
    assert np.nanmax(off) < NEAR_MM


def test_no_crossing_is_missed() -> None:
    o, d, major, minor = lines(2)
    t = np.linspace(-300.0, 300.0, 6001)
    found = torus_roots(o, d, major, minor)
    for first in range(0, COUNT, 500):
        own = slice(first, first + 500)
        h = height(o[own], d[own], major[own], minor[own], np.broadcast_to(t, (500, len(t))))
        row, at = np.nonzero((h[:, 1:] > 0) != (h[:, :-1] > 0))
        nearest = np.nanmin(np.abs(found[own][row] - (t[at] + t[at + 1])[:, None] / 2), axis=1)
        assert nearest.max() <= 0.05 + 1e-6
