"""The published search put to the annealer: six variables, the largest distance, and the box they move in.

Two parametrisations of one motion ``p_target = Rz(γ) Ry(β) Rx(α) p_source + t``. `about_centroid` turns the cloud about
its own centroid, so a small angle is a small motion, however far the base is. `about_origin` is the paper's: the six
variables are those of the operator itself, about the origin of the base.

References: Yin, Chen, Lu (2003), eq. (5) and (6).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.calibrate.solve.minimax import core_subset
from wpcal.core.arrays import FloatArray
from wpcal.core.pairs import PointPairs
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.optim.annealing import AnnealingReport, AnnealingSchedule, Cost, StateVariables, anneal
from wpcal.optim.search_box import SearchBox

HALF_TURN = np.pi
TURNS = (False,) * 3 + (True,) * 3  #: The variables of a state that are full turns.
LEAST_RANGE_MM = 1.0
"""Least range of the search, for a part that is exactly where it was modelled: larger than any teaching error."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchProblem:
    """A cost and its box, and how a state becomes a rigid motion."""

    cost: Cost  #: States (m, 6) to largest distances (m,), mm.
    box: SearchBox  #: x, y, z in mm; α, β, γ in rad.
    start: FloatArray | None  #: shape (6,). Where the paper's single chain starts.
    #: `pivot_source`, `pivot_target`: shape (3,). The point the source turns about, and where it goes at zero
    #: translation.
    pivot_source: FloatArray
    pivot_target: FloatArray

    def motion(self, state: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rotation (3, 3) and translation (3,), mm, of a state of shape (6,), between the frames of the points."""
        R = rotation_from_zyx(state[3], state[4], state[5])
        t = self.pivot_target + state[:3] - R @ self.pivot_source
        return R, np.asarray(t, dtype=np.float64)


def anneal_pairs(
    pairs: PointPairs,
    *,
    nominal: RigidTransform | None = None,
    schedule: AnnealingSchedule | None = None,
    seed: int = 0,
) -> tuple[RigidTransform, AnnealingReport]:
    """Search the least largest distance by annealing alone.

    `pairs`: mm. Of more than 64 pairs the annealer sees the 64 that matter most.
    Returns `T`: RigidTransform. ``T_target_source``, not polished.
    """
    chosen = schedule or AnnealingSchedule.default()
    rows = core_subset(pairs.p_source, pairs.p_target)
    p, q = pairs.p_source[rows], pairs.p_target[rows]
    if chosen.variables is StateVariables.ABOUT_CENTROID:
        problem = about_centroid(p, q)
        run = _run(problem, chosen, seed)
        return RigidTransform(*problem.motion(run.state), pairs.target, pairs.source), run
    place = nominal or RigidTransform.identity(target="nominal", source=pairs.source)
    problem = about_origin(place.apply(p), q)
    run = _run(problem, chosen, seed)
    R, t = problem.motion(run.state)
    return RigidTransform(R, t, pairs.target, place.target) @ place, run


def _run(problem: SearchProblem, schedule: AnnealingSchedule, seed: int) -> AnnealingReport:
    rng = np.random.default_rng(seed)
    return anneal(problem.cost, problem.box, rng=rng, schedule=schedule, start=problem.start)


def about_centroid(p: FloatArray, q: FloatArray) -> SearchProblem:
    """Search every rotation, with the centroid within one radius of the cloud of its counterpart.

    At the optimum the centroids are no further apart than the largest distance, and the best fit is never worse than
    the cloud's radius, which both clouds put at one point would give.

    `p`, `q`: shape (n, 3). Source and target points, mm.
    """
    pivot_p, pivot_q = p.mean(axis=0), q.mean(axis=0)
    radius = max(float(np.linalg.norm(c, axis=1).max()) for c in (p - pivot_p, q - pivot_q))
    high = np.array([radius, radius, radius, HALF_TURN, HALF_TURN, HALF_TURN])
    cost = largest_distance_cost(p - pivot_p, q - pivot_q)
    return SearchProblem(cost, SearchBox.of(-high, high, TURNS), None, pivot_p, pivot_q)


def about_origin(p: FloatArray, q: FloatArray) -> SearchProblem:
    """Search the six-tuple itself, about the base's origin, starting where the model puts the part.

    The paper does not print R_i and the start. Ours: the start is the identity (the part is about where the model has
    it). A part that was only shifted moves all points alike, so the angles may turn the cloud by twice what the
    displacements differ from their mean, and the translations may undo what that turn does at the part's distance
    from the origin.

    `p`, `q`: shape (n, 3). Modelled and taught points, both in base coordinates, mm.
    """
    shift = (q - p).mean(axis=0)
    differing = float(np.linalg.norm(q - p - shift, axis=1).max())
    radius = float(np.linalg.norm(p - p.mean(axis=0), axis=1).max())
    angle = min(HALF_TURN, 2.0 * max(differing, LEAST_RANGE_MM) / radius)
    lever = 2.0 * np.sin(angle / 2.0) * float(np.linalg.norm(p.mean(axis=0)))
    reach = LEAST_RANGE_MM + float(np.linalg.norm(shift)) + lever
    high = np.array([reach, reach, reach, angle, angle, angle])
    zero = np.zeros(3)
    return SearchProblem(largest_distance_cost(p, q), SearchBox.of(-high, high), np.zeros(6), zero, zero)


def largest_distance_cost(p: FloatArray, q: FloatArray) -> Cost:
    """Return the cost of Yin 2003, eq. (5), of many states at once.

    `p`, `q`: shape (n, 3). Source and target points, mm.
    Returns: States (m, 6), (x, y, z, α, β, γ) in mm and rad, to largest distances (m,), mm.
    """
    p_rows = np.ascontiguousarray(p, dtype=np.float64)
    q_columns = np.ascontiguousarray(np.asarray(q, dtype=np.float64).T)[:, :, None]

    def cost(states: FloatArray) -> FloatArray:
        columns = np.ascontiguousarray(states.T)  # the states along the last axis: long inner loops
        residuals = p_rows @ _rotations(columns[3:])  # (3, n, m)
        residuals += columns[:3, None, :]
        residuals -= q_columns
        residuals *= residuals
        return np.asarray(np.sqrt(residuals.sum(axis=0).max(axis=0)), dtype=np.float64)

    return cost


def _rotations(angles: FloatArray) -> FloatArray:
    """`rotation_from_zyx` of angles (3, m) for the inner loop: row i of every matrix, transposed, shape (3, 3, m)."""
    (ca, cb, cg), (sa, sb, sg) = np.cos(angles), np.sin(angles)
    R = np.empty((3, 3, angles.shape[1]))
    cg_sb, sg_sb = cg * sb, sg * sb
    np.multiply(cg, cb, out=R[0, 0])
    np.subtract(cg_sb * sa, sg * ca, out=R[0, 1])
    np.add(cg_sb * ca, sg * sa, out=R[0, 2])
    np.multiply(sg, cb, out=R[1, 0])
    np.add(sg_sb * sa, cg * ca, out=R[1, 1])
    np.subtract(sg_sb * ca, cg * sa, out=R[1, 2])
    np.negative(sb, out=R[2, 0])
    np.multiply(cb, sa, out=R[2, 1])
    np.multiply(cb, ca, out=R[2, 2])
    return R
