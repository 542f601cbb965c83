r"""Fit the pose of a weldment and the motions of its bodies to touches.

With :math:`d_i` the residual of touch i on body b(i), :math:`\Lambda_i` the inverse of its covariance, and the motions
:math:`\delta_b = S_b u_b` scaled by the tack tolerances,

.. math:: \min_{T, u} \sum_i d_i^\top \Lambda_i d_i + \sum_b u_b^\top u_b + \sum_k (g_k / \sigma_k)^2,

where :math:`g_k` is the gap that opens at a kept contact. This is the most likely answer if the motions are Gaussian.
Its covariance is :math:`H^{-1}`, and

.. math:: H^{-1} = H^{-1} (H - P) H^{-1} + H^{-1} P H^{-1}, \qquad P = \mathrm{diag}(0_6, I):

the first part is what the errors of the touches leave, the second what of the bodies' motions no touch saw.

Errors that all touches share (of the stick-out, of the latency) are unknowns too: z standard deviations of each, with
:math:`z^\top z` in the sum. Counted as errors of each touch alone they would pass for motions of bodies.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from wpcal.calibrate.errors.modes import ErrorModes
from wpcal.calibrate.observe.bodies import Bodies, KeptContacts
from wpcal.calibrate.observe.motions import Motions, left_jacobian
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.solve.bodies_problem import (
    LEAST_HELD,
    BodiesState,
    Problem,
    Whitened,
    linearised_each,
    touched_poses,
)
from wpcal.calibrate.solve.curved import on_curved_faces
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import ConvergenceError, GeometryError, InputError
from wpcal.core.pairs import PointPairs
from wpcal.core.tangent import point_jacobian
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import counted
from wpcal.optim.levenberg_marquardt import minimise_squares

GAUSS_NEWTON_STEPS = 40
MOST_STEPS = 400  #: Of BFGS.
SETTLED = 1e-4  #: The slope of the cost, in standard deviations of the answer, at which the fit counts as settled.
POLISHED = 1e-7  #: The same after Gauss-Newton: a tenth of a nanometre where touches have an error of a millimetre.
POLISHING_STEPS = 5  #: Each one is at least ten times shorter than the last where touches hold the bodies.
LEAST_SHARE = 1e-14  #: Eigenvalues of the normal matrix below this share of the largest are round-off.
FIRST_DAMPING = 1e-9
LOOSE_MM, LOOSE_RAD = 100.0, 0.3
"""Standard deviations from which a body counts as not held: its motion is then not small, and no answer means much."""
RESTS_MM = 1e-8  #: The fit ends at a step that changes no residual by more; the next one would be below round-off.


@dataclass(frozen=True, slots=True, eq=False)
class BodiesFit:
    """The most likely place of a weldment and of its bodies."""

    motions: Motions
    #: shape (6 + 6 b + k, 6 + 6 b + k). Of (ξ, δ_1, …, δ_b): ξ about the origin of the base as in `CalibrationResult`,
    #: δ_b = (ω, v) of body b about its centroid in `part`; then the k amplitudes of bending; rad and mm. Then, of
    #: `modes`, less the unknowns of the robot's own error, which correct no seam, and how they go with the others.
    covariance: FloatArray
    unseen: FloatArray  #: The part of `covariance` that comes from motions which no touch saw.
    whitened: Whitened  #: The linear model at the rigid fit, from which tolerances and evidence are judged.
    modes: ErrorModes | None = None  #: The errors that touches and seams have in common, if they are known.

    @property
    def T_base_part(self) -> RigidTransform:
        """Pose of the whole."""
        return self.motions.T_base_part

    def paired(self, touches: Touches, body: IntArray) -> PointPairs:
        """Pair every touch with the point, in `part`, where it should have been; `body` has the shape (n,)."""
        contact = linearised_each(touches, *touched_poses(touches, body, self.motions)).contact_part
        moved = self.motions.apply(body, contact)
        return PointPairs(touches.names, moved, touches.p_base, touches.covariances, space=touches.space)


def begin_bodies(
    touches: Touches,
    body: IntArray,
    bodies: Bodies,
    start: RigidTransform,
    *,
    sigma_mm: float | None = None,
    contacts: KeptContacts | None = None,
) -> tuple[Problem, BodiesState]:
    """Return the fit of the pose of a weldment and of a small motion of every body, at the rigid fit, for `fit_begun`.

    `body`: shape (n,). The body that each touch lies on; -1 for one that does not move within the part.
    Raises `InputError` when no touch carries an error and none is given, or there is no body; `GeometryError` when the
    touches leave a motion of the whole free.
    """
    if len(bodies) == 0:
        raise InputError("no body may move: name at least one")
    if touches.covariances is None:
        if sigma_mm is None or not 0.0 < sigma_mm < math.inf:
            raise InputError("the bodies' motions need the error of the touches: state it (sigma_mm)")
        touches = replace(touches, covariances=np.tile(sigma_mm**2 * np.eye(3), (len(touches), 1, 1)))
    problem = Problem.of(touches, body, bodies, contacts or KeptContacts.none())
    first = problem.state(Motions.rigid(bodies, start), problem.first)
    _require_held(problem, first)
    problem = on_curved_faces(problem, first)
    return problem, problem.state(first.motions, first.shared)


def fit_begun(problem: Problem, first: BodiesState, modes: ErrorModes | None = None) -> BodiesFit:
    """Fit a problem from its first state; `modes` are errors of readings that touches and seams have in common.

    Raises `GeometryError` when touches and tolerance do not hold a body; `ConvergenceError` when it does not settle.
    """
    found = _settled(problem, first)
    covariance, unseen = problem.covariances(found, modes)
    judged = problem.whitened(first, modes)
    fit = BodiesFit(found.motions, covariance, unseen, judged, modes)
    _require_bodies_held(fit, problem.body)
    return fit


def _settled(problem: Problem, first: BodiesState) -> BodiesState:
    """Return the state of least cost near the first one.

    Gauss-Newton settles in 5 to 8 steps where the touches hold all bodies. Where they leave one almost free, it is
    slow, because it knows nothing of the curvature of the residuals; BFGS, which begins with its matrix, learns it.
    """
    still = RESTS_MM * math.sqrt(float(first.weights.max()))
    found = minimise_squares(problem, first, still=still, most_steps=GAUSS_NEWTON_STEPS, first_damping=FIRST_DAMPING)
    if found.converged:
        return found.state
    at, slope = _polished(problem, found.state, still)
    if slope <= POLISHED:
        return at
    values, vectors = np.linalg.eigh(problem.normal_equations(at)[1])
    root = vectors / np.sqrt(np.maximum(values, LEAST_SHARE * values[-1]))

    def cost_and_slope(z: FloatArray) -> tuple[float, FloatArray]:
        step = root @ z
        state = problem.with_whole(at, step)
        slope, _ = problem.normal_equations(state)
        slope[:3] = left_jacobian(step[None, :3] / problem.length_mm)[0].T @ slope[:3]
        return problem.cost(state) / 2.0, root.T @ slope

    from scipy.optimize import minimize

    best = minimize(
        cost_and_slope, np.zeros(len(root)), jac=True, method="BFGS", options={"gtol": still, "maxiter": MOST_STEPS}
    )
    state = problem.with_whole(at, root @ best.x)
    if float(np.linalg.norm(best.jac)) > SETTLED:
        raise ConvergenceError(
            f"the motions of the bodies did not come to rest in {MOST_STEPS} steps", best=state.motions
        )
    return state


def _polished(problem: Problem, state: BodiesState, still: float) -> tuple[BodiesState, float]:
    """Follow Gauss-Newton below the round-off of the cost, and return the slope there too, in standard deviations.

    The cost of a hundred touches has a round-off of 1e-14, which hides steps of 1e-7 standard deviations.
    """
    gradient, H = problem.normal_equations(state)
    step = _newton_step(gradient, H)
    slope = math.sqrt(abs(float(step @ gradient)))
    for _ in range(POLISHING_STEPS):
        if slope <= still:
            break
        trial = problem.moved(state, step)
        gradient, H = problem.normal_equations(trial)
        step = _newton_step(gradient, H)
        after = math.sqrt(abs(float(step @ gradient)))
        if after >= slope:
            break
        state, slope = trial, after
    return state, slope


def _newton_step(gradient: FloatArray, H: FloatArray) -> FloatArray:
    return np.asarray(-np.linalg.lstsq(H, gradient, rcond=LEAST_SHARE)[0])


def _require_bodies_held(fit: BodiesFit, body: IntArray) -> None:
    """Refuse a body whose place in the base neither its touches nor its tack tolerance tells."""
    motions = fit.motions
    T, bodies = fit.T_base_part, motions.bodies
    for b, tolerance in enumerate(bodies.tolerances):
        if tolerance.mm <= LOOSE_MM and tolerance.mrad <= 1e3 * LOOSE_RAD:
            continue
        J = np.zeros((6, len(fit.covariance)))
        J[:3, :3], J[3:, :6] = np.eye(3), point_jacobian(T.apply(bodies.centroid_part[b] + motions.v_mm[b])[None])[0]
        J[:3, 6 + 6 * b : 9 + 6 * b] = J[3:, 9 + 6 * b : 12 + 6 * b] = T.R
        spread = np.sqrt(np.maximum(np.einsum("ij,jk,ik->i", J, fit.covariance, J), 0.0))
        if (spread[:3] > LOOSE_RAD).any() or (spread[3:] > LOOSE_MM).any():
            raise GeometryError(
                f"body {bodies.names[b]}: {counted(int(np.count_nonzero(body == b)), 'touch')} and a tack tolerance of "
                f"{tolerance.mm:g} mm and {tolerance.mrad:g} mrad do not hold it: touch more of its faces, or state a "
                "smaller tolerance"
            )


def _require_held(problem: Problem, state: BodiesState) -> None:
    """Refuse touches that leave a motion of the whole free: then no motion of a body is known either."""
    _, H = problem.normal_equations(state)
    values = np.linalg.eigvalsh(H[:6, :6])
    if values[0] <= LEAST_HELD * values[-1]:
        raise GeometryError(
            "the touches leave a motion of the whole part free; touch more faces of the bodies that hold it"
        )
