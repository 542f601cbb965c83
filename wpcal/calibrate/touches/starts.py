"""The global search for touches: annealing over all poses, and the evidence of many starts in place of a proof.

For points the least largest distance is proved (`wpcal.calibrate.points.minimax`). For faces and edges no proof is
known: a touch may slide. So the annealer searches all poses, and the polish is repeated from its best pose turned by
the 24 rotations of a cube. The result says how many of these starts agree, and how good the next best place is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.calibrate.touches.evidence import StartsEvidence
from wpcal.calibrate.touches.fit import Pose, fit_squares
from wpcal.calibrate.touches.touches import Touches
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import ErrorCode, GeometryError
from wpcal.core.rotations import cube_rotations, rotation_from_zyx
from wpcal.core.tangent import log_rotation
from wpcal.core.transform import RigidTransform
from wpcal.optim.annealing import AnnealingReport, AnnealingSchedule, anneal

MOST_SEARCHED = 64
"""Touches that the annealer uses. Of more touches it uses an evenly spaced subset; the polish uses all."""
OFF_FACE_MM = 5.0
"""A pose that puts a contact further than this beyond the border of its face is not the pose that was touched: the
borders of faces are known to a tenth of this."""
SAME_RMS_MM = 1e-6
"""Root mean squares that differ by less are the same optimum."""
SAME_TURN_RAD = 1e-4
SAME_SHIFT_MM = 0.05
"""Poses of the same value that differ by more are two answers."""


@dataclass(frozen=True, slots=True, eq=False)
class PoseSearch:
    """The best pose by least squares, and how many starts agree.

    Parameters
    ----------
    pose : Pose
    annealed : Pose or None
        The annealer's best, before the polish.
    run : AnnealingReport or None
    evidence : StartsEvidence
    rival : Pose or None
        Another place that fits equally well, if no nominal place decides between them.
    """

    pose: Pose
    annealed: Pose | None
    run: AnnealingReport | None
    evidence: StartsEvidence
    rival: Pose | None


def search_pose(
    touches: Touches,
    *,
    nominal: RigidTransform | None,
    schedule: AnnealingSchedule | None,
    seed: int,
) -> PoseSearch:
    """Search the pose in which the touches lie on their targets.

    Parameters
    ----------
    touches : Touches
    nominal : RigidTransform, optional
        ``T_base_part`` where the cell's model has the part: one more start, and the tie break between equal answers.
    schedule : AnnealingSchedule or None
        None: no annealing, only the starts.
    seed : int

    Returns
    -------
    PoseSearch
    """
    starts = [] if nominal is None else [Pose.of(touches, nominal.R, nominal.t_mm)]
    run, annealed = None, None
    first = starts[0] if starts else _centred(touches, np.eye(3))
    if schedule is not None:
        run = _anneal(touches, schedule, seed)
        first = _centred(touches, rotation_from_zyx(*run.state[3:]), run.state[:3])
        annealed = first
    starts += [first, *(_centred(touches, turn @ first.R) for turn in cube_rotations())]
    ends = [fit_squares(touches, start) for start in starts]
    off = np.array([float(touches.targets.overhang(touches.rows, end.at.contact_part).max()) for end in ends])
    values = np.array([np.sqrt(np.mean(end.at.distances**2)) for end in ends])
    judged = np.where(off <= OFF_FACE_MM, values, values + off)
    best = int(np.argmin(judged))
    same = judged <= judged[best] + SAME_RMS_MM
    if nominal is not None:
        best = _nearest(ends, np.flatnonzero(same), nominal, touches)
    agreeing = np.array([bool(s) and _is_same(end, ends[best], touches) for s, end in zip(same, ends, strict=True)])
    rivals = np.flatnonzero(same & ~agreeing)
    rival = ends[int(rivals[0])] if nominal is None and len(rivals) else None
    others = judged[~same]
    evidence = StartsEvidence(len(starts), int(agreeing.sum()), float(others.min()) if len(others) else None)
    return PoseSearch(ends[best], annealed, run, evidence, rival)


def _centred(touches: Touches, R: FloatArray, shift: FloatArray | None = None) -> Pose:
    """Put the middle of the targets, turned by R, at the middle of the touches."""
    move = np.zeros(3) if shift is None else shift
    return Pose.of(touches, R, touches.p_base.mean(axis=0) + move - R @ touches.targets.centre)


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
    return anneal(
        cost, -high, high, rng=np.random.default_rng(seed), schedule=schedule, periodic=(False,) * 3 + (True,) * 3
    )


def _nearest(ends: list[Pose], rows: IntArray, nominal: RigidTransform, touches: Touches) -> int:
    """Of equal answers, take the one that moves the touched points least from the nominal place."""
    modelled = nominal.inverse().apply(touches.p_base)
    away = [float(np.sum((modelled @ ends[k].R.T + ends[k].t - touches.p_base) ** 2)) for k in rows]
    return int(rows[int(np.argmin(away))])


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
        f"the touches fit the part in two places, {turn:.3g} degrees and {shift:.3g} mm apart: give the "
        "rough nominal place of the part, or touch one more face",
        code=ErrorCode.NOMINAL_MISSING,
    )
