"""Reference features of parts whose every size is known, and of all saved graphs; choosing and naming them."""

import dataclasses
import math
from collections import Counter
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.saved_graphs import saved_graph
from wpcal.brep import BrepGraph, SurfaceKind
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.arrays import IntArray, frozen
from wpcal.core.errors import InputError
from wpcal.taught.features import (
    Ease,
    FeatureChoice,
    FeatureKind,
    HoleForm,
    ReferenceFeature,
    choose_features,
    feature_named,
    find_features,
    judge_features,
    point_named,
)
from wpcal.taught.features.walls import Coaxial, Walls

ROUND_OFF_MM = 1e-9  #: Coordinates of some hundred mm through a few products in double precision.
FAR_MM = 1000.0  #: Five times the tee.
SAMPLED = 0.08  #: Of the radius: the top of a curve between two of its nine samples, an eighth of a turn apart.
CHORD_AREA_MM2 = 2.0  #: Circles as polylines with a sag of 0.01 mm: at most two thirds of it along 250 mm of rims.


def of_kind(features: tuple[ReferenceFeature, ...], kind: FeatureKind) -> list[ReferenceFeature]:
    return [feature for feature in features if feature.kind is kind]


def steps(hole: ReferenceFeature) -> list[tuple[float, float, float]]:
    return [(step.diameter_mm, step.from_mm, step.to_mm) for step in hole.steps]


def test_holes_have_entry_depth_and_form() -> None:
    graph = saved_graph("block")
    holes = of_kind(find_features(graph), FeatureKind.HOLE)
    counterbored, blind, through, sunk = holes
    p = np.array([[30, 30, 20], [70, 30, 20], [110, 30, 20], [150, 30, 17]])
    np.testing.assert_allclose([hole.p_mm for hole in holes], p, rtol=0, atol=ROUND_OFF_MM)
    np.testing.assert_allclose([hole.direction for hole in holes], [[0, 0, 1]] * 4, rtol=0, atol=ROUND_OFF_MM)
    np.testing.assert_allclose([hole.diameter_mm for hole in holes], [18, 8, 12, 6], rtol=0, atol=ROUND_OFF_MM)
    np.testing.assert_allclose([hole.depth_mm for hole in holes], [20, 12, 20, 20], rtol=0, atol=ROUND_OFF_MM)
    assert [hole.is_through for hole in holes] == [True, False, True, True]
    plain = HoleForm.PLAIN
    assert [hole.form for hole in holes] == [HoleForm.COUNTERBORE, plain, plain, HoleForm.COUNTERSINK]
    np.testing.assert_allclose(steps(counterbored), [(18, 0, 6), (10, 6, 20)], rtol=0, atol=ROUND_OFF_MM)
    np.testing.assert_allclose(steps(sunk), [(6, 3, 20)], rtol=0, atol=ROUND_OFF_MM)
    for hole in (counterbored, blind, through):
        assert (graph.face_kind[list(hole.faces)] == SurfaceKind.CYLINDER).all()
        assert 2 * graph.face_param[hole.faces[0], 0] == pytest.approx(hole.diameter_mm, rel=0, abs=ROUND_OFF_MM)


def test_datum_planes_and_axes_carry_their_faces() -> None:
    graph = saved_graph("block")
    features = find_features(graph)
    planes, axes = of_kind(features, FeatureKind.PLANE), of_kind(features, FeatureKind.AXIS)
    low = next(plane for plane in planes if plane.direction is not None and plane.direction[2] < -0.5)
    slot = 28 * 12 + math.pi * 36
    bottom = 200 * 100 - math.pi * (25 + 36 + 9) - slot
    assert low.area_mm2 == pytest.approx(bottom, rel=0, abs=CHORD_AREA_MM2)
    assert sorted(round(axis.diameter_mm or 0, 9) for axis in axes) == [6, 8, 10, 12, 12, 12, 18, 20]
    for feature, kind in [*((p, SurfaceKind.PLANE) for p in planes), *((a, SurfaceKind.CYLINDER) for a in axes)]:
        assert feature.faces
        assert (graph.face_kind[list(feature.faces)] == kind).all()


def test_faces_in_one_plane_are_one_datum() -> None:
    planes = of_kind(find_features(saved_graph("comb")), FeatureKind.PLANE)
    (top,) = [plane for plane in planes if plane.p_mm[2] > 20 - ROUND_OFF_MM]
    assert len(top.faces) == 2
    assert top.area_mm2 == pytest.approx(80 * 40, rel=0, abs=ROUND_OFF_MM)
    np.testing.assert_allclose(top.p_mm, [50, 20, 20], rtol=0, atol=ROUND_OFF_MM)


@pytest.mark.parametrize("rounded", ["rounded-upright", "rounded-all", "rounded-top"])
def test_rounds_leave_virtual_corners(rounded: str) -> None:
    graph = saved_graph(rounded)
    features = find_features(graph)
    virtual = of_kind(features, FeatureKind.VIRTUAL_CORNER)
    corners = {(a, b, c) for a in (0.0, 80.0) for b in (0.0, 60.0) for c in (0.0, 40.0)}
    assert {tuple((feature.p_mm.round(9) + 0.0).tolist()) for feature in virtual} == corners
    assert len(virtual) == 8
    assert all(len(feature.faces) == 3 for feature in virtual)
    judged = judge_features(graph, features)
    assert all(item.ease is Ease.INDIRECT for item in judged if item.feature in virtual)
    assert all(item.ease is Ease.VAGUE for item in judged if item.feature.kind is FeatureKind.VERTEX)


def test_a_cross_hole_does_not_make_a_blind_hole_through() -> None:
    holes = of_kind(find_features(saved_graph("cross-hole")), FeatureKind.HOLE)
    wide = next(hole for hole in holes if hole.diameter_mm == 16)
    assert wide.is_through is False


def shuffled(graph: BrepGraph, seed: int) -> tuple[BrepGraph, IntArray]:
    """The same part with its faces, edges and coedges in another order; and the new number of each face."""
    rng = np.random.default_rng(seed)
    face, edge, coedge = (rng.permutation(n) for n in (graph.face_count, graph.edge_count, len(graph.coedge_face)))
    names = [field.name for field in dataclasses.fields(graph) if getattr(graph, field.name) is not None]
    columns: dict[str, Any] = {n: getattr(graph, n)[face] for n in names if n.startswith("face_")}
    columns |= {n: getattr(graph, n)[edge] for n in names if n.startswith("edge_")}
    columns["coedge_face"] = np.argsort(face)[graph.coedge_face][coedge]
    columns["coedge_edge"] = np.argsort(edge)[graph.coedge_edge][coedge]
    columns["coedge_forward"] = graph.coedge_forward[coedge]
    return dataclasses.replace(graph, **columns), np.argsort(face)


def same(a: ReferenceFeature, b: ReferenceFeature) -> bool:
    sizes = [(f.diameter_mm, f.length_mm, f.depth_mm, f.area_mm2) for f in (a, b)]
    close = [
        (x is None and y is None) or (x is not None and y is not None and abs(x - y) <= ROUND_OFF_MM * max(1.0, x))
        for x, y in zip(*sizes, strict=True)
    ]
    return a.name == b.name and a.form is b.form and a.is_through == b.is_through and all(close)


def test_the_order_of_faces_changes_no_name() -> None:
    graph = saved_graph("block")
    other, number = shuffled(graph, 4)
    for a, b in zip(find_features(graph), find_features(other), strict=True):
        assert same(a, b)
        np.testing.assert_allclose(a.p_mm, b.p_mm, rtol=0, atol=ROUND_OFF_MM)
        assert sorted(number[list(a.faces)].tolist()) == sorted(b.faces)


def test_a_shifted_part_has_the_same_names() -> None:
    shift = (312.5, -77.25, 40.125)
    features, moved = find_features(saved_graph("block")), find_features(saved_graph("block-shifted"))
    for a, b in zip(features, moved, strict=True):
        assert same(a, b)
        np.testing.assert_allclose(a.p_mm + shift, b.p_mm, rtol=0, atol=ROUND_OFF_MM)


def test_a_turned_part_has_turned_features() -> None:
    a, b, c = (Rotation.from_rotvec(np.radians(turn)) for turn in ([20, 0, 0], [0, -35, 0], [0, 0, 70]))
    R, shift = (a * b * c).as_matrix(), np.array([31, -7, 44])
    features, turned = find_features(saved_graph("block")), find_features(saved_graph("block-turned"))
    assert Counter(f.kind for f in features) == Counter(f.kind for f in turned)
    for kind in FeatureKind:  # a through hole's entry is the upper one: turned, it may be the other
        p = np.array([f.p_mm for f in of_kind(features, kind) if kind is not FeatureKind.HOLE]).reshape(-1, 3)
        q = np.array([f.p_mm for f in of_kind(turned, kind)]).reshape(-1, 3)
        for place in p @ R.T + shift:
            assert np.linalg.norm(q - place, axis=1).min() <= ROUND_OFF_MM


def test_a_copy_far_away_changes_nothing() -> None:
    """What meets at a corner, lies against it or is in front of it is found by place among all solids."""
    alone, both = (judged_at(saved_graph(name), FAR_MM) for name in ("tee", "tee-and-far-copy"))
    assert both == {place: ease + ease for place, ease in alone.items()}


def judged_at(graph: BrepGraph, pitch_mm: float) -> dict[tuple[Any, ...], list[Ease]]:
    """The ease of what is at a place, copies at the pitch counted as there."""
    found: dict[tuple[Any, ...], list[Ease]] = {}
    for item in judge_features(graph, find_features(graph)):
        place = item.feature.p_mm - [pitch_mm * (item.feature.p_mm[0] > pitch_mm / 2), 0.0, 0.0]
        found.setdefault((item.feature.kind, *np.round(place, 6)), []).append(item.ease)
    return found


def feature(name: str, x: float, diameter_mm: float | None, solid: str) -> ReferenceFeature:
    return ReferenceFeature(name, FeatureKind(name[0]), frozen([x, 0, 0]), None, diameter_mm, solid)


PART = (
    feature("V1", 0, None, "plate"),
    feature("V2", 10, None, "web"),
    feature("H1", 5, 8.0, "plate"),
    feature("H2", 7, 20.0, "web left"),
)


def names(chosen: tuple[ReferenceFeature, ...]) -> list[str]:
    return [item.name for item in chosen]


def test_conditions_hold_together() -> None:
    assert names(choose_features(PART, FeatureChoice())) == ["V1", "V2", "H1", "H2"]
    assert names(choose_features(PART, FeatureChoice(kinds=(FeatureKind.HOLE,)))) == ["H1", "H2"]
    assert names(choose_features(PART, FeatureChoice(solid="web*"))) == ["V2", "H2"]
    assert names(choose_features(PART, FeatureChoice(solid="web*", kinds=(FeatureKind.VERTEX,)))) == ["V2"]
    assert names(choose_features(PART, FeatureChoice(min_diameter_mm=8.0))) == ["H1", "H2"]


def test_the_nearest_come_first() -> None:
    assert names(choose_features(PART, FeatureChoice(near=(6.9, 0, 0)))) == ["H2", "H1", "V2", "V1"]


def test_an_unknown_solid_says_which_there_are() -> None:
    with pytest.raises(InputError, match="the part has plate, web, web left"):
        choose_features(PART, FeatureChoice(solid="flange"))
    with pytest.raises(InputError, match="three finite numbers"):
        choose_features(PART, FeatureChoice(near=(np.nan, 0, 0)))


def test_names_are_found_in_any_case() -> None:
    assert feature_named(PART, " h2 ") is PART[3]
    with pytest.raises(InputError, match="near: H"):
        feature_named(PART, "H7")


def test_a_plane_is_no_point() -> None:
    datum = feature("P1", 3, None, "plate")
    with pytest.raises(InputError, match="P1 is a datum plane"):
        point_named((*PART, datum), "p1")
    assert point_named(PART, "h1").tolist() == [5, 0, 0]


@pytest.mark.parametrize("name", ["cross-hole", "saddle-90", "saddle-60", "bead-leaning-pipe", "block-turned"])
def test_a_wall_reaches_as_far_as_its_border_and_goes_round(name: str) -> None:
    """Borders of walls that others cut off are no circles: their heights are those of the boundary's own points."""
    graph = saved_graph(name)
    walls, trimmed = Walls.of(Coaxial.of(graph)), TrimmedFaces.of(graph)
    for wall, axis in enumerate(walls.axis):
        faces = np.flatnonzero(walls.of_face == wall)
        heights = np.concatenate([trimmed.heights(face, axis) for face in faces])
        low, high = walls.ends.low[wall], walls.ends.high[wall]
        assert heights.min() - ROUND_OFF_MM <= low <= heights.min() + SAMPLED * walls.radius[wall]
        assert heights.max() - SAMPLED * walls.radius[wall] <= high <= heights.max() + ROUND_OFF_MM
        if len(faces) == 1:
            u = np.sort(trimmed.uv0[trimmed.start[faces[0]] : trimmed.start[faces[0] + 1], 0] % (2 * np.pi))
            gap = np.diff(u, append=u[0] + 2 * np.pi).max()
            assert walls.turn[wall] == pytest.approx(2 * np.pi if gap < np.pi / 2 else 2 * np.pi - gap, abs=0.1)
