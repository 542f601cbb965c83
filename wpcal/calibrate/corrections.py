r"""Points that a person corrected by hand, explained: the part's place, a preference of the person, or an exception.

A corrected point of a seam says where the real seam is, across its direction, in the robot's own readings:

.. math:: d_i = P_i (J_i \xi + f(x_i) + \sum_b D_{ib} J_i \eta_b) + c_k + e_i,

with the motion ξ of the part, the robot's smooth error f, the motion η of a body that moved (D is the share of it that
the seam follows), a preference c that all seams of a kind share in the axes of the seam, and the error e of the hand.
Everything is Gaussian. A body's motion, a preference and an exception (a point with a large error of its own) are taken
into the explanation one by one, while the probability of all corrections together grows by more than such a thing is
improbable; then those that are not missed are left out again. The amplitude and length of f and the size of e are
weighed by their priors and the same probability.

References: Rasmussen and Williams (2006), Gaussian Processes for Machine Learning, sections 2.7 and 5.4.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.special import logsumexp

from wpcal.calibrate.errors.prediction import COVERAGE, length_quantile
from wpcal.calibrate.errors.robot_field import (
    CLASS_AMPLITUDES_MM,
    CLASS_LENGTHS_MM,
    CLASS_WEIGHTS,
    USUAL_SCALE,
    FieldOrigin,
    RobotField,
    correlation,
)
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.tangent import point_jacobian

USUAL_HAND_MM = 0.2  #: Error of a correction on the pendant per axis, if nothing is stated: a sixth of the wire.
HAND_FACTOR = 1.5  #: Prior of that error: within this factor (68 %).
HAND_NODES = np.array([0.6, 1.0, 1.6])
LEAST_TO_ESTIMATE = 8  #: Corrected points from which their own error is estimated.
END_MM = 1.0  #: Standard deviation of where along its seam a person lets a weld begin or end.
PREFERENCE_MM = 1.0  #: Standard deviation of a preference per axis: about the wire's diameter.
EXCEPTION_MM = 4.0  #: The same of a point that goes round a clamp or a tack.
BODY_MM, BODY_RAD = 2.0, 0.005  #: The same of a body that moved, if no tack tolerance is stated.
LARGEST_FIELD_MM = 1.5  #: A robot that errs by more is not corrected point by point.
LEAST_WEIGHT = 1e-3  #: Nodes with a smaller share are left out.
MOST_EXCEPTIONS = 1 / 3  #: Of more corrected points than this share, nothing is understood by leaving them out.
FAR_MM, FAR_RAD = 50.0, 0.05  #: Before anything is known of the pose.
ALL_KINDS = -1  #: The number of a preference for all seams.
ODDS = {"preference": -1.0, "body": -2.0, "exception": -3.0}
"""Logarithm of the odds of a preference for one kind of seam, of a body that moved, and of a corrected point that is an
exception, before anything is seen."""


@dataclass(frozen=True, slots=True, eq=False)
class SeamPlaces:
    """k places on seams in `base`."""

    p: FloatArray  #: shape (k, 3). mm.
    R: FloatArray  #: shape (k, 3, 3). Axes of the seam: x along it, z out of the joint.
    kind: IntArray  #: shape (k,). Number of the kind of seam.
    bodies: IntArray  #: shape (k, 2). Numbers of the bodies that it joins; -1: none.
    normals: FloatArray  #: shape (k, 2, 3). Out of these bodies at the place; zero where it is not known.

    def __len__(self) -> int:
        return len(self.p)

    def follows(self, body: int) -> FloatArray:
        """Return D, the share of a body's motion that the seam follows across its direction, shape (k, 3, 3)."""
        y, z = self.R[:, :, 1], self.R[:, :, 2]
        flat = np.einsum("kij,kaj->kia", self.normals, np.stack([y, z], axis=1))  # normals in the plane across
        dual = np.einsum("kai,kaj->kij", np.linalg.pinv(flat, rcond=0.2), np.stack([y, z], axis=1))
        own = (self.bodies == body)[:, :, None]
        return np.asarray(np.einsum("kij,kil->kjl", own * dual, self.normals))


class BodyPlaces(SeamPlaces):
    """k places of one body in `base`: they follow it in all directions."""

    @classmethod
    def of(cls, p: FloatArray, body: int) -> BodyPlaces:
        """Take points, shape (k, 3), mm; `body`: its number, -1 for one that no seam joins."""
        none = np.zeros((len(p), 3, 3))
        return cls(p, none, np.full(len(p), -1), np.full((len(p), 2), body), none[:, :2])

    def follows(self, body: int) -> FloatArray:
        """Return all of the motion of their own body, and nothing of another's."""
        return np.asarray((self.bodies[:, :1] == body)[:, :, None] * np.eye(3))


@dataclass(frozen=True, slots=True, eq=False)
class Corrections:
    """n corrected points."""

    at: SeamPlaces  #: Where they were.
    moved: FloatArray  #: shape (n, 3). By how much, mm.
    along: FloatArray  #: shape (n,). Standard deviation along the seam, mm; infinite where it says nothing.


@dataclass(frozen=True, slots=True, eq=False)
class Touched:
    """What the calibration knows: its touches, or where they are not points the covariance of its pose."""

    places: FloatArray  #: shape (k, 3). mm.
    off: FloatArray  #: shape (k, 3). How far the model is from them.
    sigma_mm: float
    pose: FloatArray | None = None  #: shape (6, 6). About the origin of the base.
    tack: Mapping[int, tuple[float, float]] = field(default_factory=dict)  #: By body: mm and rad, of those that moved.


@dataclass(frozen=True, slots=True, eq=False)
class Sizes:
    """Sizes that are weighed."""

    amplitude_mm: float
    length_mm: float
    hand_mm: float
    log_prior: float


@dataclass(frozen=True, slots=True)
class Causes:
    """What an explanation takes into account besides the pose and the robot's error."""

    #: What it is, a key of `ODDS`, and the number of the kind of seam, of the body, or of the row of the corrections.
    taken: frozenset[tuple[str, int]] = frozenset()

    def with_one(self, what: str, number: int) -> Causes:
        """Take one in, or leave it out if it is in."""
        return Causes(self.taken ^ {(what, number)})

    def each(self) -> list[tuple[str, int]]:
        """Return all of them, in one order."""
        return sorted(self.taken)

    def of(self, what: str) -> list[int]:
        """Return the numbers of one sort."""
        return [number for each, number in self.each() if each == what]

    @property
    def log_odds(self) -> float:
        """Of them all, before anything is seen."""
        return sum(ODDS[what] for what, _ in self.taken)


@dataclass(frozen=True, slots=True, eq=False)
class KindOffset:
    """What a person wants on all seams of a kind."""

    mean_mm: FloatArray  #: shape (2,). Along y and z of the seam.
    sigma_mm: FloatArray  #: shape (2,).


class Explanation:
    """The corrections with their causes, and where every seam is according to them."""

    def __init__(
        self, found: Corrections, known: Touched, robot: RobotField, hand_mm: float | None, everywhere: SeamPlaces
    ) -> None:
        self.found, self.known, self.robot = found, known, robot
        self.centre = everywhere.p.mean(axis=0)
        self.middles = {
            body: everywhere.p[(everywhere.bodies == body).any(axis=1)].mean(axis=0)
            for body in sorted(set(everywhere.bodies.ravel().tolist()) - {-1})
        }
        self._rows()
        self._blocks: dict[tuple[str, int], FloatArray] = {}
        self.nodes = list(self._nodes(hand_mm))
        self.causes, self._logs = self._explain()
        self.node = self.nodes[int(np.argmax(self._logs))]

    def _rows(self) -> None:
        """Set out every observation as rows: a direction, a place, a number, and who it is from."""
        n, k = len(self.found.moved), len(self.known.places)
        R, sees = self.found.at.R, np.isfinite(self.found.along)
        across = np.concatenate([R[:, :, 1], R[:, :, 2], R[sees, :, 0]])
        owner = np.concatenate([np.arange(n), np.arange(n), np.flatnonzero(sees)])
        self.owner = np.concatenate([owner, np.full(3 * k, -1)])
        self.axis = np.concatenate([np.repeat([0, 1], n), np.full(int(sees.sum()), 2), np.full(3 * k, -1)])
        self.direction = np.concatenate([across, np.tile(np.eye(3), (k, 1))])
        self.place = np.concatenate([self.found.at.p[owner], np.repeat(self.known.places, 3, axis=0)])
        moved = np.einsum("mi,mi->m", across, self.found.moved[owner])
        self.y = np.concatenate([moved, self.known.off.ravel()])
        self.end = np.concatenate([np.zeros(2 * n), self.found.along[sees], np.zeros(3 * k)])
        self.share = {body: self.found.at.follows(body) for body in self.middles}

    def _nodes(self, hand_mm: float | None) -> Iterator[Sizes]:
        hands, log_hand = (np.array([hand_mm or USUAL_HAND_MM]), np.zeros(1))
        if hand_mm is None and len(self.found.moved) >= LEAST_TO_ESTIMATE:
            hands = USUAL_HAND_MM * HAND_NODES
            log_hand = -0.5 * (np.log(HAND_NODES) / math.log(HAND_FACTOR)) ** 2
        if self.robot.origin in (FieldOrigin.ASSUMED, FieldOrigin.ESTIMATED):
            fields = [
                (a, length, math.log(w))
                for (a, w), length in product(zip(CLASS_AMPLITUDES_MM, CLASS_WEIGHTS, strict=True), CLASS_LENGTHS_MM)
                if a < LARGEST_FIELD_MM
            ]
        else:
            fields = [(self.robot.amplitude_mm, self.robot.length_mm, 0.0)]
        for (a, length, w), (hand, h) in product(fields, zip(hands, log_hand, strict=True)):
            yield Sizes(float(a), float(length), float(hand), w + float(h))

    def _design(self, direction: FloatArray, place: FloatArray, share: Mapping[int, FloatArray]) -> FloatArray:
        """Return what rows see of pose, scale and the bodies in `share`, per standard deviation of each."""
        x = place - self.centre
        J = np.einsum("mi,mij->mj", direction, point_jacobian(x))
        columns = [J * np.repeat([FAR_RAD, FAR_MM], 3), USUAL_SCALE * np.einsum("mi,mi->m", direction, x)[:, None]]
        for body, D in share.items():
            about = point_jacobian(place - self.middles[body])
            mm, rad = self.known.tack.get(body, (BODY_MM, BODY_RAD))
            columns.append(np.einsum("mi,mij,mjk->mk", direction, D, about) * np.repeat([rad, mm], 3))
        return np.concatenate(columns, axis=1)

    def _of_body(self, body: int) -> FloatArray:
        """Return D of a body for every row; touches do not say on which body they are, and follow none."""
        D = np.zeros((len(self.y), 3, 3))
        D[self.owner >= 0] = self.share[body][self.owner[self.owner >= 0]]
        return D

    def _block(self, what: str, number: int) -> FloatArray:
        """Return what the rows see of one cause, per standard deviation."""
        if (what, number) not in self._blocks:
            self._blocks[what, number] = self._made_block(what, number)
        return self._blocks[what, number]

    def _made_block(self, what: str, number: int) -> FloatArray:
        if what == "body":
            return self._design(self.direction, self.place, {number: self._of_body(number)})[:, 7:]
        rows = (self.owner >= 0) & (self.axis < 2)
        if what == "preference":
            if number != ALL_KINDS:
                rows &= np.isin(self.owner, np.flatnonzero(self.found.at.kind == number))
            return PREFERENCE_MM * np.stack([rows & (self.axis == k) for k in (0, 1)], axis=1).astype(np.float64)
        columns = np.flatnonzero(self.owner == number)
        Z = np.zeros((len(self.y), len(columns)))
        Z[columns, np.arange(len(columns))] = EXCEPTION_MM
        return Z

    def _covariance(self, node: Sizes, causes: Causes) -> FloatArray:
        Z = np.concatenate([self._base, *(self._block(*each) for each in causes.each())], axis=1)
        noise = np.where(self.owner >= 0, node.hand_mm, self.known.sigma_mm) ** 2 + self.end**2 + self.robot.rest_mm**2
        smooth = node.amplitude_mm**2 * self._correlations[node.length_mm]
        return np.asarray(Z @ Z.T + smooth + np.diag(noise) + self._of_pose)

    @cached_property
    def _correlations(self) -> dict[float, FloatArray]:
        """Covariance of the rows by the unit field, by its length."""
        x, same = self.place - self.centre, self.direction @ self.direction.T
        lengths = {node.length_mm for node in self.nodes}
        return {length: correlation(x, x, length) * same for length in lengths}

    @cached_property
    def _base(self) -> FloatArray:
        """What rows see of pose and scale; of the pose only where the touches themselves are rows."""
        Z = self._design(self.direction, self.place, {})
        return Z if self.known.pose is None else Z[:, 6:]

    @cached_property
    def _of_pose(self) -> FloatArray | float:
        """Covariance of the rows by a pose that is known to a covariance."""
        if self.known.pose is None:
            return 0.0
        J = np.einsum("mi,mij->mj", self.direction, point_jacobian(self.place))
        return np.asarray(J @ self.known.pose @ J.T)

    def _evidence(self, node: Sizes, causes: Causes) -> float:
        """Log probability of all observations, with the priors."""
        factor = cho_factor(self._covariance(node, causes), lower=True)
        log_det = 2.0 * float(np.log(np.diag(factor[0])).sum())
        return -0.5 * (float(self.y @ cho_solve(factor, self.y)) + log_det) + node.log_prior + causes.log_odds

    def _of_all(self, causes: Causes) -> FloatArray:
        """Log evidence at every node."""
        return np.array([self._evidence(node, causes) for node in self.nodes])

    def _explain(self) -> tuple[Causes, FloatArray]:
        """Take causes in one by one; return them, and the log evidence at every node."""
        causes = Causes(frozenset(self._held))
        logs = self._of_all(causes)
        while True:
            more = (
                dict(self._gains(causes))
                if len(causes.of("exception")) < MOST_EXCEPTIONS * len(self.found.moved)
                else {}
            )
            best = max(more, key=lambda each: float(logsumexp(logs + more[each])), default=None)
            if best is None or logsumexp(logs + more[best]) <= logsumexp(logs):
                break
            causes = causes.with_one(*best)
            logs = self._of_all(causes)
        for each in causes.each():
            without = self._of_all(causes.with_one(*each))
            if each not in self._held and logsumexp(without) > logsumexp(logs):
                causes, logs = causes.with_one(*each), without
        return causes, logs

    @property
    def _held(self) -> set[tuple[str, int]]:
        """Causes that are stated: bodies with a tack tolerance."""
        return {("body", body) for body in self.known.tack}

    def _gains(self, causes: Causes) -> Iterator[tuple[tuple[str, int], FloatArray]]:
        """Yield causes, and by how much the log evidence grows with each at every node (determinant lemma)."""
        inverses = [np.linalg.inv(self._covariance(node, causes)) for node in self.nodes]
        blocks = [("preference", kind) for kind in (ALL_KINDS, *np.unique(self.found.at.kind).tolist())]
        blocks += [("body", body) for body in self.middles if np.any(self.found.at.bodies == body)]
        blocks += [("exception", row) for row in range(len(self.found.moved))]
        for each in blocks:
            if each not in causes.taken:
                Z = self._block(*each)
                yield each, np.array([_gain(np.asarray(inverse), Z, self.y) for inverse in inverses]) + ODDS[each[0]]

    @cached_property
    def _models(self) -> list[tuple[Causes, list[tuple[Sizes, float]]]]:
        """The causes and those with one more or one less, and sizes with their weights: which are true is not known."""
        logs = {self.causes: self._logs}
        for each, gains in self._gains(self.causes):
            logs[self.causes.with_one(*each)] = self._logs + gains
        for each in self.causes.taken - self._held:
            logs[self.causes.with_one(*each)] = self._of_all(self.causes.with_one(*each))
        every = np.array(list(logs.values()))
        weights = np.exp(every - every.max())
        weights[weights < LEAST_WEIGHT] = 0.0
        weights /= weights.sum()
        of = [[(node, w) for node, w in zip(self.nodes, row, strict=True) if w] for row in weights.tolist()]
        return [(causes, own) for causes, own in zip(logs, of, strict=True) if own]

    @cached_property
    def moved_bodies(self) -> tuple[int, ...]:
        """Bodies without whose motion the corrections are less probable."""
        return tuple(
            number
            for what, number in self.causes.each()
            if what == "body"
            and logsumexp(self._of_all(self.causes.with_one(what, number))) + ODDS["body"] < logsumexp(self._logs)
        )

    def seams_at(self, places: SeamPlaces) -> tuple[FloatArray, FloatArray]:
        """Return how far seams are from where the calibration has them, shapes (k, 3), and its covariance (k, 3, 3).

        In the robot's readings: a program that is moved by it leads the wire to the real seam. mm and mm².
        """
        means, covariances = np.zeros((len(places), 3)), np.zeros((len(places), 3, 3))
        for causes, nodes in self._models:
            for weight, mean, covariance in self._given(causes, nodes, places):
                means += weight * mean
                covariances += weight * (covariance + mean[:, :, None] * mean[:, None, :])
        return means, covariances - means[:, :, None] * means[:, None, :]

    def _given(
        self, causes: Causes, nodes: Sequence[tuple[Sizes, float]], places: SeamPlaces
    ) -> Iterator[tuple[float, FloatArray, FloatArray]]:
        """Yield weights of sizes, and where seams are with them: means and covariances."""
        k = len(places)
        direction, at = np.tile(np.eye(3), (k, 1)), np.repeat(places.p, 3, axis=0)
        share = {body: np.repeat(places.follows(body), 3, axis=0) for body in causes.of("body")}
        to = self._design(direction, at, share)
        own = [self._base, *(self._block("body", body) for body in share)]
        other = [self._block(*each) for each in causes.each() if each[0] != "body"]
        rows = np.concatenate([*own, *other], axis=1)
        there = to if self.known.pose is None else to[:, 6:]
        there = np.concatenate([there, np.zeros((3 * k, rows.shape[1] - there.shape[1]))], axis=1)
        x, s = self.place - self.centre, at - self.centre
        for node, weight in nodes:
            crossed = there @ rows.T + node.amplitude_mm**2 * correlation(s, x, node.length_mm) * (
                direction @ self.direction.T
            )
            prior = there.reshape(k, 3, -1) @ there.reshape(k, 3, -1).transpose(0, 2, 1)
            prior = prior + (node.amplitude_mm**2 + self.robot.rest_mm**2) * np.eye(3)
            if self.known.pose is not None:
                J, row = point_jacobian(places.p), np.einsum("mi,mij->mj", self.direction, point_jacobian(self.place))
                crossed += J.reshape(-1, 6) @ self.known.pose @ row.T
                prior = prior + J @ self.known.pose @ J.transpose(0, 2, 1)
            factor = cho_factor(self._covariance(node, causes), lower=True)
            mean = (crossed @ cho_solve(factor, self.y)).reshape(k, 3)
            seen = crossed.reshape(k, 3, -1) @ cho_solve(factor, crossed.T).T.reshape(k, 3, -1).transpose(0, 2, 1)
            yield weight, mean, prior - seen

    def errors_95_mm(self, covariances: FloatArray) -> FloatArray:
        """Length that errors stay below with 95 % probability, shape (k,), mm."""
        return length_quantile(covariances, COVERAGE)

    def preference(self, kind: int) -> KindOffset:
        """Return the preference for a kind of seam, with its uncertainty."""
        Z = self._block("preference", kind)
        inverse = np.linalg.inv(self._covariance(self.node, self.causes))
        mean = PREFERENCE_MM * Z.T @ inverse @ self.y
        C = PREFERENCE_MM**2 * (np.eye(2) - Z.T @ inverse @ Z)
        return KindOffset(mean, np.sqrt(np.diag(C)))


def _gain(inverse: FloatArray, Z: FloatArray, y: FloatArray) -> float:
    """By how much the log evidence grows when Z Zᵀ is added to a covariance with this inverse."""
    seen = np.flatnonzero(Z.any(axis=1))
    inner, b = Z[seen].T @ inverse[np.ix_(seen, seen)] @ Z[seen], Z[seen].T @ (inverse[seen] @ y)
    M = np.eye(Z.shape[1]) + inner
    return 0.5 * float(b @ np.linalg.solve(M, b) - np.linalg.slogdet(M)[1])
