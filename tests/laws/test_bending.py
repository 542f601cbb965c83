"""Laws of plates that bend: modes of a free beam, derivatives, and bands that cover a beam solved by differences."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pytest

from tests.weldments import Planes, Weldment
from wpcal.calibrate.errors.of_bodies import MeetingPoints, meeting_errors
from wpcal.calibrate.observe.bending import MODES, find_bends
from wpcal.calibrate.observe.bodies import Bodies, KeptContacts, TackTolerance
from wpcal.calibrate.observe.motions import Motions
from wpcal.calibrate.solve.bodies_problem import Problem
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.tangent import exp_rotation

SIGMA_MM, BENDING_MM = 0.2, 1.0
LENGTH_MM, HEIGHT_MM, THICK_MM = 1200.0, 120.0, 8.0
AXIS, NORMAL, UP = np.eye(3)
CENTRE = np.array([0.0, 0.0, HEIGHT_MM / 2.0])
NODES = 241  #: Of the differences: 5 mm apart; the shortest mode that is fitted has a wave of 280 mm.
SMALL_SLOPE = 2e-3  #: Derivatives by an amplitude of bending are those of small slopes: this share of them is left.
SEAM_S = np.linspace(-LENGTH_MM / 2.0, LENGTH_MM / 2.0, 13)


def plate() -> Weldment:
    """Return an upright of 1.2 m on a base, with five touches along it."""
    on_base = [(-700, -150, 0), (700, -150, 0), (0, 150, 0)], [(-700, -200, -5), (700, -200, -5)], [(-750, 0, -5)]
    rows = [(p, n, 0) for points, n in zip(on_base, (UP, -NORMAL, -AXIS), strict=True) for p in points]
    face = [(s, THICK_MM / 2.0, 20.0) for s in (-580.0, -290.0, 0.0, 290.0, 580.0)]
    rows += [(p, NORMAL, 1) for p in [*face, (0.0, THICK_MM / 2.0, 110.0)]]
    rows += [((LENGTH_MM / 2.0, 0.0, 60.0), AXIS, 1), *(((x, 0.0, HEIGHT_MM), UP, 1) for x in (-400.0, 400.0))]
    p, n, body = (np.array(column) for column in zip(*rows, strict=True))
    half = np.array([LENGTH_MM, THICK_MM, HEIGHT_MM]) / 2.0
    corners = [CENTRE + half * np.array([x, y, z]) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    flat = np.array([[x, y, 0.0] for x in (-750.0, 750.0) for y in (-400.0, 400.0)])
    bends = find_bends([flat, np.array(corners)], [np.eye(3)] * 2, BENDING_MM)
    bodies = Bodies(("base", "plate"), np.array([[0, 0, -5.0], CENTRE]), (TackTolerance(),) * 2, bends)
    return Weldment(bodies, p.astype(float), n.astype(float), body, Planes(p.astype(float), n.astype(float)))


@dataclass(frozen=True, slots=True, eq=False)
class Beam:
    """A bent plate, as differences on a grid give it: displacement and slope of the nodes."""

    w: FloatArray
    slope: FloatArray

    def at(self, s: FloatArray) -> tuple[FloatArray, FloatArray]:
        grid = np.linspace(-LENGTH_MM / 2.0, LENGTH_MM / 2.0, NODES)
        return np.interp(s, grid, self.w), np.interp(s, grid, self.slope)


def beams(rng: np.random.Generator, runs: int, *, couples: bool) -> list[Beam]:
    """Solve free beams of stiffness 1 under random loads: K w = f with K from second differences.

    Couples that are white noise along the beam give the curvature that the prior has. Forces give smoother curves,
    here of the same root mean square.
    """
    step = LENGTH_MM / (NODES - 1)
    D = np.diff(np.eye(NODES), 2, axis=0) / step**2
    K = D.T @ D
    if couples:
        spread = np.sqrt(420.0 * BENDING_MM**2 / 1000.0**3 / step)
        f = D.T @ (spread * rng.standard_normal((NODES - 2, runs)))
    else:
        s = np.linspace(-1.0, 1.0, NODES)
        rigid = np.linalg.qr(np.stack([np.ones(NODES), s], axis=1))[0]
        f = rng.standard_normal((NODES, runs))
        f -= rigid @ (rigid.T @ f)  # loads in balance
    w = np.linalg.pinv(K, rcond=1e-12, hermitian=True) @ f  # the least one: without motion and turn
    if not couples:
        w *= BENDING_MM * (LENGTH_MM / 1000.0) ** 1.5 / np.sqrt(np.mean(w**2))
    return [Beam(each, np.gradient(each, step)) for each in w.T]


def bent(beam: Beam, p: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points of the plate after bending, and the turn of their cross-sections."""
    s = (p - CENTRE) @ AXIS
    w, slope = beam.at(s)
    L = exp_rotation(np.outer(np.arctan(slope), np.cross(AXIS, NORMAL)))
    on_axis = CENTRE + s[:, None] * AXIS
    return on_axis + w[:, None] * NORMAL + np.einsum("nij,nj->ni", L, p - on_axis), L


def seam_of(motions: Motions, beam: Beam) -> FloatArray:
    """Where the bent wall meets the base, in `base`: three planes at every cross-section."""
    R, t = motions.moves()
    foot = np.stack([SEAM_S, np.full(len(SEAM_S), THICK_MM / 2.0), np.zeros(len(SEAM_S))], axis=1)
    p, L = bent(beam, foot)
    turned = R[1] @ L
    A = np.stack([turned @ NORMAL, np.tile(R[0] @ UP, (len(p), 1)), turned @ AXIS], axis=1)
    moved = p @ R[1].T + t[1]
    heights = [
        np.einsum("ni,ni->n", A[:, 0], moved),
        np.full(len(p), R[0] @ UP @ t[0]),
        np.einsum("ni,ni->n", A[:, 2], moved),
    ]
    return motions.T_base_part.apply(np.linalg.solve(A, np.stack(heights, axis=1)[..., None])[..., 0])


def fitted_seam(motions: Motions) -> MeetingPoints:
    """The same from the fit, as points whose error is known."""
    n = len(SEAM_S)
    foot = np.stack([SEAM_S, np.full(n, THICK_MM / 2.0), np.zeros(n)], axis=1)
    wall, base = np.ones(n, dtype=np.int64), np.zeros(n, dtype=np.int64)
    (R, t), (Rb, tb) = motions.moves_at(wall, foot), motions.moves_at(base, foot)
    A = np.stack([R @ NORMAL, Rb @ UP, R @ AXIS], axis=1)
    moved = np.einsum("nij,nj->ni", R, foot) + t
    right = [np.einsum("ni,ni->n", A[:, k], at) for k, at in enumerate((moved, tb, moved))]
    p = np.linalg.solve(A, np.stack(right, axis=1)[..., None])[..., 0]
    return MeetingPoints(p, wall, base, A[:, 0], A[:, 1], A[:, 2], np.ones(n, dtype=bool))


def covered(runs: int, *, couples: bool = True, fit_bending: bool = True) -> float:
    """Share of seam points that lie within the band."""
    part, rng = plate(), np.random.default_rng(19)
    own = (
        part
        if fit_bending
        else replace(part, bodies=Bodies(part.bodies.names, part.bodies.centroid_part, part.bodies.tolerances))
    )
    inside = []
    for beam in beams(rng, runs, couples=couples):
        true = part.drawn(rng)
        on_plate = part.body == 1
        p = part.p.copy()
        p[on_plate] = bent(beam, p[on_plate])[0]
        touches = replace(part, p=p).touched(true, SIGMA_MM, rng)
        found = own.fitted(touches, true.T_base_part, SIGMA_MM)
        points = fitted_seam(found.motions)
        off = np.linalg.norm(found.T_base_part.apply(points.p_part) - seam_of(true, beam), axis=1)
        inside.append(off <= meeting_errors(found, points).total_mm)
    return float(np.mean(inside))


def test_only_the_long_plate_bends_and_only_across_itself() -> None:
    bends = plate().bodies.bends
    assert bends.body.tolist() == [1]
    assert np.allclose(np.abs(bends.axis), [AXIS], atol=1e-12)
    assert np.allclose(np.abs(bends.normal), [NORMAL], atol=1e-12)


def test_modes_are_those_of_a_free_beam_by_differences() -> None:
    bends = plate().bodies.bends
    s = np.linspace(-LENGTH_MM / 2.0, LENGTH_MM / 2.0, NODES)
    w, slope = bends.shapes(0, s)
    before, after = (bends.shapes(0, s + step)[0][1:-1] for step in (-1e-3, 1e-3))
    assert np.allclose((after - before) / 2e-3, slope[1:-1], rtol=1e-6, atol=1e-8)
    D = np.diff(np.eye(NODES), 2, axis=0)
    modes = np.linalg.eigh(D.T @ D)[1][:, 2 : 2 + MODES]
    overlap = np.abs(np.sum(modes * w / np.linalg.norm(w, axis=0), axis=0))
    assert (overlap > 0.995).all()  # the differences have half a cell more at each end
    total = np.sum(bends.scales**2)
    assert np.isclose(total, BENDING_MM**2 * (LENGTH_MM / 1000.0) ** 3, rtol=0.005)


def test_derivatives_are_those_of_the_motion() -> None:
    part, rng = plate(), np.random.default_rng(3)
    bodies, h = part.bodies, 1e-6
    true = part.drawn(rng)
    at = Motions(bodies, true.T_base_part, true.omega, true.v_mm, bodies.bends.scales * rng.standard_normal(MODES))
    J = at.jacobian(part.body, part.p)
    for k in range(12, 12 + MODES):
        more = replace(at, bend_mm=at.bend_mm + h * np.eye(MODES)[k - 12])
        assert np.allclose((more.apply(part.body, part.p) - at.apply(part.body, part.p)) / h, J[:, :, k], atol=0.02)
    assert np.abs(at.material(part.body, at.apply(part.body, part.p)) - part.p).max() < 1e-9
    by = np.array([70.0, -50.0, 30.0])
    elsewhere = replace(at, bodies=replace(bodies, centroid_part=bodies.centroid_part + by))
    assert np.abs(elsewhere.apply(part.body, part.p + by) - by - at.apply(part.body, part.p)).max() < 1e-9
    assert np.abs(elsewhere.jacobian(part.body, part.p + by) - J).max() < 1e-9


def test_the_slope_of_the_sum_of_squares_is_its_gradient() -> None:
    """With motions, bending, a kept contact and two shared errors at once, each with values of its own."""
    part, rng = plate(), np.random.default_rng(7)
    bodies, true, n = part.bodies, part.drawn(rng, scale=2.0), len(part.p)
    shared = rng.normal(size=(n, 3, 2))
    own = np.tile(SIGMA_MM**2 * np.eye(3), (n, 1, 1)) + shared @ shared.transpose(0, 2, 1)
    touches = replace(part.touched(true, 3.0, rng), covariances=own, shared=shared)
    kept = KeptContacts(
        rng.normal(size=(4, 3)) * 300.0,
        rng.normal(size=(4, 3)),
        *np.array([[0] * 4, [1] * 4]),
        rng.uniform(0.5, 3.0, 4),
    )
    problem = Problem.of(touches, part.body, bodies, kept)
    bend_mm = bodies.bends.scales * rng.standard_normal(MODES)
    at = problem.state(Motions(bodies, true.T_base_part, true.omega, true.v_mm, bend_mm), rng.normal(size=2))
    gradient, H = problem.normal_equations(at)
    for moved in (problem.with_whole, problem.in_place):
        slopes = [(problem.cost(moved(at, h)) - problem.cost(moved(at, -h))) / 4e-5 for h in 1e-5 * np.eye(len(H))]
        np.testing.assert_allclose(slopes, gradient, rtol=SMALL_SLOPE, atol=1e-6 * np.abs(gradient).max())


def test_a_stiff_plate_gives_the_fit_without_bending(golden: Callable[[object], None]) -> None:
    part, rng = plate(), np.random.default_rng(4)
    true = part.drawn(rng)
    touches = part.touched(true, SIGMA_MM, rng)
    stiff = replace(part, bodies=replace(part.bodies, bends=replace(part.bodies.bends, sigma_mm=1e-6)))
    rigid = replace(part, bodies=Bodies(part.bodies.names, part.bodies.centroid_part, part.bodies.tolerances))
    a, b = (own.fitted(touches, true.T_base_part, SIGMA_MM).motions for own in (stiff, rigid))
    assert np.abs(a.v_mm - b.v_mm).max() < 1e-6
    assert np.abs(a.omega - b.omega).max() < 1e-9
    golden(part.moved(touches, true.T_base_part, SIGMA_MM).to_record())


@pytest.mark.parametrize(("sigma_mm", "word"), [(0.0, "positive"), (np.nan, "positive")])
def test_a_bending_that_is_not_positive_is_one_line(sigma_mm: float, word: str) -> None:
    with pytest.raises(InputError, match=word):
        find_bends([np.eye(3)], [np.eye(3)], sigma_mm)


def test_the_band_covers_bent_plates() -> None:
    assert 0.88 <= covered(30) <= 0.99  # of 30 plates; 2000 are a deep test


@pytest.mark.deep
def test_the_band_covers_2000_bent_plates(record_property: Callable[[str, str], None]) -> None:
    share, smoother, rigid = covered(2000), covered(2000, couples=False), covered(500, fit_bending=False)
    record_property(
        "measured",
        f"couples {100 * share:.1f} % (2000), forces {100 * smoother:.1f} % (2000); "
        f"fitted without bending {100 * rigid:.1f} % (500)",
    )
    assert 0.93 <= share <= 0.97
