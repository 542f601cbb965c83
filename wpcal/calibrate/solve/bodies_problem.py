"""The sum of squares of a weldment's touches, as a function of its pose and of the motions of its bodies."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from wpcal.calibrate.errors.modes import ErrorModes
from wpcal.calibrate.errors.robot_field import ResidualRows
from wpcal.calibrate.observe.bodies import Bodies, KeptContacts
from wpcal.calibrate.observe.motions import Motions, left_jacobian
from wpcal.calibrate.observe.touches import Linearised, Touches
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.tangent import exp_rotation, log_rotation, point_jacobian, translation_adjoint
from wpcal.core.transform import RigidTransform

LEAST_HELD = 1e-9  #: A direction whose information is below this share of the largest is not seen.
FREE = 100.0  #: Times its tolerance: such a body is held by its touches alone.


@dataclass(frozen=True, slots=True, eq=False)
class Whitened:
    """Touches as a linear model with unit errors: r = J ξ + B u + e, at the rigid fit."""

    r: FloatArray  #: shape (m,).
    J: FloatArray  #: shape (m, 6 + s). By the scaled motion of the whole, and by errors that all touches share.
    #: shape (m, 6 b + bends + modes). By the motions of the bodies, in units of their tolerances, by the amplitudes of
    #: bending, and by the robot's own error.
    B: FloatArray
    touch: IntArray  #: shape (m,). The touch of each row; -1: a kept contact.
    bends: int  #: How many amplitudes there are.
    modes: int = 0  #: How many unknowns the robot's own error has.

    def without_contacts(self) -> Whitened:
        """Return what was measured: a contact is an assumption, and says nothing of how far bodies moved."""
        return self.select(self.touch >= 0)

    def select(self, rows: BoolArray) -> Whitened:
        """Return the model of some rows: a mask of shape (m,)."""
        return replace(self, r=self.r[rows], J=self.J[rows], B=self.B[rows], touch=self.touch[rows])

    def with_free(self, body: int) -> Whitened:
        """Return the model in which one body may move `FREE` times as far as its tolerance says."""
        B = self.B.copy()
        B[:, 6 * body : 6 * body + 6] *= FREE
        return replace(self, B=B)

    def error_rows(self, places: FloatArray) -> ResidualRows:
        """Return what touches show of the robot's error, where motions of bodies are errors, too.

        `places`: shape (n, 3). Of the touches, mm.
        """
        from scipy.linalg import null_space

        about = places - places.mean(axis=0)
        Q = null_space(self.J.T)
        L = np.linalg.cholesky(np.eye(Q.shape[1]) + (Q.T @ self.B) @ (self.B.T @ Q))
        rest, root, owner = np.linalg.solve(L, Q.T).T, self.J[:, 3:6], self.touch
        z = rest.T @ np.einsum("mi,mi->m", root, about[owner])
        return ResidualRows(about, owner, root, rest, rest.T @ self.r, z, float(np.mean(np.sum(root**2, axis=1))))

    def residual_matrix(self) -> FloatArray:
        """Return P with rᵀ P r the sum of squares that pose and motions leave, shape (m, m)."""
        W = np.linalg.inv(np.eye(len(self.r)) + self.B @ self.B.T)
        WJ = W @ self.J
        return np.asarray(W - WJ @ np.linalg.pinv(self.J.T @ WJ, hermitian=True) @ WJ.T)


@dataclass(frozen=True, slots=True, eq=False)
class BodiesState:
    """Motions with the residuals there."""

    motions: Motions
    at: Linearised  #: In `base`; `contact_part` in the model's coordinates of the own body.
    weights: FloatArray  #: shape (n, 3, 3).
    gaps: FloatArray  #: shape (k,). Of the kept contacts, in units of their sigma.
    shared: FloatArray  #: shape (s,). The errors that all touches share, in standard deviations.


@dataclass(frozen=True, slots=True, eq=False)
class Problem:
    """The sum of squares as a `SquaresProblem` of states.

    Unknowns are (L ω, v) of the whole, u of the bodies, and the errors that all touches share.
    """

    touches: Touches
    own: FloatArray  #: shape (n, 3, 3). Covariances of the touches without the errors that they share.
    shared: FloatArray  #: shape (n, 3, s).
    body: IntArray
    bodies: Bodies
    contacts: KeptContacts
    scales: FloatArray  #: shape (6 b + k,). `Bodies.all_scales`.
    pivot: FloatArray
    length_mm: float

    @classmethod
    def of(cls, touches: Touches, body: IntArray, bodies: Bodies, contacts: KeptContacts) -> Problem:
        """Build it for n touches; `body` has the shape (n,)."""
        pivot = touches.p_base.mean(axis=0)
        reach = float(np.linalg.norm(touches.p_base - pivot, axis=1).max())
        shared = np.zeros((len(touches), 3, 0)) if touches.shared is None else touches.shared
        assert touches.covariances is not None  # of `begin_bodies`
        own = touches.covariances - shared @ shared.transpose(0, 2, 1)
        return cls(touches, own, shared, body, bodies, contacts, bodies.all_scales, pivot, max(reach, 1.0))

    @property
    def first(self) -> FloatArray:
        """No shared error, shape (s,)."""
        return np.zeros(self.shared.shape[2])

    def state(self, motions: Motions, shared: FloatArray) -> BodiesState:
        """Return a state with its residuals; `shared` has the shape (s,)."""
        touched = replace(self.touches, p_base=self.touches.p_base - self.shared @ shared)
        at = linearised_each(touched, *touched_poses(touched, self.body, motions))
        return BodiesState(motions, at, at.information(self.own), self._gaps(motions), shared)

    def cost(self, state: BodiesState) -> float:
        """Return the sum of squares."""
        d = state.at.d
        u = self._scaled(state.motions)
        touched = float(np.einsum("ni,nij,nj->", d, state.weights, d))
        return touched + float(np.sum(u**2)) + float(np.sum(state.gaps**2)) + float(np.sum(state.shared**2))

    def normal_equations(self, state: BodiesState) -> tuple[FloatArray, FloatArray]:
        """Return the gradient and the normal matrix, shapes (k,) and (k, k)."""
        J = self.jacobian(state)
        WJ = (state.weights @ J).reshape(-1, J.shape[2])
        gradient = WJ.T @ state.at.d.ravel()
        H = J.reshape(WJ.shape).T @ WJ
        G, known = self._contact_jacobian(state.motions), len(H) - 6
        gradient[6:] += np.concatenate([self._scaled(state.motions) + G.T @ state.gaps, state.shared])
        H[6:, 6:] += np.eye(known)
        H[self.of_bodies, self.of_bodies] += G.T @ G
        return gradient, H

    @property
    def of_bodies(self) -> slice:
        """Where the unknowns of the bodies are: their motions, then the amplitudes of bending."""
        return slice(6, 6 + 6 * len(self.bodies) + len(self.bodies.bends))

    def _by_bodies(self, step: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Return what a step changes in the motions, shape (b, 6), and in the amplitudes of bending, shape (k,)."""
        by, b = step[self.of_bodies] * self.scales, 6 * len(self.bodies)
        return by[:b].reshape(-1, 6), by[b:]

    def moved(self, state: BodiesState, step: FloatArray) -> BodiesState:
        """Move the whole and its bodies by a step of shape (k,).

        Bodies go with the whole, or each keeps the place in the base it steps to. Both are the same to first order.
        Where tolerances are small against the errors of the touches, the first follows the valley of the cost,
        otherwise the second: the lower one is taken.
        """
        return min((self.with_whole(state, step), self.in_place(state, step)), key=self.cost)

    def with_whole(self, state: BodiesState, step: FloatArray) -> BodiesState:
        """Move the bodies within the part by a step of shape (k,)."""
        motions, (by, bent) = state.motions, self._by_bodies(step)
        whole = self._whole(motions.T_base_part, step)
        omega, v = motions.omega + by[:, :3], motions.v_mm + by[:, 3:]
        moved = Motions(self.bodies, whole, omega, v, motions.bend_mm + bent)
        return self.state(moved, state.shared + step[self.of_bodies.stop :])

    def in_place(self, state: BodiesState, step: FloatArray) -> BodiesState:
        """Move the bodies within the base by a step of shape (k,)."""
        motions, (by, bent) = state.motions, self._by_bodies(step)
        T, c = motions.T_base_part, self.bodies.centroid_part
        whole = self._whole(T, step)
        turn = step[:3] / self.length_mm
        centre = T.apply(c + motions.v_mm)
        centre += np.cross(turn, centre - self.pivot) + step[3:6] + by[:, 3:] @ T.R.T
        own_turn = np.einsum("bij,bj->bi", left_jacobian(motions.omega), by[:, :3]) @ T.R.T + turn
        omega = log_rotation(whole.R.T @ exp_rotation(own_turn) @ motions.poses()[0])
        moved = Motions(self.bodies, whole, omega, (centre - whole.t_mm) @ whole.R - c, motions.bend_mm + bent)
        return self.state(moved, state.shared + step[self.of_bodies.stop :])

    def _whole(self, T: RigidTransform, step: FloatArray) -> RigidTransform:
        turn = exp_rotation(step[:3] / self.length_mm)
        t = turn @ (T.t_mm - self.pivot) + self.pivot + step[3:6]
        return RigidTransform(turn @ T.R, t, target=T.target, source=T.source)

    def jacobian(self, state: BodiesState) -> FloatArray:
        """Derivative of the residuals by the unknowns, shape (n, 3, 6 + 6 b + k + s)."""
        return np.asarray(-state.at.A @ self.material_jacobian(state))

    def material_jacobian(self, state: BodiesState) -> FloatArray:
        """Derivative of the touched places of the bodies, in `base`, by the unknowns, shape (n, 3, 6 + 6 b + k + s)."""
        at, T = state.at, state.motions.T_base_part
        whole = point_jacobian(at.centre - self.pivot) / np.repeat([self.length_mm, 1.0], 3)
        by_bodies = T.R @ (state.motions.jacobian(self.body, at.contact_part) * self.scales)
        return np.concatenate([whole, by_bodies, self.shared], axis=2)

    def covariances(self, state: BodiesState, modes: ErrorModes | None) -> tuple[FloatArray, FloatArray]:
        """Return the covariance of (ξ, δ, -z) and its unseen part: see `BodiesFit`.

        Readings that are off by F z + r move the unknowns by G (F z + r) with the gain G of this fit.
        """
        _, H = self.normal_equations(state)
        known, q = self.of_bodies.stop, 0 if modes is None else len(modes)
        inverse = np.asarray(np.linalg.inv(H)[:known], dtype=np.float64)
        bodies_part, own = inverse[:, 6:known], inverse[:, :known]
        S, found, unseen = np.eye(known + q), own, np.zeros((known + q, known + q))
        unseen[:known, :known] = bodies_part @ bodies_part.T
        if modes is not None:
            gain: FloatArray = np.asarray(
                -inverse @ self.jacobian(state).transpose(0, 2, 1) @ state.weights, dtype=np.float64
            )
            found = modes.with_unknowns(own, gain, self.touches.p_base)
        S[:6, :6] = translation_adjoint(self.pivot) / np.repeat([self.length_mm, 1.0], 3)
        S[6:known, 6:known] = np.diag(self.scales)
        return S @ found @ S.T, S @ unseen @ S.T

    def whitened(self, state: BodiesState, modes: ErrorModes | None = None) -> Whitened:
        """Return the linear model at a state; contacts count as touches of a gap of zero.

        Errors that all touches share join the pose: the touches are judged without what such an error explains. Those
        of `modes` are errors of the touches, with what they have in common.
        """
        q, weights, n = 0 if modes is None else len(modes), state.weights, len(self.touches)
        by_robot = np.zeros((n, 3, 0))
        if modes is not None:
            weights = state.at.information(self.own + modes.rest_of(self.touches.p_base)[:, None, None] * np.eye(3))
            by_robot = -state.at.A @ modes.at(self.touches.p_base)
        values, vectors = np.linalg.eigh(weights)
        roots = np.sqrt(np.maximum(values, 0.0))[..., None] * vectors.transpose(0, 2, 1)
        is_seen = (roots**2).sum(axis=2).ravel() > LEAST_HELD * float(values.max())
        J = (roots @ self.jacobian(state)).reshape(3 * n, -1)[is_seen]
        r = (roots @ state.at.d[..., None]).ravel()[is_seen]
        G = self._contact_jacobian(state.motions)
        common = np.delete(J, np.arange(6, self.of_bodies.stop), axis=1)
        first = np.concatenate([common, np.zeros((len(G), common.shape[1]))])
        touch = np.concatenate([np.repeat(np.arange(n), 3)[is_seen], np.full(len(G), -1)])
        bodies = np.concatenate([J[:, self.of_bodies], G])
        robot = np.concatenate([(roots @ by_robot).reshape(3 * n, q)[is_seen], np.zeros((len(G), q))])
        known = np.concatenate([bodies, robot], axis=1)
        return Whitened(-np.concatenate([r, state.gaps]), first, known, touch, len(self.bodies.bends), q)

    def _scaled(self, motions: Motions) -> FloatArray:
        """Return u, shape (6 b + k,)."""
        own = np.concatenate([motions.omega, motions.v_mm], axis=1).ravel()
        return np.concatenate([own, motions.bend_mm]) / self.scales

    def _gaps(self, motions: Motions) -> FloatArray:
        c = self.contacts
        if len(c) == 0:
            return np.zeros(0)
        apart = motions.apply(c.first, c.p_part) - motions.apply(c.second, c.p_part)
        return np.asarray(np.einsum("ki,ki->k", apart, c.normal_part) / c.sigma_mm)

    def _contact_jacobian(self, motions: Motions) -> FloatArray:
        """Derivative of the gaps by u, shape (contacts, 6 b + k)."""
        c = self.contacts
        if len(c) == 0:
            return np.zeros((0, len(self.scales)))
        apart = motions.jacobian(c.first, c.p_part) - motions.jacobian(c.second, c.p_part)
        by = np.einsum("ki,kij->kj", c.normal_part, apart) / c.sigma_mm[:, None]
        return np.asarray(by * self.scales)


def touched_poses(touches: Touches, body: IntArray, motions: Motions) -> tuple[FloatArray, FloatArray]:
    """Return from the model to the base at every touch: of its body, or of the cross-section of one that bends.

    `body`: shape (n,).
    Returns tuple of ndarray, shapes (n, 3, 3) and (n, 3).
    """
    if len(motions.bodies.bends) == 0:
        return motions.poses_of(body)
    T = motions.T_base_part
    R, t = motions.moves_at(body, motions.material(body, T.inverse().apply(touches.p_base)))
    return T.R @ R, T.apply(t)


def linearised_each(touches: Touches, R: FloatArray, t: FloatArray) -> Linearised:
    """Return residuals where the target of every touch has a pose of its own; R, t of shapes (n, 3, 3), (n, 3)."""
    x = np.einsum("nij,ni->nj", R, touches.p_base - t)
    near = touches.targets.nearest(touches.rows, x)
    contact = near.p + touches.radius_mm[:, None] * near.normal
    d = np.einsum("nij,nj->ni", near.projector, x - contact)
    A = R @ near.projector @ R.transpose(0, 2, 1)
    return Linearised(contact, np.einsum("nij,nj->ni", R, d), A, np.einsum("nij,nj->ni", R, contact) + t)
