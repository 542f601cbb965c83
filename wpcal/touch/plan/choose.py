r"""The choice of touches: least predicted 95 % error of the seams.

A touch sees one number, the distance along its normal n. With :math:`h = n^\top J(p)`, the fit of independent touches
with weights w has :math:`\xi = M^{-1} \sum w h^\top d` and :math:`M = \sum w h^\top h`. An error that all touches
share, such as that of the stick-out, adds :math:`g g^\top` with :math:`g = M^{-1} \sum w h^\top b`. There b is what
each touch sees of its standard deviation. Opposite touches cancel the part of the latency.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from wpcal.brep.graph import BrepGraph
from wpcal.calibrate.errors.budget import ErrorBudget
from wpcal.calibrate.errors.linear_fit import LinearFit
from wpcal.calibrate.errors.prediction import Sigma, TeachingError
from wpcal.calibrate.errors.robot_field import ResidualRows, RobotField, foresee
from wpcal.calibrate.observe.bodies import Bodies
from wpcal.calibrate.trust.residuals import LEAST_REDUNDANCY
from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.core.tangent import point_jacobian
from wpcal.core.wording import counted
from wpcal.touch.design import FREEDOMS, QUANTILES, SetSearch, farthest_rows
from wpcal.touch.moved_advice import HowMany, MovedAdvice, TouchChoices, advise_moved, shared_error_words
from wpcal.touch.plan.contacts import face_words
from wpcal.touch.plan.free import Strokes
from wpcal.touch.plan.options import Pattern, TouchOptions
from wpcal.touch.searches.plan import MOST_TOUCHES
from wpcal.touch.searches.setup import TouchSetup
from wpcal.touch.weldment import MovedModel, MovedSearch, Tacked

MOST_SEAM_POINTS = 16
"""Seam points that the search looks at, far from one another: the error is largest at the ends of their extent."""
LEAST_SHARE = 1e-6  #: A touch without an error of its own has this share of the variance that it shares.
CHUNK = 4000  #: Sets judged at once: some tens of megabytes.
FLAT = 1e-8  #: A set leaves a motion free if the reciprocal condition of its scaled information is below this.
RIDGE = 1e-13  #: Share of the information's trace that is added, so that every set has an inverse.
TESTED_FROM = 8
"""From this many touches on, a wrong one shall leave a residual, whichever it is: six hold the part, two test them."""
TESTED = 2.0 * LEAST_REDUNDANCY
"""A touch counts as tested if it keeps this share of its error: the part is not quite where it is planned."""
UNTESTED_FACTOR = 1.0  #: A set with a touch that nothing tests counts as one with twice its error.
STARTS = 3  #: Sets from which touches are exchanged: that of the greedy choice, and random ones.


@dataclass(frozen=True, eq=False)
class TouchDesign:
    """What sets of touches are judged by."""

    #: shape (n, 6). Derivative of each touch's number by the motion of the part about `centre`: (ω in rad, v in mm).
    rows: FloatArray
    variances: FloatArray  #: shape (n,). Of the independent part of each number, mm².
    shared: FloatArray  #: shape (n, s). What each touch sees of one standard deviation of s errors that all share, mm.
    weights: FloatArray  #: shape (n,). With which the fit weighs each number, 1/mm².
    seam_points: FloatArray  #: shape (k, 3). Relative to `centre`, mm.
    length_mm: float  #: Of the part: by it rotations are compared with translations.
    #: `p`, `normal`: shape (n, 3). Of the touches, about `centre`, mm.
    p: FloatArray
    normal: FloatArray
    robot: RobotField | None = None  #: The robot's own error, if it is stated.

    @classmethod
    def of(
        cls,
        p: FloatArray,
        normal: FloatArray,
        wire: FloatArray,
        setup: TouchSetup,
        seam_points: FloatArray,
        *,
        stick_out_sigma_mm: float,
    ) -> TouchDesign:
        """Take touches at points p with normals and wires, shape (n, 3) each, in `part` about a common centre."""
        rows = np.einsum("ni,nij->nj", normal, point_jacobian(p))
        stick = np.einsum("ni,ni->n", normal, wire) * stick_out_sigma_mm
        late = np.full(len(p), setup.latency_sigma_s * setup.search_speed_mm_s)
        variances = np.full(len(p), setup.repeatability_mm**2)
        shared = np.stack([stick, late], axis=1)
        weights = 1.0 / (variances + (shared**2).sum(axis=1))
        some = seam_points[farthest_rows(seam_points, MOST_SEAM_POINTS)]
        length = float(np.linalg.norm(p - p.mean(axis=0), axis=1).max()) if len(p) else 1.0
        return cls(rows, variances, shared, weights, some, max(length, 1.0), p, normal)

    def __len__(self) -> int:
        return len(self.rows)

    def largest_errors(self, sets: IntArray) -> FloatArray:
        """Largest predicted 95 % error over the seam points, mm; infinite for sets that leave a motion free.

        `sets`: shape (m, n). m sets of n touches.
        Returns shape (m,).
        """
        parts = [self._errors(sets[first : first + CHUNK]) for first in range(0, len(sets), CHUNK)]
        return np.concatenate(parts) if parts else np.empty(0)

    @cached_property
    def _scale(self) -> FloatArray:
        """The motion in mm: (length ω, v) by (ω, v)."""
        return np.repeat([self.length_mm, 1.0], 3)

    @cached_property
    def _parts(self) -> tuple[FloatArray, FloatArray, FloatArray]:
        """What each touch adds to information, noise and shared errors, shapes (n, 36), (n, 36) and (n, 6 s)."""
        H, w = self.rows / self._scale, self.weights
        square = np.einsum("ni,nj->nij", H, H).reshape(len(H), 36)
        common = np.einsum("n,ni,ns->nis", w, H, self.shared)
        return w[:, None] * square, (w**2 * self.variances)[:, None] * square, common.reshape(len(H), -1)

    @cached_property
    def _seam_squares(self) -> FloatArray:
        """From a scaled covariance to those of the seam points, shape (36, 9 k)."""
        J = point_jacobian(self.seam_points) / self._scale
        return np.asarray(np.einsum("kia,kjb->abkij", J, J).reshape(36, -1), dtype=np.float64)

    def covariances(self, sets: IntArray) -> tuple[FloatArray, BoolArray]:
        """Return the covariance of the motion of each set, shape (m, 6, 6), and which sets leave a motion free."""
        C, free = self._scaled_covariances(sets)
        return np.asarray(C / np.outer(self._scale, self._scale)), free

    def budget(self, chosen: IntArray) -> ErrorBudget:
        """Return the error budget of touches that hold the part, rows of shape (n,), before they are made."""
        p, n, w, variances, shared = (
            each[chosen] for each in (self.p, self.normal, self.weights, self.variances, self.shared)
        )
        places, A = p - p.mean(axis=0), n[:, :, None] * n[:, None, :]
        J, weights, own = point_jacobian(places), *(each[:, None, None] * A for each in (w, variances))
        common, alone = n[:, :, None] * shared[:, None, :], 1.0 / np.maximum(variances, LEAST_SHARE / w)
        fit = LinearFit(p, -A @ J / self._scale, A, 1.0 / self._scale, weights, own, common)
        belief = foresee(ResidualRows.of(places, J, 0.0 * p, alone[:, None, None] * A, common), 1.0, self.robot)
        return fit.budget(belief, Sigma.stated(float(np.sqrt(np.mean(1.0 / w)))), TeachingError())

    def _scaled_covariances(self, sets: IntArray) -> tuple[FloatArray, BoolArray]:
        information, noise, common = (part[sets].sum(axis=1) for part in self._parts)
        M = information.reshape(-1, 6, 6)
        trace = np.trace(M, axis1=1, axis2=2)
        A = np.linalg.inv(M + (RIDGE * trace)[:, None, None] * np.eye(6))
        free = np.trace(A, axis1=1, axis2=2) * trace >= 1.0 / FLAT
        G = A @ common.reshape(len(sets), 6, -1)
        return A @ noise.reshape(-1, 6, 6) @ A + G @ G.transpose(0, 2, 1), free

    def least_redundancy(self, sets: IntArray) -> FloatArray:
        """Share of its own error that the touch which the others test least keeps in its residual, shape (m,).

        Baarda's redundancy number, as `wpcal.calibrate.trust.residuals.unchecked_names` has it.
        """
        H = (self.rows / self._scale)[sets]
        M = np.einsum("mni,mnj->mij", H, H)
        trace = np.trace(M, axis1=1, axis2=2)
        A = np.linalg.inv(M + (RIDGE * trace)[:, None, None] * np.eye(6))
        return np.asarray(1.0 - np.einsum("mni,mij,mnj->mn", H, A, H).max(axis=1))

    def _errors(self, sets: IntArray) -> FloatArray:
        C, free = self._scaled_covariances(sets)
        S = (C.reshape(-1, 36) @ self._seam_squares).reshape(len(sets), -1, 9)
        trace = S[..., 0] + S[..., 4] + S[..., 8]
        square = np.maximum(np.einsum("mki,mki->mk", S, S), 1e-300)
        error = np.sqrt(np.maximum(trace, 0.0) * np.interp(trace**2 / square, FREEDOMS, QUANTILES)).max(axis=1)
        if sets.shape[1] >= TESTED_FROM:
            lacking = np.maximum(1.0 - self.least_redundancy(sets) / TESTED, 0.0)
            error *= 1.0 + UNTESTED_FACTOR * lacking
        error[free] = np.inf
        return np.asarray(error, dtype=np.float64)

    def free_motions(self) -> FloatArray:
        """Return the motions (length ω, v) about the centre that all touches together leave free, shape (k, 6)."""
        H = self.rows / np.repeat([self.length_mm, 1.0], 3)
        values, vectors = np.linalg.eigh(H.T @ H)
        return np.asarray(vectors[:, values <= FLAT * max(values[-1], 1e-300)].T)


def best_set(
    design: TouchDesign, n: int, *, slots: Sequence[IntArray] | None, rng: np.random.Generator
) -> tuple[IntArray, float]:
    """Return the best set of touches and its error.

    `slots`: shape (m,). Of a pattern: which touches each of the n places in it may have.
    Returns `rows`: shape (n,). Empty if no set holds all six freedoms.
    """
    search = SetSearch(design, len(design))
    if slots is None:
        rows, errors = search.exchanged(n, rng=rng, start=_greedy(design, n), starts=STARTS)
    else:
        rows, errors = search.exchanged_in_slots(slots, rng=rng, starts=1)
    if len(rows) == 0:
        return np.zeros(0, dtype=np.int64), np.inf
    return rows[0], float(errors[0])


def _greedy(design: TouchDesign, n: int) -> IntArray:
    """Add touches one by one: each time the one after which the motion that is known least is known best."""
    scale = np.repeat([design.length_mm, 1.0], 3)
    H = design.rows / scale * np.sqrt(design.weights)[:, None]
    M, chosen = 1e-6 * np.eye(6), list[int]()
    for _ in range(n):
        A = np.linalg.inv(M)
        gain = np.einsum("ni,ij,nj->n", H, A, H)
        gain[chosen] = -np.inf
        best = int(np.argmax(gain))
        chosen.append(best)
        M = M + np.outer(H[best], H[best])
    return np.array(chosen, dtype=np.int64)


def advise_searches(
    graph: BrepGraph, strokes: Strokes, design: TouchDesign, tacked: Tacked, options: TouchOptions
) -> MovedAdvice:
    """Choose searches for a weldment whose bodies may move. The index of a touch is its row in `strokes`.

    Raises `InputError` when a pattern is asked for.
    Raises `GeometryError` as in `advise_moved`.
    """
    if options.pattern is not Pattern.BEST:
        raise InputError(f"the pattern {options.pattern} is for a part that is one body: leave it or --bodies away")
    contacts, sigma = strokes.contacts, np.sqrt(design.variances)
    model = tacked.model(design.shared.shape[1])
    body = tacked.face_body[contacts.face]
    ways, common = contacts.normal / sigma[:, None], design.shared / sigma[:, None]
    rows = model.rows(contacts.p, ways[:, None, :], body, common[:, None, :])
    words = [face_words(graph, contacts.select(np.array([k])), int(face)) for k, face in enumerate(contacts.face)]
    choices = TouchChoices(tuple(f"S{k + 1}" for k in range(len(strokes))), tuple(words), body, contacts.p, rows)
    bodies = len(tacked.bodies)
    asked = HowMany(options.count(bodies), options.tolerance_mm, options.usual(bodies))
    return advise_moved(model, choices, tacked.seams, asked, teaching=TeachingError(robot=options.robot))


def fewest_set(
    design: TouchDesign, seam_points: FloatArray, options: TouchOptions, rng: np.random.Generator
) -> tuple[IntArray, str]:
    """Return few searches after which a part that is one body keeps all its seams within the tolerance.

    `seam_points`: shape (k, 3). All of them, relative to the centre of the design, mm.
    Returns `rows`: shape (n,).
    Returns `why`: str. Why the tolerance is not reached; otherwise empty.
    """
    tolerance_mm, least = options.tolerance_mm or np.inf, min(options.count(), len(design))
    best, _ = best_set(design, least, slots=None, rng=rng)
    error = joint_error_of(design, best, seam_points)
    if error <= tolerance_mm or len(best) == 0:
        return best, ""
    search, start = _as_one_body(design)
    order = [int(row) for row in best]
    most = min(MOST_TOUCHES, len(design))
    while error > tolerance_mm and len(order) < most and (row := search.added(start, order)) is not None:
        order.append(row)
        error = joint_error_of(design, np.array(order), seam_points)
    if error > tolerance_mm:
        return best, _why_not(design, best, order, seam_points, tolerance_mm)
    chosen = np.array(order)
    for count in range(least + 1, len(order)):  # the exchange may need fewer than the single steps
        fewer = np.array(search.exchanged(start, order[:count]))
        if joint_error_of(design, fewer, seam_points) <= tolerance_mm:
            chosen = fewer
            break
    return chosen, ""


def joint_error_of(design: TouchDesign, rows: IntArray, seam_points: FloatArray) -> float:
    """Return what no seam point exceeds, with 95 % probability, mm.

    `rows`: shape (n,). The touches.
    `seam_points`: shape (k, 3). About the centre of the design, mm.
    """
    if design.covariances(rows[None])[1][0]:
        return float("inf")
    return design.budget(rows).joint_errors(seam_points).error_95_mm


def _as_one_body(design: TouchDesign) -> tuple[MovedSearch, FloatArray]:
    """Return the search over the touches of a part that is one body, and the information before them."""
    count = design.shared.shape[1]
    model = MovedModel(Bodies((), np.zeros((0, 3)), ()), np.zeros(3), design.length_mm, count)
    scale = np.repeat([design.length_mm, 1.0], 3)
    rows = np.concatenate([design.rows / scale, design.shared], axis=1) / np.sqrt(design.variances)[:, None]
    J = point_jacobian(design.seam_points) / scale
    seams = np.concatenate([J, np.zeros((len(J), 3, count))], axis=2)
    return MovedSearch(rows[:, None, :], seams), model.prior()


def _why_not(
    design: TouchDesign, best: IntArray, order: list[int], seam_points: FloatArray, tolerance_mm: float
) -> str:
    few, many = (joint_error_of(design, np.array(rows), seam_points) for rows in (best, order))
    head = (
        f"{tolerance_mm:g} mm is not reached: {counted(len(best), 'touch')} leave {few:.2f} mm, {len(order)} leave "
        f"{many:.2f} mm"
    )
    exact = replace(design, variances=np.zeros(len(design)))
    common = joint_error_of(exact, np.array(order), seam_points)
    if common > tolerance_mm:
        return f"{head}, {shared_error_words(common)}"
    return f"{head}; a better repeatability of the touches would help"
