"""Splines taken apart into polynomials are the splines (SciPy as the oracle); nearest points and lengths are right."""

import numpy as np
import pytest
from scipy.interpolate import BSpline, NdBSpline

from tests.saved_graphs import saved_graph
from wpcal.brep.curves import cumulative_length, parameters_at_length
from wpcal.brep.graph import CurveKind
from wpcal.brep.nearest import NearestOnSurfaces
from wpcal.brep.nurbs import NurbsCurve, NurbsSurface
from wpcal.brep.spans import CurveSet, SurfaceSet
from wpcal.core.arrays import FloatArray

ROUND_OFF_MM = 1e-10  #: Coordinates up to 100 mm, derivatives up to some 1000 mm, degrees up to five.
NORMAL_RAD = 1e-7  #: Twelve Gauss-Newton rounds from a seed within a third of a span, on a gently bent surface.


def random_knots(rng: np.random.Generator, degree: int, poles: int, *, clamped: bool) -> FloatArray:
    """Knots with a double one inside; not clamped, the spline begins at its degree-th knot."""
    inner = np.sort(rng.uniform(0.1, 0.9, poles - degree - 1)) * 7.0
    if len(inner) > 2 and degree > 1:
        inner[1] = inner[0]
    ends = np.zeros(degree + 1) if clamped else np.linspace(-0.5, 0.0, degree + 1)
    return np.concatenate([ends, inner, 7.0 - ends[::-1]])


def random_curves(rng: np.random.Generator) -> list[NurbsCurve]:
    curves = []
    for degree in (1, 2, 3, 5, 3):
        for clamped in (True, False):
            poles = degree + 5
            knots = random_knots(rng, degree, poles, clamped=clamped)
            curves.append(NurbsCurve(degree, knots, rng.uniform(-100, 100, (poles, 3)), rng.uniform(0.5, 2.0, poles)))
    return curves


def rational(spline: BSpline | NdBSpline, at: FloatArray, *nu: object) -> tuple[FloatArray, ...]:
    """Point and derivatives by SciPy."""
    h = spline(at)
    p = h[:, :3] / h[:, 3:]
    slopes = [spline(at, nu=order) for order in nu]
    return (p, *((dh[:, :3] - p * dh[:, 3:]) / h[:, 3:] for dh in slopes))


def test_curves_and_their_derivatives() -> None:
    rng = np.random.default_rng(0)
    curves = random_curves(rng)
    which = rng.integers(0, len(curves), 400)
    t = rng.uniform(0.0, 7.0, 400)
    t[:20], t[20:40] = 0.0, 7.0
    p, slope = CurveSet.of(curves).evaluate(which, t)
    for number, curve in enumerate(curves):
        h = np.column_stack([curve.poles * curve.weights[:, None], curve.weights])
        rows = which == number
        expected = rational(BSpline(curve.knots, h, curve.degree), t[rows], 1)
        np.testing.assert_allclose(p[rows], expected[0], rtol=0, atol=ROUND_OFF_MM)
        np.testing.assert_allclose(slope[rows], expected[1], rtol=0, atol=ROUND_OFF_MM)


def random_surfaces(rng: np.random.Generator, bend_mm: float) -> list[NurbsSurface]:
    surfaces = []
    for degrees in ((3, 3), (2, 1), (3, 3), (1, 4)):
        count = [degree + 4 for degree in degrees]
        knots = [random_knots(rng, degree, n, clamped=True) for degree, n in zip(degrees, count, strict=True)]
        grid = np.stack(np.meshgrid(*(np.linspace(0, 100, n) for n in count), [0.0], indexing="ij"), axis=-1)[:, :, 0]
        poles = grid + rng.uniform(-bend_mm, bend_mm, grid.shape)
        surfaces.append(NurbsSurface(degrees, *knots, poles, rng.uniform(0.8, 1.2, count), (0.0, 7.0, 0.0, 7.0)))
    return surfaces


def test_surfaces_and_their_derivatives() -> None:
    rng = np.random.default_rng(1)
    surfaces = random_surfaces(rng, 20.0)
    which, uv = rng.integers(0, len(surfaces), 400), rng.uniform(0.0, 7.0, (400, 2))
    uv[:20], uv[20:40] = 0.0, 7.0
    found = SurfaceSet.of(surfaces).evaluate(which, uv)
    for number, s in enumerate(surfaces):
        h = np.concatenate([s.poles * s.weights[..., None], s.weights[..., None]], axis=2)
        rows = which == number
        expected = rational(NdBSpline((s.knots_u, s.knots_v), h, s.degrees), uv[rows], (1, 0), (0, 1))
        for mine, other in zip(found, expected, strict=True):
            np.testing.assert_allclose(mine[rows], other, rtol=0, atol=ROUND_OFF_MM)


@pytest.mark.parametrize("height_mm", [0.0, 1.0, -3.0])
def test_a_point_above_a_surface_finds_its_foot(height_mm: float) -> None:
    rng = np.random.default_rng(2)
    surfaces = [s for s in random_surfaces(rng, 1.0) if s.degrees == (3, 3)]
    nearest = NearestOnSurfaces.of(surfaces)
    which, uv = rng.integers(0, len(surfaces), 200), rng.uniform(1.0, 6.0, (200, 2))
    p, du, dv = nearest.surfaces.evaluate(which, uv)
    normal = np.cross(du, dv)
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    point = p + height_mm * normal
    foot, fu, fv = nearest.surfaces.evaluate(which, nearest.project(which, point))
    np.testing.assert_allclose(np.linalg.norm(foot - point, axis=1), abs(height_mm), rtol=0, atol=ROUND_OFF_MM)
    np.testing.assert_allclose(
        np.cross(fu, fv) / np.linalg.norm(np.cross(fu, fv), axis=1)[:, None], normal, atol=NORMAL_RAD, rtol=0
    )


@pytest.mark.parametrize("name", ["saddle", "saddle-60", "cross-hole"])
@pytest.mark.parametrize("backwards", [False, True])
def test_the_length_to_the_parameter_is_the_length_asked_for(name: str, backwards: bool) -> None:
    graph, rng = saved_graph(name), np.random.default_rng(7)
    uneven = np.flatnonzero((graph.edge_kind == CurveKind.NURBS) | (graph.edge_kind == CurveKind.ELLIPSE))
    assert len(uneven), "the sample holds no curve with an uneven speed"
    for edge in uneven.tolist():
        t0, t1 = graph.edge_range[edge][:: -1 if backwards else 1]
        whole = abs(cumulative_length(graph, edge, np.array([t0, t1]))[-1])
        s = np.concatenate([[0.0, whole], rng.uniform(0.0, whole, 50)])
        t = parameters_at_length(graph, edge, t0, t1, s)
        assert np.abs(cumulative_length(graph, edge, np.concatenate([[t0], t]))[1:]) == pytest.approx(
            s, abs=1e-10 * whole
        )
        assert t[:2] == pytest.approx([t0, t1], abs=1e-12)
