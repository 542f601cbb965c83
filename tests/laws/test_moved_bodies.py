"""Laws of weldments whose bodies moved: limits of the tolerance, exactness without noise, false alarms, coverage."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.stats import chi2, multivariate_normal, norm

from tests.few import few
from tests.weldments import Weldment, uprights
from wpcal.calibrate.errors.of_bodies import MeetingPoints, meeting_errors
from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.calibrate.errors.robot_field import RobotField, correlation
from wpcal.calibrate.moved import fit_moved_bodies
from wpcal.calibrate.observe.bodies import Bodies, TackTolerance
from wpcal.calibrate.observe.motions import Motions
from wpcal.calibrate.solve.bodies import BodiesFit
from wpcal.calibrate.solve.bodies_problem import Whitened
from wpcal.calibrate.solve.touches import Pose, fit_squares
from wpcal.calibrate.trust import motion_evidence as evidence
from wpcal.calibrate.trust.motion_evidence import judge_motion
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError

SIGMA_MM = 0.2
RUNS_WITH_FIELDS = 60


def test_small_tolerance_gives_the_rigid_fit() -> None:
    rng = np.random.default_rng(1)
    part = uprights(3)
    true = part.drawn(rng)
    touches = part.touched(true, SIGMA_MM, rng)
    found = part.fitted(touches, true.T_base_part, SIGMA_MM, factor=1e-7).T_base_part
    rigid = fit_squares(touches, Pose.of(touches, true.T_base_part.R, true.T_base_part.t_mm))
    off = found.apply(part.p) - part.p @ rigid.R.T - rigid.t
    assert np.abs(off).max() < 1e-9


def test_large_tolerance_gives_every_body_its_own_fit() -> None:
    rng = np.random.default_rng(2)
    part = uprights(6)
    true = part.drawn(rng)
    touches = part.touched(true, SIGMA_MM, rng)
    found = part.fitted(touches, true.T_base_part, SIGMA_MM, factor=1e3)
    R, t = found.motions.poses()
    for b in range(len(part.bodies)):
        own = touches.select(np.flatnonzero(part.body == b))
        alone = fit_squares(own, Pose.of(own, true.poses()[0][b], true.poses()[1][b]))
        assert np.abs(R[b] - alone.R).max() < 1e-6
        assert np.abs(t[b] - alone.t).max() < 1e-3


def test_motions_are_exact_without_noise() -> None:
    rng = np.random.default_rng(3)
    part = uprights(6)
    for _ in range(5):
        true = part.drawn(rng)
        touches = part.touched(true, 0.0, rng)
        found = part.fitted(touches, true.T_base_part, 1e-3, factor=100.0)
        points = _seam_points(part)
        assert (
            np.linalg.norm(_on_seams(part, found.motions, points) - _on_seams(part, true, points), axis=1).max() < 1e-6
        )


def test_the_parts_of_the_error_are_within_the_whole(golden: Any) -> None:
    """Uprights touched on their large faces only: along the seam nothing holds them but the tacks."""
    rng = np.random.default_rng(4)
    part = uprights(2)
    true = part.drawn(rng)
    found = part.fitted(part.touched(true, SIGMA_MM, rng), true.T_base_part, SIGMA_MM)
    errors = meeting_errors(found, _meeting(part, found))
    assert (errors.placing_mm <= errors.total_mm + 1e-9).all()
    assert (errors.unseen_mm <= errors.total_mm + 1e-9).all()
    assert (errors.across_mm < errors.total_mm / 2.0).all()
    assert (errors.placing_mm + errors.unseen_mm >= errors.total_mm - 1e-9).all()
    values = np.linalg.eigvalsh(found.covariance - found.unseen)
    assert values.min() > -1e-9
    golden([errors, found])


@pytest.mark.parametrize("each", few([1, 6], 1))
def test_a_fifth_of_rigid_parts_has_a_p_below_a_fifth(each: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """With few touches too; drawn parts are fewer here than in use, which is coarser."""
    monkeypatch.setattr(evidence, "DRAWS", 400)
    share = np.mean(_p_of_rigid_parts(uprights(each), 80) < 0.2)
    assert 0.05 <= share <= 0.37  # of 80; others are less probable than 0.001


@pytest.mark.deep
@pytest.mark.parametrize("each", [1, 2, 6])
def test_a_rigid_part_is_rarely_called_moved(each: int) -> None:
    p = _p_of_rigid_parts(uprights(each), 2000)
    print(f"{each} touches on each upright: {np.mean(p < evidence.SURE):.4f} below {evidence.SURE}")
    assert np.mean(p < evidence.SURE) <= 0.05


def _p_of_rigid_parts(part: Weldment, runs: int) -> FloatArray:
    rng = np.random.default_rng(5)
    p = []
    for seed in range(runs):
        true = part.drawn(rng, scale=0.0)
        found = part.fitted(part.touched(true, SIGMA_MM, rng), true.T_base_part, SIGMA_MM)
        p.append(judge_motion(found.whitened, seed=seed).p_rigid)
    return np.array(p)


def test_the_evidence_is_that_of_densities_and_of_a_weighted_fit() -> None:
    """Of two bodies with strong and weak directions: the ratio in a simulation of its own, each body by its χ²."""
    rng = np.random.default_rng(4)
    J, B = rng.normal(size=(20, 3)), rng.normal(size=(20, 12)) * np.geomspace(3.0, 0.03, 12)[rng.permutation(12)]
    r = rng.normal(size=20) + 0.3 * B @ rng.normal(size=12)
    y, Z = (null_space(J.T).T @ each for each in (r, B))
    models = [multivariate_normal(cov=np.eye(17) + s**2 * Z @ Z.T) for s in evidence.SCALES]
    rows = np.vstack([y, rng.standard_normal((4000, 17))])
    ratio = np.max([model.logpdf(rows) - models[0].logpdf(rows) for model in models], axis=0)
    found = judge_motion(Whitened(r, J, B, np.arange(20), 0))
    assert found.p_rigid == pytest.approx(np.mean(ratio[1:] >= ratio[0]), abs=0.025)  # three sampling errors
    assert found.seen == pytest.approx(np.trace(np.linalg.solve(np.eye(17) + Z @ Z.T, Z @ Z.T)))
    for b, own in enumerate((Z[:, :6], Z[:, 6:])):
        W = np.linalg.inv(np.eye(17) + Z @ Z.T - own @ own.T)
        square = y @ W @ own @ np.linalg.solve(own.T @ W @ own, own.T @ W @ y)
        assert found.sigmas[b] == pytest.approx(norm.isf(chi2.sf(square, 6) / 2.0))


def test_the_body_that_moved_is_named() -> None:
    rng = np.random.default_rng(6)
    part = uprights(6)
    true = part.drawn(rng, scale=0.0)
    v = true.v_mm.copy()
    v[3] = [0.0, 0.0, 2.5]
    moved = Motions(part.bodies, true.T_base_part, true.omega, v)
    touches = part.touched(moved, SIGMA_MM, rng)
    found = part.moved(touches, true.T_base_part, SIGMA_MM)
    assert found.evidence.has_moved
    assert [part.bodies.names[b] for b in found.moved] == ["U3"]
    assert "U3" in found.sentence()


def test_a_wrong_touch_is_named_also_if_bodies_moved() -> None:
    rng = np.random.default_rng(7)
    part = uprights(6)
    true = part.drawn(rng)
    touches = part.touched(true, SIGMA_MM, rng)
    touches.p_base[9] += 30.0 * true.poses()[0][part.body[9]] @ part.n[9]
    found = fit_moved_bodies(touches, part.body, part.bodies, true.T_base_part, sigma_mm=SIGMA_MM)
    assert "T9" in found.wrong


def _seam_points(part: Weldment) -> list[tuple[int, FloatArray, FloatArray, FloatArray]]:
    """Body, point, normal and travel of eleven points along the seam of each upright with the base."""
    points = []
    for b in range(1, len(part.bodies)):
        n = part.n[np.flatnonzero(part.body == b)[0]]
        along = np.cross(n, [0.0, 0.0, 1.0])
        foot = part.bodies.centroid_part[b] * [1.0, 1.0, 0.0] + 4.0 * n
        points += [(b, foot + s * along, n, along) for s in np.linspace(-150.0, 150.0, 11)]
    return points


def _on_seams(
    part: Weldment, motions: Motions, points: list[tuple[int, FloatArray, FloatArray, FloatArray]]
) -> FloatArray:
    """Where moved uprights meet the moved base, in `base`: three planes, solved directly."""
    R, t = motions.moves()
    found = []
    for b, p, n, along in points:
        on_wall, on_base = R[b] @ p + t[b], t[0]
        rows = np.stack([R[b] @ n, R[0] @ [0.0, 0.0, 1.0], R[b] @ along])
        found.append(np.linalg.solve(rows, [rows[0] @ on_wall, rows[1] @ on_base, rows[2] @ on_wall]))
    return motions.T_base_part.apply(np.array(found))


def _meeting(part: Weldment, found: BodiesFit) -> MeetingPoints:
    points = _seam_points(part)
    body = np.array([b for b, *_ in points])
    base = np.zeros_like(body)
    motions = found.motions
    n, x = (motions.turned(body, np.array([point[k] for point in points])) for k in (2, 3))
    up = motions.turned(base, np.tile([0.0, 0.0, 1.0], (len(points), 1)))
    p = motions.T_base_part.inverse().apply(_on_seams(part, motions, points))
    return MeetingPoints(p, body, base, n, up, x, np.ones(len(points), dtype=bool))


@pytest.mark.parametrize("is_stated", few([False, True], 1))
def test_the_band_covers_seams_where_the_robot_has_an_error_of_its_own(is_stated: bool) -> None:
    rng, part, field = np.random.default_rng(2031), uprights(6), RobotField(0.3, 300.0)
    inside = []
    for _ in range(RUNS_WITH_FIELDS):
        true = part.drawn(rng)
        touches, seams = part.touched(true, SIGMA_MM, rng), _on_seams(part, true, _seam_points(part))
        places = np.concatenate([touches.p_base, seams])
        root = np.linalg.cholesky(correlation(places, places, field.length_mm) + 1e-9 * np.eye(len(places)))
        off = field.amplitude_mm * root @ rng.standard_normal(places.shape)
        touches = replace(touches, p_base=touches.p_base + off[: len(touches)])
        stated = TeachingError(robot=field if is_stated else None)
        found = part.moved(touches, true.T_base_part, SIGMA_MM, teaching=stated)
        missed = _on_seams(part, found.fit.motions, _seam_points(part)) - seams - off[len(touches) :]
        inside.append(np.linalg.norm(missed, axis=1) <= meeting_errors(found.fit, _meeting(part, found.fit)).total_mm)
    assert (0.92 if is_stated else 0.88) <= np.mean(inside) <= 0.98  # 44 points of one part go together


def _with_tolerance(part: Weldment, mm: float, mrad: float) -> Weldment:
    own = part.bodies
    return replace(part, bodies=Bodies(own.names, own.centroid_part, (TackTolerance(mm, mrad),) * len(own)))


def test_a_body_that_neither_touches_nor_its_tolerance_hold_is_one_line() -> None:
    rng = np.random.default_rng(10)
    held, few = (_with_tolerance(uprights(each), 1e6, 1e6) for each in (6, 2))
    true = uprights(6).drawn(rng)
    held.fitted(held.touched(true, SIGMA_MM, rng), true.T_base_part, SIGMA_MM)
    with pytest.raises(
        GeometryError, match=r"^body U1: 2 touches and a tack tolerance of .* do not hold it: touch more"
    ):
        few.fitted(few.touched(true, SIGMA_MM, rng), true.T_base_part, SIGMA_MM)


def test_bodies_without_touches_rest_on_their_tolerance() -> None:
    rng = np.random.default_rng(11)
    part = uprights(6)
    rows = np.flatnonzero((part.body == 0) | (np.arange(len(part.body)) == 7))  # the base, and one touch on U1
    part = replace(part, p=part.p[rows], n=part.n[rows], body=part.body[rows], targets=part.targets_at(rows))
    true = part.drawn(rng)
    found = part.fitted(part.touched(true, SIGMA_MM, rng), true.T_base_part, SIGMA_MM)
    spread = np.sqrt(np.diag(found.covariance)[30:36])
    assert np.allclose(spread, part.bodies.scales[4], rtol=1e-9)
    assert (np.sqrt(np.diag(found.covariance)[12:18]) <= part.bodies.scales[1] + 1e-12).all()
