r"""The linear model of a weldment whose bodies may move, before it is touched.

The unknowns are (L ω, v) of the whole about a centre, the motion of every body in units of its tack tolerance, and
errors that all touches share, in standard deviations. A touch with the row h, in units of its error, adds
:math:`h h^\top` to the information :math:`M`, which begins with the tolerances and the kept contacts. Seam points with
the rows J are then off by :math:`J M^{-1} J^\top`, as after the fit of `wpcal.calibrate.solve.bodies`.

With the covariance C of the unknowns, a further touch with the rows H (unit errors) leaves

.. math:: C' = C - C H^\top (I + H C H^\top)^{-1} H C,

so the error of every seam point after every possible touch comes from two products of matrices. Touches are added one
by one, each time the one after which the errors are least, and then exchanged one by one until no exchange helps.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from wpcal.calibrate.errors.modes import ErrorModes
from wpcal.calibrate.errors.of_bodies import MeetingPoints, joint_error, meeting_jacobian
from wpcal.calibrate.errors.prediction import COVERAGE, TeachingError, length_quantile
from wpcal.calibrate.errors.robot_field import foresee
from wpcal.calibrate.observe.bodies import Bodies, KeptContacts
from wpcal.calibrate.observe.motions import Motions
from wpcal.calibrate.solve.bodies_problem import Whitened
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.tangent import point_jacobian
from wpcal.core.transform import RigidTransform
from wpcal.touch.design import FREEDOMS, QUANTILES, farthest_rows

UNKNOWN_MM = 1e3
"""Before the first touch the part is anywhere within this: enough that it changes no digit of what touches hold."""


@dataclass(frozen=True, slots=True, eq=False)
class MovedModel:
    """What the unknowns are."""

    bodies: Bodies  #: b bodies; none for a part that moves as one.
    centre_part: FloatArray  #: shape (3,). About which the whole turns, in `part`, mm.
    length_mm: float  #: Of the part: a turn of the whole counts as the way at this distance.
    shared: int = 0  #: Number s of errors that all touches share.
    contacts: KeptContacts = field(default_factory=KeptContacts.none)  #: Between bodies that stay on each other.

    @property
    def size(self) -> int:
        """Number of unknowns, 6 + 6 b + s."""
        return 6 + 6 * len(self.bodies) + self.shared

    def prior(self) -> FloatArray:
        """Return the information before the first touch, shape (m, m)."""
        known = np.full(self.size, 1.0)
        known[:6] = UNKNOWN_MM**-2
        c = self.contacts
        n = c.normal_part[:, None, :]
        of_whole = slice(0, 6)
        G = self.rows(c.p_part, n, c.first) - self.rows(c.p_part, n, c.second)
        G[:, :, of_whole] = 0.0  # a contact is within the part
        G = G[:, 0] / c.sigma_mm[:, None]
        return np.asarray(np.diag(known) + G.T @ G)

    def rows(
        self, p_part: FloatArray, directions: FloatArray, body: IntArray, shared: FloatArray | None = None
    ) -> FloatArray:
        """Differentiate what touches measure by the unknowns, shape (n, q, m), mm.

        `p_part`: shape (n, 3). Touched points, in `part`, mm.
        `directions`: shape (n, q, 3). In which each touch measures: its numbers are the displacements along them.
        `body`: shape (n,). -1: the point does not move within the part.
        `shared`: shape (n, q, s). What each number sees of one standard deviation of the shared errors, mm.
        """
        n, b = len(p_part), len(self.bodies)
        whole = directions @ point_jacobian(p_part - self.centre_part) / self._scale
        own = np.zeros((n, directions.shape[1], b, 6))
        some = np.flatnonzero(body >= 0)
        if len(some):
            by = self._still().displacement_jacobian(body[some], p_part[some]) * self.bodies.scales[body[some]][:, None]
            own[some, :, body[some]] = directions[some] @ by
        common = np.zeros((n, directions.shape[1], self.shared)) if shared is None else shared
        return np.concatenate([whole, own.reshape(n, directions.shape[1], 6 * b), common], axis=2)

    def seam_rows(self, points: MeetingPoints) -> FloatArray:
        """Differentiate points of seams by the unknowns, shape (k, 3, m)."""
        k, b = len(points.p_part), len(self.bodies)
        J = np.zeros((k, 3, self.size))
        if b:
            scales = self.bodies.scales.ravel()
            J[:, :, 6 : 6 + 6 * b] = meeting_jacobian(self._still(), points)[:, :, 6 : 6 + 6 * b] * scales
        J[:, :, :6] = point_jacobian(points.p_part - self.centre_part) / self._scale
        return J

    @property
    def _scale(self) -> FloatArray:
        return np.repeat([self.length_mm, 1.0], 3)

    def _still(self) -> Motions:
        return Motions.rigid(self.bodies, RigidTransform.identity(target="base", source="part"))


@dataclass(frozen=True, slots=True, eq=False)
class SeamPoints:
    """The points where errors count."""

    points: MeetingPoints  #: k points in the model.
    seams: tuple[str, ...]  #: length k. The seam of each.


@dataclass(frozen=True, slots=True, eq=False)
class Tacked:
    """A part whose bodies may move: what a choice of touches needs to know of it."""

    bodies: Bodies
    face_body: IntArray  #: shape (F,). The body of every face; -1: it does not move.
    seams: SeamPoints  #: Where the error counts.
    contacts: KeptContacts = field(default_factory=KeptContacts.none)

    def model(self, shared: int = 0) -> MovedModel:
        """Return its linear model, with a number of errors that all touches share."""
        places = np.concatenate([self.seams.points.p_part, self.bodies.centroid_part])
        centre = (places.min(axis=0) + places.max(axis=0)) / 2.0
        length = float(np.linalg.norm(places - centre, axis=1).max())
        return MovedModel(self.bodies, centre, max(length, 1.0), shared, self.contacts)


@dataclass(frozen=True, slots=True, eq=False)
class CommonErrors:
    """The robot's own error, the part's scale and the tool's error, before anything is touched.

    They count in what is told and reached, and do not change which touch is better than which.
    """

    teaching: TeachingError
    bodies: int  #: Number of unknowns of the bodies.
    places: FloatArray  #: shape (n, 3). Of the possible touches, in `part`, mm.
    made: FloatArray  #: shape (r, q, m). Rows of the touches that were made already.
    made_places: FloatArray  #: shape (r, 3).
    seams: FloatArray  #: shape (k, 3). Of the seam points.

    def joined(self, C: FloatArray, rows: FloatArray, chosen: Sequence[int]) -> tuple[ErrorModes, FloatArray]:
        """Return the errors, and the covariance of all unknowns and theirs: `fit_moved_bodies`, without residuals.

        `C`: shape (m, m). Of the unknowns, by the errors of the touches alone. `rows`: shape (n, q, m).
        """
        own = np.concatenate([self.made, rows[list(chosen)]])
        places = np.concatenate([self.made_places, self.places[list(chosen)]])
        touch, number = np.nonzero(own.any(axis=2))
        seen, of_bodies = own[touch, number], slice(6, 6 + self.bodies)
        common = np.delete(seen, np.arange(6, 6 + self.bodies), axis=1)
        touched = Whitened(np.zeros(len(seen)), common, seen[:, of_bodies], touch, 0)
        belief = foresee(touched.error_rows(places), 1.0, self.teaching.robot)
        modes = ErrorModes.of(places, belief, self.teaching.tool_mm)
        return modes, modes.with_unknowns(C, C @ own.transpose(0, 2, 1) @ own[:, :, 3:6], places)


LARGEST = 16.0  #: The sum of errors to this power: the largest decides, and below it the next.
MOST_SEAM_POINTS = 160  #: Seam points that the search looks at; the errors reported are those over all points.
PER_PAIR = 6  #: Of them where the same two bodies meet: the error is largest at the ends of the extent of a seam.
REDUCIBLE = 0.5  #: Weight of the largest error above its floor, beside the largest error.
OFTEN = 1e4  #: Each possible touch is made this many times to see what no touch can lower.
SWEEPS = 4  #: Each touch is exchanged this many times at most: the second sweep rarely gains a hundredth.
GAIN = 1e-3  #: An exchange counts if it lowers the sum by this share.
NEARLY = 1.05
"""Where a tolerance cannot be reached, touches are added until they leave this times the error that all would leave."""
CHUNK = 400_000  #: Pairs of a touch and a seam point that are judged at once: some tens of megabytes.


@dataclass(frozen=True, slots=True, eq=False)
class MovedSearch:
    """What may be touched, and where errors count."""

    #: shape (n, q, m). Of each possible touch, in units of its error: see `MovedModel.rows`. Rows of zeros measure
    #: nothing.
    rows: FloatArray
    seams: FloatArray  #: shape (k, 3, m). Of the seam points, mm: see `MovedModel.seam_rows`.
    #: shape (k,). The variance of each seam point that no touch can lower, mm²: see `with_floor`.
    floor: FloatArray = field(default_factory=lambda: np.zeros(1))
    common: CommonErrors | None = None

    @classmethod
    def with_floor(
        cls, rows: FloatArray, seams: FloatArray, start: FloatArray, common: CommonErrors | None = None
    ) -> MovedSearch:
        """Return the search that also judges what touches can lower.

        Where the largest error comes from a motion that no touch sees, every choice leaves nearly the same error. What
        is above the floor then decides.

        `start`: shape (m, m). Information before the first touch.
        """
        H = rows.reshape(-1, rows.shape[2])
        unseen = inverse(start + OFTEN * H.T @ H)
        return cls(rows, seams, np.einsum("kim,mn,kin->k", seams, unseen, seams), common)

    def information(self, chosen: Sequence[int]) -> FloatArray:
        """Return what touches add to the information, shape (m, m)."""
        H = self.rows[list(chosen)].reshape(-1, self.rows.shape[2])
        return np.asarray(H.T @ H)

    def errors(self, C: FloatArray) -> FloatArray:
        """Return the 95 % errors of the seam points with a covariance of the unknowns, shape (k,), mm."""
        return length_quantile(self.seams @ C @ self.seams.transpose(0, 2, 1), COVERAGE)

    def joint_error(self, C: FloatArray) -> float:
        """Return the length, mm, that no seam point's error exceeds, with 95 % probability; C has the shape (m, m)."""
        return joint_error(self.seams, C)

    def errors_with(self, start: FloatArray, chosen: Sequence[int]) -> FloatArray:
        """Return the 95 % errors of the seam points after chosen touches, shape (k,), mm; `start` is (m, m)."""
        J, C, modes = self._judged(start, chosen)
        found = J @ C @ J.transpose(0, 2, 1)
        if modes is not None and self.common is not None:
            found += (modes.rest_of(self.common.seams) + modes.tool_mm**2)[:, None, None] * np.eye(3)
        return length_quantile(found, COVERAGE)

    def joint_error_with(self, start: FloatArray, chosen: Sequence[int]) -> float:
        """Return what no seam point exceeds after chosen touches, with 95 %, mm; `start` has the shape (m, m)."""
        J, C, modes = self._judged(start, chosen)
        return joint_error(J, C, None if modes is None or self.common is None else modes.rest(self.common.seams))

    def _judged(self, start: FloatArray, chosen: Sequence[int]) -> tuple[FloatArray, FloatArray, ErrorModes | None]:
        C = inverse(start + self.information(chosen))
        if self.common is None or not len(self.common.made) + len(chosen):
            return self.seams, C, None
        modes, C = self.common.joined(C, self.rows, chosen)
        return np.concatenate([self.seams, modes.at(self.common.seams)], axis=2), C, modes

    def scores(self, C: FloatArray) -> FloatArray:
        """Return how large the errors are after each possible touch, shape (n,), mm."""
        many = max(1, CHUNK // max(len(self.seams), 1))
        S = self.seams @ C @ self.seams.transpose(0, 2, 1)
        parts = [self._scores(C, S, self.rows[first : first + many]) for first in range(0, len(self.rows), many)]
        return np.concatenate(parts)

    def _scores(self, C: FloatArray, S: FloatArray, H: FloatArray) -> FloatArray:
        n, q, m = H.shape
        X = C @ H.reshape(-1, m).T
        A = (self.seams.reshape(-1, m) @ X).reshape(-1, 3, n, q)
        D = np.eye(q) + np.einsum("nqm,mnr->nqr", H, X.reshape(m, n, q))
        values, vectors = np.linalg.eigh((D + D.transpose(0, 2, 1)) / 2.0)
        back = vectors / np.sqrt(np.maximum(values, 1.0))[:, None, :]  # below 1 is round-off
        B = np.einsum("kinr,nrq->ikqn", A, back)
        trace, square = np.zeros((len(S), n)), np.zeros((len(S), n))
        for i in range(3):
            for j in range(i, 3):
                left = S[:, i, j, None] - (B[i] * B[j]).sum(axis=1)
                square += (1.0 if i == j else 2.0) * left**2
                if i == j:
                    trace += np.maximum(left, 0.0)
        m_eff = trace**2 / np.maximum(square, 1e-300)
        factor = np.interp(m_eff, FREEDOMS, QUANTILES)
        above = np.maximum(trace - self.floor[:, None], 0.0)
        return _largest(np.sqrt(trace * factor)) + REDUCIBLE * _largest(np.sqrt(above * factor))

    def added(self, start: FloatArray, chosen: list[int]) -> int | None:
        """Return the touch to add next; None if all are chosen.

        `start`: shape (m, m). Information before the chosen touches.
        """
        if len(chosen) >= len(self.rows):
            return None
        scores = self.scores(inverse(start + self.information(chosen)))
        scores[chosen] = np.inf
        return int(np.argmin(scores))

    def exchanged(self, start: FloatArray, chosen: list[int]) -> list[int]:
        """Exchange chosen touches one by one while that makes the errors smaller.

        `start`, of shape (m, m), is the information before them.
        """
        chosen, M = list(chosen), start + self.information(chosen)
        for _ in range(SWEEPS):
            is_better = False
            for k, own in enumerate(chosen):
                without = M - self.information([own])
                scores = self.scores(inverse(without))
                now = scores[own]
                scores[chosen] = np.inf
                best = int(np.argmin(scores))
                if scores[best] < (1.0 - GAIN) * now:
                    chosen[k], M, is_better = best, without + self.information([best]), True
            if not is_better:
                break
        return chosen

    def chosen(self, start: FloatArray, count: int) -> list[int]:
        """Return the best `count` touches found, or all if there are not more; `start` has the shape (m, m)."""
        chosen = list[int]()
        while len(chosen) < count and (best := self.added(start, chosen)) is not None:
            chosen.append(best)
        return self.exchanged(start, chosen)

    def fewest(
        self, start: FloatArray, tolerance_mm: float, least: int, most: int, usual: int
    ) -> tuple[list[int], float]:
        """Return few touches after which no seam point's error exceeds the tolerance, with 95 % probability.

        `start`: shape (m, m).
        Returns `chosen`: list of int. If no number reaches it, few that are nearly as good as all, `most` at most.
        Returns `error_mm`: float. What they reach.
        """
        goal = max(tolerance_mm, NEARLY * self.joint_error_with(start, range(len(self.rows))))
        least = max(least, min(usual, most)) if goal > tolerance_mm else least
        chosen = self.chosen(start, least)
        error = self.joint_error_with(start, chosen)
        while error > goal and len(chosen) < most:
            best = self.added(start, chosen)
            if best is None:
                break
            chosen.append(best)
            error = self.joint_error_with(start, chosen)
        while error <= goal and len(chosen) > least:
            fewer = self.exchanged(start, self._without_one(start, chosen))
            reached = self.joint_error_with(start, fewer)
            if reached > goal:
                break
            chosen, error = fewer, reached
        return chosen, error

    def _without_one(self, start: FloatArray, chosen: list[int]) -> list[int]:
        """Leave out the touch without which the errors are least."""
        M = start + self.information(chosen)
        left = [self.errors(inverse(M - self.information([own]))).max() for own in chosen]
        k = int(np.argmin(left))
        return chosen[:k] + chosen[k + 1 :]

    def errors_after(self, start: FloatArray, order: Sequence[int]) -> FloatArray:
        """Return the errors of the seam points before the first touch, and after each in an order.

        `start`: shape (m, m).
        Returns shape (n + 1, k). mm.
        """
        return np.stack([self.errors_with(start, order[:count]) for count in range(len(order) + 1)])

    def in_order(self, start: FloatArray, chosen: Sequence[int]) -> list[int]:
        """Return chosen touches in the order in which each lowers the errors most; `start` has the shape (m, m)."""
        some = list(chosen)
        own = MovedSearch(self.rows[some], self.seams, self.floor)
        order = list[int]()
        while (best := own.added(start, order)) is not None:
            order.append(best)
        return [some[k] for k in order]


def _largest(errors: FloatArray) -> FloatArray:
    """Return a smooth largest value of each column, shape (k, n) → (n,)."""
    top = np.maximum(errors.max(axis=0), 1e-300)
    return np.asarray(top * ((errors / top) ** LARGEST).sum(axis=0) ** (1.0 / LARGEST))


def inverse(information: FloatArray) -> FloatArray:
    """Return the covariance of the unknowns that an information leaves, shape (m, m)."""
    found = np.linalg.inv(information)
    return np.asarray((found + found.T) / 2.0, dtype=np.float64)


def deciding_points(points: MeetingPoints) -> IntArray:
    """Return seam points among which the largest error is: far from one another, of every two bodies that meet.

    Returns shape (k,).
    """
    pairs, which = np.unique(np.column_stack([points.wall_body, points.base_body]), axis=0, return_inverse=True)
    each = max(2, min(PER_PAIR, MOST_SEAM_POINTS // max(len(pairs), 1)))
    if len(pairs) == 1:
        each = MOST_SEAM_POINTS // 10
    found = []
    for pair in range(len(pairs)):
        own = np.flatnonzero(which.ravel() == pair)
        found.append(own[farthest_rows(points.p_part[own], each)])
    return np.sort(np.concatenate(found))
