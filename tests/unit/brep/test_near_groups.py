"""The box tree, rays in groups, and strips of faces find what comparing everything with everything finds."""

from typing import Any

import numpy as np
import pytest

from tests.saved_graphs import moved, saved_graph
from wpcal.brep.boundaries import sample_boundaries
from wpcal.brep.boxes import BoxTree
from wpcal.brep.concavity import are_concave, corner_turns, inner_edges
from wpcal.brep.curves import edge_lengths, edge_polylines
from wpcal.brep.graph import CurveKind
from wpcal.brep.hits import find_hits
from wpcal.brep.material import ExactMaterial, find_solids_around
from wpcal.brep.near_groups import NearBundles, find_hits_near, find_near_faces, first_of_groups
from wpcal.brep.nearest_on_edges import project_to_edges
from wpcal.brep.repeats import find_copies
from wpcal.brep.strips import Strips
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform

ROUND_OFF_MM = 1e-9
PLACE = RigidTransform(rotation_from_zyx(0.7, -0.3, 1.9), [411.0, -87.0, 233.0], "base", "part")


def bundles(size_mm: float, middle: FloatArray, count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Bundles of five parallel rays that go along crooked lines: starts (n, 5, 3), directions (n, 3), lengths (n,)."""
    rng = np.random.default_rng(3)
    way = np.cumsum(rng.normal(size=(count, 3)) * 0.1, axis=0) + rng.normal(size=3)
    way /= np.linalg.norm(way, axis=1, keepdims=True)
    at = middle + np.cumsum(rng.normal(size=(count, 3)) * size_mm / 50, axis=0)
    return at[:, None] + rng.normal(size=(count, 5, 3)) * size_mm / 60, way, rng.uniform(0.0, size_mm, count)


@pytest.mark.parametrize("name", ["frame", "saddle", "bead-pipe", "rounded-top", "drilled", "bead-leaning-pipe"])
def test_groups_lose_no_hit_and_add_none(name: str, golden: Any) -> None:
    graph = moved(saved_graph(name), PLACE)
    trimmed = TrimmedFaces.of(graph)
    origins, way, length = bundles(graph.size_mm, graph.vertex_p.mean(axis=0), 300)
    owner = np.repeat(np.arange(10), 30)
    first = first_of_groups(owner, way)
    assert 30 < len(first) < 200
    p0, rays, far = origins.reshape(-1, 3), np.repeat(way, 5, axis=0), np.repeat(length, 5)
    near = find_near_faces(trimmed, p0, p0 + far[:, None] * rays, 5 * first)
    assert near.counts.sum() < 0.5 * len(first) * graph.face_count
    group = np.repeat(np.arange(len(first)), 5 * np.diff(first, append=len(way)))
    found = find_hits_near(trimmed, near, group, p0, rays, length_mm=far)
    alone = find_hits(trimmed, p0, rays, length_mm=far)
    assert len(alone.ray) > 100
    np.testing.assert_array_equal([found.ray, found.way], [alone.ray, alone.way])
    np.testing.assert_allclose(found.at_mm, alone.at_mm, rtol=0, atol=ROUND_OFF_MM)
    bundled = NearBundles(near, group[::5])
    blocked = bundled.first_faces(trimmed, origins, rays.reshape(-1, 5, 3), far.reshape(-1, 5)) >= 0
    np.testing.assert_array_equal(np.flatnonzero(blocked), np.unique(alone.ray // 5))
    faces, curves = np.arange(300) % graph.face_count, np.flatnonzero(graph.edge_kind < CurveKind.DEGENERATE)
    inner, foot = inner_edges(graph), project_to_faces(graph, faces, p0[:300])
    told = [trimmed.face_box, trimmed.solid_boxes, trimmed.uv0, trimmed.uv1, trimmed.p1, sample_boundaries(graph)]
    told += [inner, are_concave(graph, inner), corner_turns(graph, inner), foot]
    told += [alone, graph.edge_faces, edge_polylines(graph), edge_lengths(graph), trimmed.contains(faces, foot.uv)]
    told += [trimmed.boundary_distance(faces, foot.p), trimmed.nearest_pieces(faces, foot.p), near]
    told += [project_to_edges(graph, curves, p0[: len(curves)]), find_copies(graph, trimmed, within_mm=60.0)]
    material, high = ExactMaterial(graph, trimmed), np.full(100, 0.6 * graph.size_mm)
    told += [material.tube_solids(p0[::15], way[::3], 0.0 * high + 3.0, high, wide) for wide in (9.0, (2.0, 23.0))]
    golden([*told, find_solids_around(material, p0[::15])])


def test_a_group_starts_with_each_owner_and_after_each_turn() -> None:
    way = np.array([[1.0, 0, 0]] * 5 + [[0, 1.0, 0]] * 5)
    assert first_of_groups(np.array([0] * 3 + [1] * 7), way).tolist() == [0, 3, 5]
    assert first_of_groups(np.repeat([0, 1], [3, 17]), np.tile([1.0, 0, 0], (20, 1))).tolist() == [0, 3, 11, 19]


def random_boxes(rng: np.random.Generator, count: int) -> tuple[FloatArray, FloatArray]:
    """Boxes from 1 to 1000 mm: long rails beside bolts."""
    low = rng.uniform(0.0, 1000.0, (count, 3))
    return low, low + 10.0 ** rng.uniform(0.0, 3.0, (count, 3))


@pytest.mark.parametrize("count", [0, 1, 8, 9, 700])
def test_pairs_are_those_of_brute_force(count: int) -> None:
    rng = np.random.default_rng(count)
    low, high = random_boxes(rng, count)
    query_low, query_high = random_boxes(rng, 300)
    query, box = BoxTree.of(low, high).meeting(query_low, query_high)
    lap = ((query_low[:, None] <= high[None]) & (query_high[:, None] >= low[None])).all(axis=2)
    expected = np.nonzero(lap)
    np.testing.assert_array_equal(query, expected[0])
    np.testing.assert_array_equal(box, expected[1])


def test_boxes_that_touch_meet_and_empty_ones_never() -> None:
    low = np.array([[0.0, 0, 0], [np.inf] * 3, [2, 0, 0]])
    high = np.array([[1.0, 1, 1], [-np.inf] * 3, [3, 1, 1]])
    query, box = BoxTree.of(low, high).meeting(np.array([[1.0, 1, 1]]), np.array([[2.0, 2, 2]]))
    assert (query.tolist(), box.tolist()) == ([0, 0], [0, 2])


COUNTS = np.array([4, 0, 60, 300, 1, 25])  #: Pieces of each face; one has none, as a whole sphere.


def boundaries(rng: np.random.Generator, turns: BoolArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Pieces of faces in u: lengths on some; angles on others, all around or, on the last face, on a narrow part."""
    face = np.repeat(np.arange(len(COUNTS)), COUNTS)
    begin = rng.uniform(-40.0, 900.0, len(face))
    run = rng.normal(size=len(face)) * 10.0 ** rng.uniform(-3.0, 3.0, len(face))
    angle = np.where(face == len(COUNTS) - 1, 3.0 + rng.uniform(0.0, 0.4, len(face)), rng.uniform(-9, 9, len(face)))
    turn = np.where(face == len(COUNTS) - 1, 0.2, 3.0) * rng.uniform(-1.0, 1.0, len(face))
    begin, run = np.where(turns[face], angle, begin), np.where(turns[face], turn, run)
    end = begin + run + np.where(turns[face], 2.0 * np.pi * rng.integers(-1, 2, len(face)), 0.0)
    return np.concatenate([[0], np.cumsum(COUNTS)]), begin, end


def crosses(turns: bool, u: float, begin: FloatArray, end: FloatArray) -> BoolArray:
    """Tell whether pieces cross a meridian; those that turn go the shorter way."""
    if not turns:
        return (begin <= u) != (end <= u)
    a, b = (np.angle(np.exp(1j * (side - u))) for side in (begin, end))
    return ((a <= 0) != (b <= 0)) & (np.abs(b - a) < np.pi)


@pytest.mark.parametrize("turns", [[False] * 6, [True] * 6, [False, True, True, False, True, True]])
@pytest.mark.parametrize("most", [50, 500_000])
def test_every_piece_that_crosses_is_there_once(turns: list[bool], most: int) -> None:
    rng, goes_round = np.random.default_rng(3), np.array(turns)
    start, begin, end = boundaries(rng, goes_round)
    face = rng.integers(0, len(COUNTS), 600)
    u = np.where(goes_round[face], rng.uniform(-7, 7, 600), rng.uniform(-100, 1000, 600))
    for row in np.flatnonzero(COUNTS[face])[:200]:  # ends of pieces, too
        u[row] = begin[start[face[row]]]
    found = list(Strips.of(goes_round, start, begin, end).pairs(face, u, most))
    row, piece = np.concatenate(found, axis=1)
    assert (np.diff(row) >= 0).all()
    assert ((piece >= start[face[row]]) & (piece < start[face[row] + 1])).all()
    assert len(np.unique(np.stack([row, piece]), axis=1).T) == len(row)
    listed = set(zip(row.tolist(), piece.tolist(), strict=True))
    for number in range(len(face)):
        own = np.arange(start[face[number]], start[face[number] + 1])
        crossing = own[crosses(goes_round[face[number]], u[number], begin[own], end[own])]
        assert all((number, one) in listed for one in crossing.tolist())


def test_few_pieces_are_in_a_strip() -> None:
    angle = np.arange(400) * 2.0 * np.pi / 400
    u = np.cos(angle)  # a round hole in a plate
    strips = Strips.of(np.array([False]), np.array([0, 400]), u, np.roll(u, -1))
    row, _ = np.concatenate(list(strips.pairs(np.zeros(200, dtype=np.int64), np.linspace(-0.9, 0.9, 200), 10**6)), 1)
    assert len(row) < 200 * 10
