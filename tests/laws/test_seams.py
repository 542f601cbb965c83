"""Laws of seams: moved with the part, steps within their bounds, frames and directions as the conventions say."""

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.spatial import cKDTree

from tests.few import few
from tests.saved_graphs import moved, saved_graph, saved_seams
from wpcal.brep import BrepGraph
from wpcal.brep.curves import evaluate_edges
from wpcal.brep.trim import distance_to_segments
from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform
from wpcal.seam import Seam, SeamOptions, StepOptions, detect_seams
from wpcal.taught.features import FeatureKind, find_features

ROUND_OFF_MM = 1e-7
"""Ends of contacts are bisected to 2e-9 mm; the rest is round-off of coordinates of some hundred millimetres."""
ROUND_OFF_RAD = 1e-9  #: Products of unit vectors; the chord of a station moves by 1e-7 mm on a radius of 25 mm at most.
DENSE = 4001
"""Samples of a piece by which its steps are measured: the chord error of 10 mm is then known to 1e-6 of itself."""

SHIFT = RigidTransform.from_six_tuple([130.0, -70.0, 45.0, 0, 0, 0], target="moved", source="part")
MOTIONS = [
    RigidTransform.from_six_tuple(six, target="moved", source="part")
    for six in ([812.3, -455.1, 277.7, 0.3, -0.7, 2.1], [0, 0, 0, np.pi, 0, 0], [-5.0, 3.0, 1.0, 0, np.pi / 2, 0])
]
NAMES = ("tee", "saddle", "post-base", "lap", "frame")
MOVED = few(NAMES, 3)  #: A move finds all seams anew: a straight one, a closed one and a section, at each push.


@cache
def moved_seams(name: str, T: RigidTransform) -> tuple[Seam, ...]:
    """Seams of a part that was moved before they were looked for."""
    return detect_seams(moved(saved_graph(name), T))


def key(seam: Seam) -> tuple[Any, ...]:
    return (seam.joint, seam.weld, seam.solids, seam.closed, seam.accepted, round(seam.length_mm, 6))


@pytest.mark.parametrize("name", MOVED)
def test_a_shifted_part_gives_shifted_seams_of_the_same_names(name: str) -> None:
    for there, here in zip(moved_seams(name, SHIFT), saved_seams(name), strict=True):
        assert (there.name, *key(there)) == (here.name, *key(here))
        np.testing.assert_allclose(there.frames.p, SHIFT.apply(here.frames.p), rtol=0, atol=ROUND_OFF_MM)
        np.testing.assert_allclose(there.frames.R, here.frames.R, rtol=0, atol=ROUND_OFF_RAD)


@pytest.mark.parametrize("T", few(MOTIONS, 1))
@pytest.mark.parametrize("name", MOVED)
def test_a_moved_part_gives_the_same_seams_there(name: str, T: RigidTransform) -> None:
    """Names and directions follow x, y, z; what is joined, and where, does not."""
    here, there = list(saved_seams(name)), list(moved_seams(name, T))
    assert sorted(map(repr, map(key, here))) == sorted(map(repr, map(key, there)))
    for seam in here:
        path = dense_path(saved_graph(name), seam)[0]
        twin = min(there, key=lambda other: distance_from(T.apply(path), other.frames.p) + (key(other) != key(seam)))
        assert distance_from(T.apply(path), twin.frames.p) <= 1e-3  # the path is a polyline of 4000 pieces
        there.remove(twin)
        if not seam.closed:
            ends = T.apply(seam.frames.p[[0, -1]])
            is_same = np.allclose(ends[0], twin.frames.p[0], rtol=0, atol=ROUND_OFF_MM)
            order = slice(None, None, 1 if is_same else -1)
            np.testing.assert_allclose(twin.frames.p[[0, -1]][order], ends, rtol=0, atol=ROUND_OFF_MM)
            z = seam.frames.R[[0, -1], :, 2] @ T.R.T
            np.testing.assert_allclose(twin.frames.R[[0, -1], :, 2][order], z, rtol=0, atol=ROUND_OFF_RAD)


@pytest.mark.parametrize("T", [SHIFT, *MOTIONS])
@pytest.mark.parametrize("name", NAMES)
def test_a_moved_part_has_moved_features(name: str, T: RigidTransform) -> None:
    identity = RigidTransform.identity(target="moved", source="part")
    there, here = listed(moved(saved_graph(name), T), identity), listed(saved_graph(name), T)
    assert there == here
    rims = {row[1:] for row in there if row[0] == "C"}
    assert all(row[1:] in rims for row in listed(moved(saved_graph(name), T), identity, with_entry=True))


WITH_ENTRY = (FeatureKind.HOLE, FeatureKind.BOSS)


def listed(graph: BrepGraph, place: RigidTransform, *, with_entry: bool = False) -> list[tuple[Any, ...]]:
    """Features without names, with or without an entry: on a through hole or a pipe, its place decides the rim."""
    found = [feature for feature in find_features(graph) if (feature.kind in WITH_ENTRY) == with_entry]
    p = place.apply(np.array([feature.p_mm for feature in found]).reshape(-1, 3))
    sizes = [(f.kind.value, f.solid, round(f.diameter_mm or 0.0, 6)) for f in found]
    points = (np.round(p, 5) + 0.0).tolist()
    return sorted((*size, *point) for size, point in zip(sizes, points, strict=True))


def dense_path(graph: BrepGraph, seam: Seam) -> tuple[FloatArray, FloatArray]:
    """Sample a seam's own curve: points and the length along the samples."""
    rows = []
    for edge, t0, t1 in zip(seam.pieces.edge, seam.pieces.t0, seam.pieces.t1, strict=True):
        rows.append(evaluate_edges(graph, np.full(DENSE, edge), np.linspace(t0, t1, DENSE))[0])
    p = np.concatenate(rows)
    return p, np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])


def distance_from(path: FloatArray, points: FloatArray) -> float:
    """Largest distance of points from a polyline, by its nearest sample's two neighbours."""
    nearest = cKDTree(path).query(points)[1]
    before, after = np.maximum(nearest - 1, 0), np.minimum(nearest + 1, len(path) - 1)
    off = [distance_to_segments(points, path[a], path[b]) for a, b in ((before, nearest), (nearest, after))]
    return float(np.minimum(*off).max())


STEPS = [StepOptions(), StepOptions(0.01, 0.0, 50.0), StepOptions(0.5, 2.0, 7.0), StepOptions(1.0, 1.0, 200.0)]


@pytest.mark.parametrize("steps", few(STEPS, 1), ids=str)
@pytest.mark.parametrize("name", NAMES)
def test_chord_error_and_step_are_as_asked(name: str, steps: StepOptions) -> None:
    for seam in saved_seams(name, SeamOptions(steps=steps)):
        path, along = dense_path(saved_graph(name), seam)
        s, p = seam.frames.s_mm, seam.frames.p
        step = np.clip(np.searchsorted(s, along, side="right") - 1, 0, len(s) - 2)
        chord = distance_to_segments(path, p[step], p[step + 1])
        assert chord.max() <= steps.chord_mm + 1e-6  # samples at a border count for the wrong neighbour's chord
        assert np.diff(s).max() <= steps.max_step_mm + ROUND_OFF_MM
        assert s[0] == 0.0
        assert s[-1] == pytest.approx(along[-1], rel=0, abs=1e-4)  # the polyline of the samples is shorter
        assert seam.length_mm == pytest.approx(s[-1], rel=0, abs=ROUND_OFF_MM)


def test_a_finer_chord_gives_more_points() -> None:
    counts = [
        len(detect_seams(saved_graph("saddle"), SeamOptions(steps=StepOptions(chord, 0.0, 100.0)))[0].frames)
        for chord in (1.0, 0.1, 0.01)
    ]
    # the step goes with the root of the chord error: a factor of 3.16 each
    assert counts[1] / counts[0] == pytest.approx(np.sqrt(10), rel=0.1)
    assert counts[2] / counts[1] == pytest.approx(np.sqrt(10), rel=0.1)


def test_points_that_are_too_close_are_thinned_where_the_chord_allows() -> None:
    graph, arcs = saved_graph("disc-of-arcs"), 80
    # two arcs of 1.96 mm have a chord error of 0.077 mm, three of 0.17 mm
    (thinned,) = detect_seams(graph, SeamOptions(steps=StepOptions(0.1, 3.0, 10.0)))
    assert np.diff(thinned.frames.s_mm).min() >= 3.0
    (kept,) = detect_seams(graph, SeamOptions(steps=StepOptions(0.05, 3.0, 10.0)))
    assert len(kept.frames) == arcs + 1


@pytest.mark.parametrize("name", NAMES)
def test_frames_are_right_handed_and_orthonormal(name: str) -> None:
    for seam in saved_seams(name):
        R = seam.frames.R
        gram = np.einsum("nki,nkj->nij", R, R)
        np.testing.assert_allclose(gram, np.broadcast_to(np.eye(3), gram.shape), rtol=0, atol=1e-12)
        np.testing.assert_allclose(np.linalg.det(R), 1.0, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", MOVED)
@pytest.mark.parametrize("T", few([*MOTIONS, SHIFT], 1))
def test_seams_run_as_the_conventions_say(name: str, T: RigidTransform) -> None:
    graph = moved(saved_graph(name), T)
    for seam in moved_seams(name, T):
        p = seam.frames.p
        chords = np.diff(p, axis=0)
        x = seam.frames.R[:-1, :, 0]
        assert (np.einsum("ni,ni->n", x, chords) > 0.9 * np.linalg.norm(chords, axis=1)).all()
        if not seam.closed:
            assert tuple(np.round(p[0], 6)) <= tuple(np.round(p[-1], 6))
            continue
        path = dense_path(graph, seam)[0]
        assert p[0, 0] <= path[:, 0].min() + 1e-6  # x is flat there: the place is known to 1e-8 only along the seam
        assert np.array_equal(p[0], p[-1])
        assert np.array_equal(seam.frames.R[0], seam.frames.R[-1])
        area = np.cross(path - path.mean(axis=0), np.roll(path, -1, axis=0) - path.mean(axis=0)).sum(axis=0)
        leading = next(value for value in area[::-1] if abs(value) > 1e-6 * np.abs(area).max())
        assert leading > 0


def test_the_order_of_the_solids_changes_no_seam() -> None:
    back = saved_seams("frame-backwards")
    for here, there in zip(saved_seams("frame"), back, strict=True):
        assert (here.joint, here.weld, set(here.solids)) == (there.joint, there.weld, set(there.solids))
        np.testing.assert_allclose(there.frames.p, here.frames.p, rtol=0, atol=ROUND_OFF_MM)
        np.testing.assert_allclose(there.frames.R, here.frames.R, rtol=0, atol=ROUND_OFF_RAD)


def test_a_rod_on_a_plate_has_one_loop() -> None:
    (seam,) = saved_seams("rod-on-plate")
    assert seam.closed
    np.testing.assert_allclose(seam.frames.p[0], [-25, 0, 10], rtol=0, atol=1e-6)
