"""Rays meet free-form surfaces where closed forms say, twice where they go through one cell twice."""

import numpy as np

from wpcal.brep.nurbs import NurbsSurface
from wpcal.brep.spans import SurfaceSet
from wpcal.brep.surface_cells import SurfaceCells, cell_breaks
from wpcal.brep.surface_rays import meet_rays
from wpcal.core.arrays import FloatArray

EXACT_MM = 1e-8
FAR_MM = 500.0
RADIUS, TUBE = 60.0, 15.0
ARC = np.array([[1, 0], [1, 1], [0, 1], [-1, 1], [-1, 0], [-1, -1], [0, -1], [1, -1], [1, 0]], dtype=float)
ARC_WEIGHTS = np.array([1.0, np.sqrt(0.5)] * 4 + [1.0])
ARC_KNOTS = np.array([0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4.0])


def cells_of(surface: NurbsSurface) -> SurfaceCells:
    polynomials = SurfaceSet.of([surface])
    return SurfaceCells.of(polynomials, cell_breaks([surface], polynomials))


def ring() -> NurbsSurface:
    """A torus about z as one rational surface of 16 patches."""
    across = RADIUS + TUBE * ARC[:, 0]
    poles = np.stack([np.outer(ARC[:, k], across) for k in (0, 1)] + [np.outer(np.ones(9), TUBE * ARC[:, 1])], axis=-1)
    weights = np.outer(ARC_WEIGHTS, ARC_WEIGHTS)
    return NurbsSurface((2, 2), ARC_KNOTS, ARC_KNOTS, poles, weights, (0.0, 4.0, 0.0, 4.0))


def on_ring(p: FloatArray) -> FloatArray:
    return np.asarray(np.hypot(np.hypot(p[..., 0], p[..., 1]) - RADIUS, p[..., 2]) - TUBE)


def test_rays_through_a_ring_meet_it_where_its_equation_changes_sign() -> None:
    rng = np.random.default_rng(3)
    origins = rng.uniform(-100, 100, (400, 3)) * [1, 1, 0.3]
    rays = rng.normal(size=(400, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    low, high = np.zeros(400), np.full(400, FAR_MM)
    found = meet_rays(cells_of(ring()), np.zeros(400, dtype=np.int64), origins, rays, low, high)
    points = origins[found.row] + found.at_mm[:, None] * rays[found.row]
    assert np.abs(on_ring(points)).max() < EXACT_MM
    t = np.linspace(0.0, FAR_MM, 20_001)
    sides = on_ring(origins[:, None] + t[:, None] * rays[:, None]) > 0
    crossings = (sides[:, 1:] != sides[:, :-1]).sum(axis=1)
    assert crossings.sum() > 150
    met = np.bincount(found.row, minlength=400)
    assert (met >= crossings).all()
    assert (met != crossings).mean() < 0.01, "pairs of crossings less than 0.03 mm apart are missed by the steps only"


def test_a_ray_along_a_ring_meets_the_outermost_of_it_twice() -> None:
    off = np.array([1e-4, 1e-2, 1.0])
    origins = np.column_stack([np.full(3, RADIUS + TUBE) - off, np.full(3, -200.0), np.zeros(3)])
    rays = np.tile([0.0, 1.0, 0.0], (3, 1))
    found = meet_rays(cells_of(ring()), np.zeros(3, dtype=np.int64), origins, rays, np.zeros(3), np.full(3, FAR_MM))
    half = np.sqrt((RADIUS + TUBE) ** 2 - (RADIUS + TUBE - off) ** 2)
    for row in range(3):
        at = np.sort(found.at_mm[found.row == row])
        np.testing.assert_allclose(at[[0, -1]], [200 - half[row], 200 + half[row]], rtol=0, atol=1e-6)


def test_a_twisted_surface_is_met_twice() -> None:
    """z = x y / 50 on a square of 100 mm, which is one patch of degree one: rays along a diagonal meet it twice."""
    x = np.array([-50.0, 50.0])
    poles = np.stack([*np.meshgrid(x, x, indexing="ij"), np.outer(x, x) / 50.0], axis=-1)
    surface = NurbsSurface(
        (1, 1), np.array([0, 0, 1, 1.0]), np.array([0, 0, 1, 1.0]), poles, np.ones((2, 2)), (0, 1, 0, 1)
    )
    height = np.array([0.001, 1.0, 20.0])
    origins = np.column_stack([np.full(3, -70.0), np.full(3, -70.0), height])
    rays = np.tile(np.array([1.0, 1.0, 0.0]) / np.sqrt(2), (3, 1))
    found = meet_rays(cells_of(surface), np.zeros(3, dtype=np.int64), origins, rays, np.zeros(3), np.full(3, FAR_MM))
    for row in range(3):
        along = np.sqrt(50.0 * height[row])
        at = found.at_mm[found.row == row] / np.sqrt(2) - 70.0
        np.testing.assert_allclose(np.sort(at), [-along, along], rtol=0, atol=1e-6)


def test_the_boxes_of_cells_hold_the_surface() -> None:
    cells = cells_of(ring())
    rng = np.random.default_rng(5)
    cell = rng.integers(len(cells.low), size=3000)
    uv = rng.uniform(cells.low[cell], cells.high[cell])
    p = cells.surfaces.evaluate(np.zeros(3000, dtype=np.int64), uv)[0]
    assert (p >= cells.levels[0].low.T[cell]).all()
    assert (p <= cells.levels[0].high.T[cell]).all()
    size = np.linalg.norm(cells.levels[0].high - cells.levels[0].low, axis=0)
    assert size.max() < 40.0
