"""Touches on faces, edges and walls of real parts: recovered, held, refused, distrusted; the laws of a fit."""

import itertools
import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from build123d import Torus

from cad.workpiece.calibrate import calibrate_workpiece
from cad.workpiece.fit_taught import CalibrateOptions
from cad.workpiece.workpiece import Workpiece, open_workpiece
from tests.few import few
from wpcal.brep import SurfaceKind
from wpcal.brep.surfaces import project_to_faces
from wpcal.brep.trim import TrimmedFaces
from wpcal.calibrate import CalibrationResult, Criterion, SigmaSource, Solver, TeachingError, VerdictKind, calibrate
from wpcal.calibrate.errors.robot_field import USUAL_SIGMA_MM
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.solve.touches import Pose, fit_minimax, fit_squares
from wpcal.calibrate.trust.contradiction import find_contradicted
from wpcal.core import GeometryError, InputError, RigidTransform
from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import exp_rotation
from wpcal.taught.kinds import TouchKind
from wpcal.taught.resolve import named_axes, touches_of
from wpcal.taught.table import TaughtPoints
from wpcal.taught.touched_face import touched_face

TEE = Path(__file__).parents[2] / "fixtures" / "tee"
RECOVERED_MM = 1e-6  # asked for touches without noise
ROUND_OFF = 1e-7  # of two ways to one answer: rad and mm about a metre from the origin
SIGMA_MM = 0.1
R, T_MM = exp_rotation([0.3, -0.2, 0.5]), np.array([800.0, -200, 150])
Row = tuple[str, TouchKind, tuple[float, float, float], tuple[float, float, float]]
PLANES: list[Row] = [
    ("A1", TouchKind.PLANE, (20, 100, 10), (0, 0, 1)),
    ("A2", TouchKind.PLANE, (180, 100, 10), (0, 0, 1)),
    ("A3", TouchKind.PLANE, (100, 20, 10), (0, 0, 1)),
    ("B1", TouchKind.PLANE, (40, 0, 5), (0, -1, 0)),
    ("B2", TouchKind.PLANE, (160, 0, 5), (0, -1, 0)),
    ("C1", TouchKind.PLANE, (0, 60, 5), (-1, 0, 0)),
]
WALL: list[Row] = [
    (f"H{k}", TouchKind.HOLE, (20 + 5 * np.cos(a), 20 + 5 * np.sin(a), z), (-np.cos(a), -np.sin(a), 0))
    for k, (a, z) in enumerate([(0.2, 3), (2.3, 5), (4.4, 8)])
]
MIXED: list[Row] = [
    *PLANES,
    *WALL,
    ("E1", TouchKind.EDGE, (60, 120, 10), (0, 0, 0)),
    ("E2", TouchKind.EDGE, (150, 120, 10), (0, 0, 0)),
    ("P1", TouchKind.POINT, (175, 64, 90), (0, 0, 0)),
    ("W1", TouchKind.PLANE, (100, 64, 50), (0, 1, 0)),
    ("W2", TouchKind.PLANE, (60, 64, 70), (0, 1, 0)),
]


@pytest.fixture(scope="module")
def tee() -> Workpiece:
    return open_workpiece(TEE / "tee.step")


def touched(
    workpiece: Workpiece, rows: list[Row], off: FloatArray | float = 0.0, sigma_mm: FloatArray | None = None
) -> Touches:
    """Touch with a ball of 1 mm; `off` is added in the base."""
    p, n = np.array([row[2] for row in rows], dtype=float), np.array([row[3] for row in rows], dtype=float)
    count = len(rows)
    taught = TaughtPoints(
        tuple(row[0] for row in rows),
        (p + n) @ R.T + T_MM + off,
        ("",) * count,
        p,
        ("yes",) * count,
        "",
        (0,) * count,
        covariances=None if sigma_mm is None else sigma_mm[:, None, None] ** 2 * np.eye(3),
        kinds=tuple(row[1] for row in rows),
        radius_mm=np.linalg.norm(n, axis=1),
    )
    return touches_of(taught, TrimmedFaces.of(workpiece.graph), workpiece.features, use="yes")


def fit(touches: Touches, workpiece: Workpiece, **options: object) -> CalibrationResult:
    stated = TeachingError(sigma_mm=SIGMA_MM)
    named = replace(touches, axes=named_axes(workpiece.features))
    return calibrate(named, **{"teaching": stated, **options})  # type: ignore[arg-type]


def apart(one: RigidTransform, R_other: FloatArray, t_other: FloatArray) -> float:
    """Largest distance between the corners of the tee at two places, mm."""
    corners = np.array([[0, 0, 0], [200, 0, 0], [0, 120, 0], [200, 120, 90.0]])
    return float(np.linalg.norm(one.apply(corners) - corners @ R_other.T - t_other, axis=1).max())


def noise(seed: int, rows: list[Row] = MIXED) -> FloatArray:
    return np.asarray(SIGMA_MM * np.random.default_rng(seed).normal(size=(len(rows), 3)))


def test_six_touches_on_three_planes_place_the_fixture_exactly() -> None:
    options = CalibrateOptions(teaching=TeachingError(sigma_mm=SIGMA_MM))
    result = calibrate_workpiece(TEE / "tee.step", TEE / "touches_321.csv", options=options).result
    truth = np.array(json.loads((TEE / "truth.json").read_text())["T_base_part"])
    assert apart(result.T_base_part, truth[:3, :3], truth[:3, 3]) <= RECOVERED_MM
    assert len(result.touches.motions) == 6
    assert {name for held in result.touches.motions for name in held.held_by} == {"A1", "A2", "A3", "B1", "B2", "C1"}
    assert not result.certified  # a proof exists for points only


def test_mixed_touches_without_noise_are_recovered(tee: Workpiece) -> None:
    assert apart(fit(touched(tee, MIXED), tee).T_base_part, R, T_MM) <= RECOVERED_MM


def test_a_free_motion_is_named(tee: Workpiece) -> None:
    with pytest.raises(GeometryError, match="turns about the axis of H1"):
        fit(touched(tee, [*PLANES[:3], *WALL]), tee)
    with pytest.raises(GeometryError, match=r"slides along \(1 0 0\)"):
        fit(touched(tee, PLANES[:5]), tee)


@pytest.mark.parametrize("seed", few(range(3), 1))
def test_the_polished_value_is_never_above_the_annealed_one(tee: Workpiece, seed: int) -> None:
    result = fit(touched(tee, MIXED, noise(seed)), tee)
    assert result.solver.annealed_objective_mm is not None
    assert result.objective_mm <= result.solver.annealed_objective_mm + ROUND_OFF


@pytest.mark.parametrize("seed", few(range(10), 3))
def test_the_fit_without_a_touch_does_not_remember_it(tee: Workpiece, seed: int) -> None:
    off = noise(seed)
    off[12] += R @ [0, 2.0, 0]
    touches = touched(tee, MIXED, off)
    with_it = fit_squares(touches, Pose.of(touches, R, T_MM))
    rest = touches.select(np.delete(np.arange(len(MIXED)), 12))
    for fitter in (fit_squares, fit_minimax):
        from_all, from_truth = fitter(rest, with_it), fitter(rest, Pose.of(rest, R, T_MM))
        np.testing.assert_allclose(from_all.largest_mm, from_truth.largest_mm, rtol=0, atol=1e-6)


def test_a_mis_taught_touch_is_named_and_robust_leaves_it_out(tee: Workpiece) -> None:
    off = noise(0)
    off[12] += R @ [0, 2.0, 0]
    touches = touched(tee, MIXED, off)
    result = fit(touches, tee, criterion=Criterion.ROBUST, solver=Solver.EXACT)
    assert result.distrusted.names == ("W1",)
    assert result.distrusted.without_them.rms_mm < SIGMA_MM < result.distrusted.with_them.rms_mm
    rest = touches.select(np.delete(np.arange(len(MIXED)), 12))
    by_hand = fit(rest, tee, criterion=Criterion.LEAST_SQUARES, solver=Solver.EXACT).T_base_part
    assert apart(result.T_base_part, by_hand.R, by_hand.t_mm) <= RECOVERED_MM


@pytest.mark.deep
def test_two_wrong_touches_are_named_as_a_pair_and_good_ones_are_left_in_peace(tee: Workpiece) -> None:
    pair, alarms = 0, 0
    for seed in range(12):
        touches = touched(tee, MIXED, noise(seed))
        start = Pose.of(touches, R, T_MM)
        alarms += find_contradicted(touches, start, None) is not None
        off = np.zeros((len(MIXED), 3))
        off[3] += R @ [0, -1.5, 0]
        off[13] += R @ [0, 1.5, 0]
        found = find_contradicted(replace(touches, p_base=touches.p_base + off), start, None)
        pair += found is not None and found.names == ("B1", "W2")
    assert pair >= 11  # 49 of 50 of other pairs
    assert alarms <= 1


def test_a_wrong_check_touch_is_named_and_the_fit_keeps_its_touches(tee: Workpiece) -> None:
    off = noise(0)
    off[12] += R @ [0, 2.0, 0]
    fitted, checked = touched(tee, MIXED[:10], off[:10]), touched(tee, MIXED[10:], off[10:])
    result = fit(fitted, tee, check=checked, solver=Solver.EXACT)
    assert result.suspect.names == ("W1",)
    assert result.distrusted is None
    off = noise(0)
    off[4] += R @ [0, -2.0, 0]
    fitted, checked = touched(tee, MIXED[:8], off[:8]), touched(tee, MIXED[8:], off[8:])
    result = fit(fitted, tee, check=checked, solver=Solver.EXACT)
    assert result.suspect.names == ("B2",)


def test_touches_in_several_postures_show_a_wrong_tool(tee: Workpiece) -> None:
    rng, tip = np.random.default_rng(0), np.array([0.8, -0.6, 0.5])
    frames = [exp_rotation(0.5 * rng.normal(size=3)) for _ in MIXED]
    off = noise(0) - np.array([frame @ tip for frame in frames])
    touches = touched(tee, MIXED, off)
    result = fit(touches, tee, postures=dict(zip(touches.names, frames, strict=True)), solver=Solver.EXACT)
    assert np.linalg.norm(result.tool.tip_mm - tip) <= result.tool.error_95_mm
    assert result.suspect is None


def test_a_touch_that_says_it_is_unsure_is_not_distrusted(tee: Workpiece) -> None:
    off, sigma = noise(0), np.full(len(MIXED), SIGMA_MM)
    off[12] += R @ [0, 2.0, 0]
    named = fit(touched(tee, MIXED, off, sigma), tee, solver=Solver.EXACT).distrusted
    assert named.names == ("W1",)
    sigma[12] = 2.0
    assert fit(touched(tee, MIXED, off, sigma), tee, solver=Solver.EXACT).distrusted is None


def test_six_touches_without_a_stated_error_are_unsure_under_an_assumed_one(tee: Workpiece) -> None:
    result = fit(touched(tee, PLANES), tee, teaching=TeachingError(), solver=Solver.EXACT)
    assert (result.sigma.mm, result.sigma.source) == (USUAL_SIGMA_MM, SigmaSource.ASSUMED)
    assert result.verdict is VerdictKind.UNSURE
    assert "assumed" in result.judgement.sentence
    result = fit(touched(tee, PLANES, 0.0, np.full(6, SIGMA_MM)), tee, teaching=TeachingError(), solver=Solver.EXACT)
    assert result.sigma.degrees_of_freedom == np.inf


def test_the_weighted_criterion_needs_stated_errors(tee: Workpiece) -> None:
    with pytest.raises(InputError, match="needs an error for every touch"):
        fit(touched(tee, MIXED), tee, criterion=Criterion.WEIGHTED, solver=Solver.EXACT)


@pytest.mark.deep
def test_touches_on_a_free_form_face_place_the_part() -> None:
    from build123d import Edge, Face, Vector, Wire, extrude

    top = Edge.make_spline([Vector(0, 0, 20), Vector(30, 0, 32), Vector(70, 0, 18), Vector(100, 0, 26)])
    ends = [Vector(100, 0, 26), Vector(100, 0, 0), Vector(0, 0, 0), Vector(0, 0, 20)]
    sides = [Edge.make_line(a, b) for a, b in itertools.pairwise(ends)]
    wavy = open_workpiece(extrude(Face(Wire([top, *sides])), amount=80, dir=(0, 1, 0)))
    graph = wavy.graph
    (face,) = np.flatnonzero(graph.face_kind == SurfaceKind.NURBS)
    asked = np.array([[15, 10, 25], [50, 40, 25], [85, 15, 25], [30, 70, 25], [75, 65, 25], [55, 12, 25]], dtype=float)
    foot = project_to_faces(graph, np.full(len(asked), face), asked)
    rows: list[Row] = [
        (f"S{k}", TouchKind.SURFACE, tuple(p), tuple(n))
        for k, (p, n) in enumerate(zip(foot.p, foot.normal, strict=True))
    ]
    rows += [("Y1", TouchKind.PLANE, (30, 0, 10), (0, -1, 0)), ("Y2", TouchKind.PLANE, (70, 0, 10), (0, -1, 0))]
    found = fit(touched(wavy, rows), wavy, teaching=TeachingError(sigma_mm=SIGMA_MM))
    assert apart(found.T_base_part, R, T_MM) < RECOVERED_MM


def test_a_whole_torus_has_no_border() -> None:
    found = touched_face(open_workpiece(Torus(20.0, 5.0)).trimmed, np.array([25.0, 0.0, 0.0]))
    assert (found.kind, found.border_mm) == (TouchKind.SURFACE, None)


THRICE: list[Row] = [(f"{name}.{k}", *rest) for k in range(3) for name, *rest in MIXED]
