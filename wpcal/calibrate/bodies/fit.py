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
from scipy.optimize import minimize

from wpcal.calibrate.bodies.bodies import Bodies, Contacts
from wpcal.calibrate.bodies.motions import Motions, left_jacobian
from wpcal.calibrate.touches.touches import Linearised, Touches
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import ConvergenceError, GeometryError, InputError
from wpcal.core.pairs import PointPairs
from wpcal.core.tangent import exp_rotation, log_rotation, point_jacobian, translation_adjoint
from wpcal.core.transform import RigidTransform
from wpcal.optim.levenberg_marquardt import minimise_squares

GAUSS_NEWTON_STEPS = 40
MOST_STEPS = 400
"""Of BFGS."""
SETTLED = 1e-4
"""The slope of the cost, in standard deviations of the answer, at which the fit counts as settled."""
LEAST_SHARE = 1e-14
"""Eigenvalues of the normal matrix below this share of the largest are round-off."""
FIRST_DAMPING = 1e-9
RESTS_MM = 1e-8
"""The fit ends at a step that changes no residual by more; the next one would be below round-off."""
LEAST_HELD = 1e-9
"""A motion of the whole whose information is below this share of the largest is free."""


@dataclass(frozen=True, slots=True, eq=False)
class BodiesFit:
    """The most likely place of a weldment and of its bodies.

    Parameters
    ----------
    motions : Motions
    residuals_mm : ndarray, shape (n,)
        Distances of the touches from the moved bodies.
    covariance : ndarray, shape (6 + 6 b, 6 + 6 b)
        Of (ξ, δ_1, …, δ_b): ξ about the origin of the base as in `CalibrationResult`, δ_b = (ω, v) of body b about its
        centroid in `part`; rad and mm.
    unseen : ndarray, shape (6 + 6 b, 6 + 6 b)
        The part of `covariance` that comes from motions which no touch saw.
    whitened : Whitened
        The linear model at the rigid fit, from which tolerances and evidence are judged.
    """

    motions: Motions
    residuals_mm: FloatArray
    covariance: FloatArray
    unseen: FloatArray
    whitened: Whitened

    @property
    def T_base_part(self) -> RigidTransform:
        """Pose of the whole."""
        return self.motions.T_base_part

    def paired(self, touches: Touches, body: IntArray) -> PointPairs:
        """Pair every touch with the point, in `part`, where it should have been; `body` has the shape (n,)."""
        R, t = self.motions.poses_of(body)
        contact = linearised_each(touches, R, t).contact_part
        moved = self.motions.apply(body, contact)
        return PointPairs(touches.names, moved, touches.p_base, touches.covariances, space=touches.space)

    def body_covariance(self, body: int) -> FloatArray:
        """Covariance of the motion (ω, v) of one body, shape (6, 6)."""
        own = slice(6 + 6 * body, 12 + 6 * body)
        return self.covariance[own, own]


@dataclass(frozen=True, slots=True, eq=False)
class Whitened:
    """Touches as a linear model with unit errors: r = J ξ + B u + e, at the rigid fit.

    Parameters
    ----------
    r : ndarray, shape (m,)
    J : ndarray, shape (m, 6 + s)
        By the scaled motion of the whole, and by errors that all touches share.
    B : ndarray, shape (m, 6 b)
        By the motions of the bodies, in units of their tolerances.
    touch : ndarray of int, shape (m,)
        The touch of each row; -1: a kept contact.
    """

    r: FloatArray
    J: FloatArray
    B: FloatArray
    touch: IntArray


def fit_bodies(
    touches: Touches,
    body: IntArray,
    bodies: Bodies,
    start: RigidTransform,
    *,
    sigma_mm: float | None = None,
    contacts: Contacts | None = None,
) -> BodiesFit:
    """Fit the pose of a weldment and a small motion of every body.

    Parameters
    ----------
    touches : Touches
        n of them.
    body : ndarray of int, shape (n,)
        The body that each touch lies on; -1 for one that does not move within the part.
    bodies : Bodies
        b bodies and their tack tolerances.
    start : RigidTransform
        ``T_base_part`` of the rigid fit.
    sigma_mm : float, optional
        Teaching error per axis; needed where the touches carry no covariances.
    contacts : Contacts, optional

    Returns
    -------
    BodiesFit

    Raises
    ------
    InputError
        When no touch carries an error and none is given, or there is no body.
    GeometryError
        When the touches leave a motion of the whole free.
    ConvergenceError
        When the fit does not come to rest.
    """
    if len(bodies) == 0:
        raise InputError("no body may move: name at least one")
    if touches.covariances is None:
        if sigma_mm is None or not 0.0 < sigma_mm < math.inf:
            raise InputError("the bodies' motions need the error of the touches: state it (sigma_mm)")
        touches = replace(touches, covariances=np.tile(sigma_mm**2 * np.eye(3), (len(touches), 1, 1)))
    problem = _Problem.of(touches, body, bodies, contacts or Contacts.none(), start)
    first = problem.state(Motions.rigid(bodies, start), problem.first)
    _require_held(problem, first)
    found = _settled(problem, first)
    covariance, unseen = problem.covariances(found)
    return BodiesFit(found.motions, found.at.distances, covariance, unseen, problem.whitened(first))


@dataclass(frozen=True, slots=True, eq=False)
class _State:
    """Motions with the residuals there.

    Parameters
    ----------
    at : Linearised
        In `base`; `contact_part` in the model's coordinates of the own body.
    weights : ndarray, shape (n, 3, 3)
    gaps : ndarray, shape (k,)
        Of the kept contacts, in units of their sigma.
    shared : ndarray, shape (s,)
        The errors that all touches share, in standard deviations.
    """

    motions: Motions
    at: Linearised
    weights: FloatArray
    gaps: FloatArray
    shared: FloatArray


@dataclass(frozen=True, slots=True, eq=False)
class _Problem:
    """The sum of squares as a `SquaresProblem` of states.

    Unknowns are (L ω, v) of the whole, u of the bodies, and the errors that all touches share.

    Parameters
    ----------
    own : ndarray, shape (n, 3, 3)
        Covariances of the touches without the errors that they share.
    shared : ndarray, shape (n, 3, s)
    """

    touches: Touches
    own: FloatArray
    shared: FloatArray
    body: IntArray
    bodies: Bodies
    contacts: Contacts
    pivot: FloatArray
    length_mm: float

    @classmethod
    def of(
        cls, touches: Touches, body: IntArray, bodies: Bodies, contacts: Contacts, start: RigidTransform
    ) -> _Problem:
        pivot = touches.p_base.mean(axis=0)
        reach = float(np.linalg.norm(touches.p_base - pivot, axis=1).max())
        shared = np.zeros((len(touches), 3, 0)) if touches.shared is None else touches.shared
        assert touches.covariances is not None  # of `fit_bodies`
        own = touches.covariances - shared @ shared.transpose(0, 2, 1)
        return cls(touches, own, shared, body, bodies, contacts, pivot, max(reach, 1.0))

    @property
    def first(self) -> FloatArray:
        """No shared error, shape (s,)."""
        return np.zeros(self.shared.shape[2])

    def state(self, motions: Motions, shared: FloatArray) -> _State:
        touched = replace(self.touches, p_base=self.touches.p_base - self.shared @ shared)
        at = linearised_each(touched, *motions.poses_of(self.body))
        return _State(motions, at, at.information(self.own), self._gaps(motions), shared)

    def cost(self, state: _State) -> float:
        d = state.at.d
        u = self._scaled(state.motions)
        touched = float(np.einsum("ni,nij,nj->", d, state.weights, d))
        return touched + float(np.sum(u**2)) + float(np.sum(state.gaps**2)) + float(np.sum(state.shared**2))

    def normal_equations(self, state: _State) -> tuple[FloatArray, FloatArray]:
        J = self.jacobian(state)
        WJ = np.einsum("nij,njk->nik", state.weights, J)
        gradient = np.einsum("nik,ni->k", WJ, state.at.d)
        H = np.einsum("nik,nil->kl", J, WJ)
        G, known = self._contact_jacobian(state.motions), len(H) - 6
        gradient[6:] += np.concatenate([self._scaled(state.motions).ravel() + G.T @ state.gaps, state.shared])
        H[6:, 6:] += np.eye(known)
        H[self.of_bodies, self.of_bodies] += G.T @ G
        return gradient, H

    @property
    def of_bodies(self) -> slice:
        """Where the unknowns of the bodies are."""
        return slice(6, 6 + 6 * len(self.bodies))

    def moved(self, state: _State, step: FloatArray) -> _State:
        """Move the whole and its bodies. Bodies go with the whole, or each keeps the place in the base it steps to.

        Both are the same to first order. Where tolerances are small against the errors of the touches, the first
        follows the valley of the cost, otherwise the second: the lower one is taken.
        """
        return min((self.with_whole(state, step), self.in_place(state, step)), key=self.cost)

    def with_whole(self, state: _State, step: FloatArray) -> _State:
        """Move the bodies within the part."""
        motions, by = state.motions, step[self.of_bodies].reshape(-1, 6) * self.bodies.scales
        whole = self._whole(motions.T_base_part, step)
        moved = Motions(self.bodies, whole, motions.omega + by[:, :3], motions.v_mm + by[:, 3:])
        return self.state(moved, state.shared + step[self.of_bodies.stop :])

    def in_place(self, state: _State, step: FloatArray) -> _State:
        """Move the bodies within the base."""
        motions, by = state.motions, step[self.of_bodies].reshape(-1, 6) * self.bodies.scales
        T, c = motions.T_base_part, self.bodies.centroid_part
        whole = self._whole(T, step)
        turn = step[:3] / self.length_mm
        centre = T.apply(c + motions.v_mm)
        centre += np.cross(turn, centre - self.pivot) + step[3:6] + by[:, 3:] @ T.R.T
        own_turn = np.einsum("bij,bj->bi", left_jacobian(motions.omega), by[:, :3]) @ T.R.T + turn
        omega = log_rotation(whole.R.T @ exp_rotation(own_turn) @ motions.poses()[0])
        moved = Motions(self.bodies, whole, omega, (centre - whole.t_mm) @ whole.R - c)
        return self.state(moved, state.shared + step[self.of_bodies.stop :])

    def _whole(self, T: RigidTransform, step: FloatArray) -> RigidTransform:
        turn = exp_rotation(step[:3] / self.length_mm)
        t = turn @ (T.t_mm - self.pivot) + self.pivot + step[3:6]
        return RigidTransform(turn @ T.R, t, target=T.target, source=T.source)

    def jacobian(self, state: _State) -> FloatArray:
        """Derivative of the residuals by the unknowns, shape (n, 3, 6 + 6 b + s)."""
        n, b = len(self.touches), len(self.bodies)
        at, T = state.at, state.motions.T_base_part
        J = np.zeros((n, 3, 6 + 6 * b + self.shared.shape[2]))
        J[:, :, :6] = -at.A @ point_jacobian(at.centre - self.pivot) / np.repeat([self.length_mm, 1.0], 3)
        rows = np.flatnonzero(self.body >= 0)
        own = self.body[rows]
        by_body = state.motions.displacement_jacobian(own, at.contact_part[rows]) * self.bodies.scales[own][:, None, :]
        blocks = np.zeros((n, 3, b, 6))
        blocks[rows, :, own] = -at.A[rows] @ (T.R @ by_body)
        J[:, :, self.of_bodies] = blocks.reshape(n, 3, 6 * b)
        J[:, :, self.of_bodies.stop :] = -at.A @ self.shared
        return J

    def covariances(self, state: _State) -> tuple[FloatArray, FloatArray]:
        """Return the covariance of (ξ, δ) and its unseen part: see `BodiesFit`."""
        _, H = self.normal_equations(state)
        kept = self.of_bodies.stop
        inverse = np.linalg.inv(H)[:kept, :kept]
        bodies_part = inverse[:, 6:]
        S = np.zeros((kept, kept))
        S[:6, :6] = translation_adjoint(self.pivot) / np.repeat([self.length_mm, 1.0], 3)
        S[6:, 6:] = np.diag(self.bodies.scales.ravel())
        return S @ inverse @ S.T, S @ bodies_part @ bodies_part.T @ S.T

    def whitened(self, state: _State) -> Whitened:
        """Return the linear model at a state; contacts count as touches of a gap of zero.

        Errors that all touches share join the pose: the touches are judged without what such an error explains.
        """
        values, vectors = np.linalg.eigh(state.weights)
        roots = np.sqrt(np.maximum(values, 0.0))[..., None] * vectors.transpose(0, 2, 1)
        by_all = self.jacobian(state)
        J = (roots @ by_all).reshape(-1, by_all.shape[2])
        r = (roots @ state.at.d[..., None]).ravel()
        is_seen = (roots**2).sum(axis=2).ravel() > LEAST_HELD * float(values.max())
        G = self._contact_jacobian(state.motions)
        common = np.delete(J[is_seen], self.of_bodies, axis=1)
        first = np.concatenate([common, np.zeros((len(G), common.shape[1]))])
        touch = np.concatenate([np.repeat(np.arange(len(self.touches)), 3)[is_seen], np.full(len(G), -1)])
        bodies = np.concatenate([J[is_seen, self.of_bodies], G])
        return Whitened(-np.concatenate([r[is_seen], state.gaps]), first, bodies, touch)

    def _scaled(self, motions: Motions) -> FloatArray:
        return np.concatenate([motions.omega, motions.v_mm], axis=1) / self.bodies.scales

    def _gaps(self, motions: Motions) -> FloatArray:
        c = self.contacts
        apart = motions.apply(c.first, c.p_part) - motions.apply(c.second, c.p_part)
        return np.asarray(np.einsum("ki,ki->k", apart, c.normal_part) / c.sigma_mm)

    def _contact_jacobian(self, motions: Motions) -> FloatArray:
        """Derivative of the gaps by u, shape (k, 6 b)."""
        c, b = self.contacts, len(self.bodies)
        G = np.zeros((len(c), b, 6))
        for own, sign in ((c.first, 1.0), (c.second, -1.0)):
            rows = np.flatnonzero(own >= 0)
            by = motions.displacement_jacobian(own[rows], c.p_part[rows]) * self.bodies.scales[own[rows]][:, None, :]
            each = np.einsum("ki,kij->kj", c.normal_part[rows], by) / c.sigma_mm[rows, None]
            G[rows, own[rows]] += sign * each
        return G.reshape(len(c), 6 * b)


def _settled(problem: _Problem, first: _State) -> _State:
    """Return the state of least cost near the first one.

    Gauss-Newton settles in 5 to 8 steps where the touches hold all bodies. Where they leave one almost free, it is
    slow, because it knows nothing of the curvature of the residuals; BFGS, which begins with its matrix, learns it.
    """
    still = RESTS_MM * math.sqrt(float(first.weights.max()))
    found = minimise_squares(problem, first, still=still, most_steps=GAUSS_NEWTON_STEPS, first_damping=FIRST_DAMPING)
    if found.converged:
        return found.state
    at = found.state
    values, vectors = np.linalg.eigh(problem.normal_equations(at)[1])
    root = vectors / np.sqrt(np.maximum(values, LEAST_SHARE * values[-1]))

    def cost_and_slope(z: FloatArray) -> tuple[float, FloatArray]:
        step = root @ z
        state = problem.with_whole(at, step)
        slope, _ = problem.normal_equations(state)
        slope[:3] = left_jacobian(step[None, :3] / problem.length_mm)[0].T @ slope[:3]
        return problem.cost(state) / 2.0, root.T @ slope

    best = minimize(
        cost_and_slope, np.zeros(len(root)), jac=True, method="BFGS", options={"gtol": still, "maxiter": MOST_STEPS}
    )
    state = problem.with_whole(at, root @ best.x)
    if float(np.linalg.norm(best.jac)) > SETTLED:
        raise ConvergenceError(
            f"the motions of the bodies did not come to rest in {MOST_STEPS} steps", best=state.motions
        )
    return state


def linearised_each(touches: Touches, R: FloatArray, t: FloatArray) -> Linearised:
    """Return residuals where the target of every touch has a pose of its own; R, t of shapes (n, 3, 3), (n, 3)."""
    x = np.einsum("nij,ni->nj", R, touches.p_base - t)
    near = touches.targets.nearest(touches.rows, x)
    contact = near.p + touches.radius_mm[:, None] * near.normal
    d = np.einsum("nij,nj->ni", near.projector, x - contact)
    A = R @ near.projector @ R.transpose(0, 2, 1)
    return Linearised(contact, np.einsum("nij,nj->ni", R, d), A, np.einsum("nij,nj->ni", R, contact) + t)


def _require_held(problem: _Problem, state: _State) -> None:
    """Refuse touches that leave a motion of the whole free: then no motion of a body is known either."""
    _, H = problem.normal_equations(state)
    values = np.linalg.eigvalsh(H[:6, :6])
    if values[0] <= LEAST_HELD * values[-1]:
        raise GeometryError(
            "the touches leave a motion of the whole part free; touch more faces of the bodies that hold it"
        )
