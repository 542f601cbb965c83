"""The global search for touches: annealing over all poses, and the evidence of many starts in place of a proof.

For points the least largest distance is proved (`wpcal.calibrate.solve.minimax`). For faces and edges no proof is
known: a touch may slide. So the annealer searches all poses, and the polish is repeated from its best pose turned by
the 24 rotations of a cube. The result says how many of these starts agree, and how good the next best place is.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.solve.touches import Pose, fit_squares_of
from wpcal.calibrate.trust.residuals import FLOOR_MM, LEAST_SIGMA_MM
from wpcal.calibrate.trust.touch_evidence import RivalPlace, StartsEvidence
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import ErrorCode, GeometryError
from wpcal.core.rotations import cube_rotations, rotation_from_zyx
from wpcal.core.tangent import log_rotation
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import short
from wpcal.optim.annealing import AnnealingReport, AnnealingSchedule, anneal
from wpcal.optim.search_box import SearchBox

MOST_SEARCHED = 64
"""Touches that the annealer uses. Of more touches it uses an evenly spaced subset; the polish uses all."""
OFF_FACE_MM = 5.0
"""A pose that puts a contact further than this beyond the border of its face is not the pose that was touched: the
borders of faces are known to a tenth of this."""
SAME_RMS_MM = 1e-6  #: Root mean squares that differ by less are the same optimum.
EXCLUDED = 2.0 * math.log(0.95 / 0.05)
"""A place is excluded if it is less than 1/19 as likely as the best one: twice the logarithm of that ratio."""
FURTHER = 3.0  #: A place this many times as far from the nominal place as the answer is not a rival of it.
SAME_TURN_RAD = 1e-4
SAME_SHIFT_MM = 0.05  #: Poses of the same value that differ by more are two answers.


@dataclass(frozen=True, slots=True, eq=False)
class PoseSearch:
    """The best pose by least squares, and how many starts agree."""

    pose: Pose
    annealed: Pose | None  #: The annealer's best, before the polish.
    run: AnnealingReport | None
    evidence: StartsEvidence
    rival: Pose | None  #: Another place that fits equally well, if no nominal place decides between them.


def search_pose(
    touches: Touches,
    *,
    nominal: RigidTransform | None,
    schedule: AnnealingSchedule | None,
    seed: int,
    sigma_mm: float | None = None,
    seam_points: FloatArray | None = None,
) -> PoseSearch:
    """Search the pose in which the touches lie on their targets.

    `nominal`: ``T_base_part`` where the cell's model has the part: one more start, and the tie break between equal
    answers.
    `seam_points`: shape (k, 3), optional. Part frame, mm: where the distance between two places is measured. By default
    the touched points.
    """
    placed = [] if nominal is None else [(nominal.R, nominal.t_mm)]
    run, annealed = None, None
    first = placed[0] if placed else _centred(touches, np.eye(3))
    if schedule is not None:
        run = _anneal(touches, schedule, seed)
        first = _centred(touches, rotation_from_zyx(*run.state[3:]), run.state[:3])
        annealed = Pose.of(touches, *first)
    starts = [*placed, first, *(_centred(touches, turn @ first[0]) for turn in cube_rotations())]
    found = fit_squares_of(touches, np.array([R for R, _ in starts]), np.array([t for _, t in starts]))
    ends = [found.pose(k) for k in range(len(starts))]
    contacts = found.at.contact_part.reshape(-1, 3)
    over = touches.targets.overhang(np.tile(touches.rows, len(ends)), contacts)
    off = over.reshape(len(ends), -1).max(axis=1)
    values = np.sqrt(np.mean(found.at.distances**2, axis=1))
    judged = np.where(off <= OFF_FACE_MM, values, values + off)
    best = int(np.argmin(judged))
    same = judged <= judged[best] + SAME_RMS_MM
    unlikely = _unlikeliness(touches, ends, best, sigma_mm)
    alike = (off <= OFF_FACE_MM) & (unlikely <= EXCLUDED) if off[best] <= OFF_FACE_MM else same
    away = None
    if nominal is not None:
        away = _moved_from(ends, nominal, touches)
        usable = np.flatnonzero(alike)
        best = int(usable[np.argmin(away[usable])])
        same = np.abs(judged - judged[best]) <= SAME_RMS_MM
    agreeing = np.array([bool(s) and _is_same(end, ends[best], touches) for s, end in zip(same, ends, strict=True)])
    rivals = np.flatnonzero(same & ~agreeing)
    rival = ends[int(rivals[0])] if nominal is None and len(rivals) else None
    others = judged[~same]
    next_best = float(others.min()) if len(others) else None
    if away is not None:
        alike &= away <= FURTHER * away[best]
    order = np.flatnonzero(alike)[np.argsort(judged[alike], kind="stable")]
    places = _other_places([ends[k] for k in order], ends[best], touches, seam_points)
    evidence = StartsEvidence(len(starts), int(agreeing.sum()), next_best, places)
    return PoseSearch(ends[best], annealed, run, evidence, rival)


def _centred(touches: Touches, R: FloatArray, shift: FloatArray | None = None) -> tuple[FloatArray, FloatArray]:
    """Put the middle of the targets, turned by R, at the middle of the touches; return R and t."""
    move = np.zeros(3) if shift is None else shift
    return R, touches.p_base.mean(axis=0) + move - R @ touches.targets.centre


def _anneal(touches: Touches, schedule: AnnealingSchedule, seed: int) -> AnnealingReport:
    """Anneal the largest rough distance over all rotations, the middles no further apart than the targets reach."""
    n = len(touches)
    rows = np.unique(np.linspace(0, n - 1, min(n, MOST_SEARCHED)).round().astype(np.int64))
    searched = touches.select(rows)
    targets, q = touches.targets, searched.p_base - searched.p_base.mean(axis=0)

    def cost(states: FloatArray) -> FloatArray:
        R = rotation_from_zyx(states[:, 3], states[:, 4], states[:, 5])
        x = (q[None] - states[:, None, :3]) @ R + targets.centre
        m = len(states)
        tiled = np.tile(searched.rows, m)
        far = targets.rough_distances(tiled, x.reshape(-1, 3), np.tile(searched.radius_mm, m))
        return np.asarray(far.reshape(m, -1).max(axis=1))

    reach = targets.reach_mm
    high = np.array([reach, reach, reach, np.pi, np.pi, np.pi])
    box = SearchBox.of(-high, high, periodic=(False,) * 3 + (True,) * 3)
    return anneal(cost, box, rng=np.random.default_rng(seed), schedule=schedule)


def _moved_from(ends: list[Pose], nominal: RigidTransform, touches: Touches) -> FloatArray:
    """How far each answer moves the touched points from the nominal place: root mean square, mm, shape (m,)."""
    modelled = nominal.inverse().apply(touches.p_base)
    moved = [np.mean(np.sum((modelled @ end.R.T + end.t - touches.p_base) ** 2, axis=1)) for end in ends]
    return np.asarray(np.sqrt(moved))


def _unlikeliness(touches: Touches, ends: list[Pose], best: int, sigma_mm: float | None) -> FloatArray:
    """Twice the logarithm of how many times the best place is as likely as each place, shape (m,).

    With a known error it is the difference of the sums of squares in its units. Residuals that are larger than a stated
    error explains enlarge it. Otherwise the sums are compared by their ratio.
    """
    sums = np.empty(len(ends))
    for k, end in enumerate(ends):
        information = end.at.information(touches.covariances)
        sums[k] = np.einsum("ni,nij,nj->", end.at.d, information, end.at.d)
    freedom = max(int(ends[best].at.rank.sum()) - 6, 0)
    if touches.covariances is None and sigma_mm is None:
        floor = max(freedom, 1) * FLOOR_MM**2
        return np.asarray(max(freedom, 1) * np.log((sums + floor) / (sums[best] + floor)))
    unit = 1.0 if touches.covariances is not None or sigma_mm is None else max(sigma_mm, LEAST_SIGMA_MM) ** 2
    scale = max(unit, float(sums[best]) / freedom if freedom else 0.0)
    return np.asarray((sums - sums[best]) / scale)


def _other_places(
    ends: list[Pose], answer: Pose, touches: Touches, seam_points: FloatArray | None
) -> tuple[RivalPlace, ...]:
    """Return the places among `ends` that are not the answer, each once."""
    points = answer.at.contact_part if seam_points is None else seam_points
    seen, places = [answer], []
    for end in ends:
        if any(_is_same(end, other, touches) for other in seen):
            continue
        seen.append(end)
        apart = np.linalg.norm(points @ (end.R - answer.R).T + end.t - answer.t, axis=1)
        T = RigidTransform(end.R, end.t, "base", "part")
        places.append(RivalPlace(T, float(np.sqrt(np.mean(end.at.distances**2))), float(apart.max())))
    return tuple(places)


def _is_same(one: Pose, other: Pose, touches: Touches) -> bool:
    turn = float(np.linalg.norm(log_rotation(one.R @ other.R.T)))
    middle = touches.targets.centre
    shift = float(np.linalg.norm((one.R - other.R) @ middle + one.t - other.t))
    return turn <= SAME_TURN_RAD and shift <= SAME_SHIFT_MM


def two_places(touches: Touches, one: Pose, other: Pose) -> GeometryError:
    """Return the error that two places fit equally well."""
    turn = float(np.degrees(np.linalg.norm(log_rotation(other.R @ one.R.T))))
    shift = float(np.linalg.norm((other.R - one.R) @ touches.targets.centre + other.t - one.t))
    return GeometryError(
        f"the touches fit the part in two places, {short(turn)} degrees and {short(shift)} mm apart: give the "
        "rough nominal place of the part, or touch one more face",
        code=ErrorCode.NOMINAL_MISSING,
    )
