r"""The error budget: everything that lets the wire miss the real seam, computed once for a fit.

The fit turns errors of touches into a small motion :math:`\eta = \sum_i G_i (e_i + f(x_i) + \varepsilon (x_i - c))` of
the part (about the middle c of the touches). A wire that is sent to a seam point x misses it by

.. math:: J_x \eta - f(x) - \varepsilon (x - c) + R b,

with the robot's own error f at both places, so that what is common cancels, the scale :math:`\varepsilon` of the part,
and the error b of the tool in another posture. The terms of the GUM (JCGM 100) are used: a standard uncertainty per
contribution, of type A (from these observations) or B (known otherwise), with degrees of freedom and coverage factor.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from wpcal.calibrate.errors.prediction import (
    COVERAGE,
    JOINT_SAMPLES,
    Sigma,
    SigmaSource,
    length_quantile,
    symmetric_root,
)
from wpcal.calibrate.errors.robot_field import (
    PRIOR_SCALE,
    Belief,
    FieldOrigin,
    believed_freedom,
    correlation,
    rigid_rest,
    scale_of,
)
from wpcal.core.arrays import FloatArray, IntArray, as_points, frozen
from wpcal.core.same_bits import first_least
from wpcal.core.tangent import point_jacobian, translation_adjoint

JOINT_POINTS = 32
"""This many points stand for all seams where errors are drawn together: the furthest, and those with most error."""
MOST_PLACES = 256  #: Of more touches, those in one cell of a grid count as one place of the field.
JACOBIANS = np.concatenate([point_jacobian(np.zeros((1, 3))), point_jacobian(np.eye(3)) - point_jacobian(np.zeros(3))])
"""shape (4, 3, 6). The Jacobian of a point is their sum with the factors 1, x, y, z."""
AT_ONCE = 1024  #: The arrays of this many points stay in the processor's cache; 60 000 at once take twice as long.
CONTRIBUTIONS = ("touching", "tool", "robot", "part", "model")


@dataclass(frozen=True, slots=True, eq=False)
class JointErrors:
    """The largest error among points that move together."""

    row: int  #: Of the point with the largest error of its own, the first of equal ones.
    own_mm: float  #: 95 % error of that point.
    drawn_mm: FloatArray  #: shape (JOINT_SAMPLES,). Largest error among all points, ascending.

    @property
    def error_95_mm(self) -> float:
        """What all points stay below together with 95 % probability."""
        return float(np.quantile(self.drawn_mm, COVERAGE))


@dataclass(frozen=True, slots=True, eq=False)
class ErrorBudget:
    """The contributions to the error of points of a fitted part, in base coordinates."""

    centre: FloatArray  #: shape (3,). Middle of the touches.
    places: FloatArray  #: shape (n, 3). Of the touches, about the centre.
    gain: FloatArray  #: shape (n, 6, 3). G, about the centre.
    touching: FloatArray  #: shape (6, 6). Covariance of η of errors of unit size.
    #: shape (6, 6). Covariance by which a fit moves more than G says, per unit error: minimax.
    excess: FloatArray
    model: FloatArray  #: shape (6, 6). Covariance of η that does not depend on the size of the errors.
    belief: Belief
    sigma: Sigma  #: The teaching error, for words.
    white: FloatArray  #: shape (6, 6). Covariance of η by errors of 1 mm that are independent from place to place.
    fields: FloatArray  #: shape (L, 6, 6). Covariance of η by the unit field, for each length of the belief.
    #: shape (3, 3). Covariance of the tool's error in the axes of the tool.
    tool: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))
    #: shape (6, 3). From the tool's error to η, where the postures of all touches are known.
    tool_gain: FloatArray | None = None
    scale: float = PRIOR_SCALE  #: Root mean square of the scale, after the touches.

    @classmethod
    def of(
        cls,
        places_base: FloatArray,
        gain: FloatArray,
        touching: FloatArray,
        belief: Belief,
        sigma: Sigma,
        *,
        excess: FloatArray | None = None,
    ) -> ErrorBudget:
        """Collect the contributions.

        `places_base`: shape (n, 3). Of the touches, mm.
        `gain`: shape (n, 6, 3). `touching`, `excess`: shape (6, 6). About the middle of the touches.
        """
        centre, nothing = places_base.mean(axis=0), np.zeros((6, 6))
        places = places_base - centre
        white = np.asarray(np.einsum("nij,nkj->ik", gain, gain))
        further = nothing if excess is None else excess
        if len(places) > MOST_PLACES:
            places, gain = _coarse(places, gain)
        fields = np.stack([_of_field(places, gain, further, length) for length in belief.lengths_mm.tolist()])
        moved = (touching, further, nothing)
        return cls(centre, places, gain, *moved, belief, sigma, white, fields, scale=belief.scale)

    def moved_by(self, covariance_base: FloatArray) -> ErrorBudget:
        """Add a covariance of the pose, shape (6, 6), about the base's origin, that no error of a touch explains."""
        shift = translation_adjoint(-self.centre)
        return replace(self, model=self.model + shift @ covariance_base @ shift.T)

    @property
    def covariance(self) -> FloatArray:
        """Of the motion ξ of the pose about the origin of the base, without the robot's error at the seams."""
        own = self.belief.s2 * (self.touching + self.excess) + self.model
        own = own + np.tensordot(self.belief.a2, self.fields, axes=1) + self.belief.rest_mm**2 * self.white
        own = own + self._tool[1]
        back = translation_adjoint(self.centre)
        return frozen(back @ own @ back.T)

    @property
    def _tool(self) -> tuple[FloatArray, FloatArray]:
        """Covariance of the tool's error at the welds, (3, 3), and of η by that at the touches, (6, 6).

        A weld turns the tool as it likes: its error is taken along the direction in which the part is known worst.
        Where it is not known how the touches turned it, either, it counts twice.
        """
        gain = np.zeros((6, 3)) if self.tool_gain is None else self.tool_gain
        at_touches = gain @ self.tool @ gain.T
        axes = np.linalg.eigh((self.touching + at_touches)[3:, 3:])[1]
        at_weld = (axes * np.linalg.eigvalsh(self.tool)) @ axes.T
        return np.asarray(at_weld if self.tool_gain is not None else 2.0 * at_weld), np.asarray(at_touches)

    def _scale_effect(self, x: FloatArray) -> FloatArray:
        """Return the error of points by a unit scale, shape (k, 3)."""
        eta = np.einsum("nij,nj->i", self.gain, self.places)
        return np.asarray(point_jacobian(x) @ eta - x)

    def contributions(self, points_base: ArrayLike) -> dict[str, FloatArray]:
        """Covariance of the error of points by contribution, each of shape (k, 3, 3), mm²."""
        return self._shared_out(as_points(points_base, name="points") - self.centre)[0]

    def _shared_out(self, x: FloatArray) -> tuple[dict[str, FloatArray], FloatArray]:
        """Return the contributions to points about the centre, and the degrees of freedom behind their sum."""
        with_one, belief = np.column_stack([np.ones(len(x)), x]), self.belief
        pairs = (with_one[:, :, None] * with_one[:, None, :]).reshape(-1, 16)
        unit = _along(pairs, self.touching + self.excess)
        weighted, F = np.zeros((len(x), len(self.places))), np.zeros((len(self.fields), len(x)))
        of_gain = with_one @ np.einsum("aij,nji->an", JACOBIANS, self.gain)
        for k in np.flatnonzero(belief.a4):
            alike = correlation(x, self.places, belief.lengths_mm[k])
            F[k] = np.trace(_along(pairs, self.fields[k]), axis1=1, axis2=2)
            F[k] += 3.0 - 2.0 * np.einsum("kn,kn->k", alike, of_gain)
            weighted += belief.a2[k] * alike
        met = point_jacobian(x) @ np.tensordot(weighted, self.gain, axes=1)
        of_fit = np.tensordot(belief.a2, self.fields, axes=1) + belief.rest_mm**2 * self.white
        of_place = (float(belief.a2.sum()) + belief.rest_mm**2) * np.eye(3)
        scaled = self.scale * self._scale_effect(x)
        at_weld, at_touches = self._tool
        found = {
            "touching": belief.s2 * unit,
            "tool": at_weld + _along(pairs, at_touches),
            "robot": _along(pairs, of_fit) - met - met.transpose(0, 2, 1) + of_place,
            "part": scaled[:, :, None] * scaled[:, None, :],
            "model": _along(pairs, self.model),
        }
        touched = np.trace(unit, axis1=1, axis2=2)
        scatter = (belief.s4 - belief.s2**2) * touched**2 + belief.a4 @ F**2 - (belief.a2 @ F) ** 2
        scatter += 2.0 * touched * ((belief.s2a2 - belief.s2 * belief.a2) @ F)
        return found, believed_freedom(np.trace(sum(found.values()), axis1=1, axis2=2), scatter)

    def covariances(self, points_base: ArrayLike) -> FloatArray:
        """Covariance of the error of the wire against the real seam, shape (k, 3, 3), mm²."""
        return np.asarray(sum(self.contributions(points_base).values()))

    def error_95_mm(self, points_base: ArrayLike) -> FloatArray:
        """Length that the error of a point stays below with 95 % probability, shape (k,), mm."""
        return self.limits_mm(points_base, 0.0, COVERAGE)

    def limits_mm(self, points_base: ArrayLike, own: FloatArray | float, level: float) -> FloatArray:
        """Length that the error of a point, with a further covariance `own`, stays below, shape (k,), mm."""
        x = as_points(points_base, name="points") - self.centre
        further, limits = np.broadcast_to(own, (len(x), 3, 3)), np.zeros(len(x))
        for part in (slice(start, start + AT_ONCE) for start in range(0, len(x), AT_ONCE)):
            found, freedom = self._shared_out(x[part])
            C = np.asarray(sum(found.values())) * scale_of(freedom)[:, None, None] + further[part]
            limits[part] = length_quantile(C, level, degrees_of_freedom=freedom)
        return frozen(limits)

    def largest_error_95(self, points_base: ArrayLike) -> tuple[int, float]:
        """Return the row of the point of shape (k, 3) with the largest error, the first of equal ones, and that, mm."""
        errors = self.error_95_mm(points_base)
        worst = int(first_least(-errors))
        return worst, float(errors[worst])

    def joint_errors(self, points_base: ArrayLike) -> JointErrors:
        """Draw the largest error among points of shape (k, 3) that move together.

        That all points stay below their own 95 % errors is less probable than 95 %; the quantiles of this sample hold
        for all points at once. The seed is fixed.
        """
        points = as_points(points_base, name="points")
        errors, ends = self.error_95_mm(points), farthest_ends(points)
        worst = int(first_least(-errors))
        ends = ends[np.argsort(-errors[ends], kind="stable")][: JOINT_POINTS - 1]
        rows = np.unique(np.append(ends, worst))
        root = symmetric_root(self._joint(points[rows] - self.centre))
        _, normal, state = _drawn(len(root))
        off = (normal @ root).reshape(JOINT_SAMPLES, -1, 3)
        drawn = np.sqrt(np.einsum("sni,sni->sn", off, off).max(axis=1))
        freedom = float(self._shared_out(points[[worst]] - self.centre)[1][0])
        if math.isfinite(freedom):
            rng = np.random.default_rng(0)
            rng.bit_generator.state = state
            drawn = drawn * np.sqrt((freedom - 2.0) / rng.chisquare(freedom, JOINT_SAMPLES))
        return JointErrors(worst, float(errors[worst]), frozen(np.sort(drawn)))

    def _joint(self, x: FloatArray) -> FloatArray:
        """Covariance of the errors of k points together, shape (3 k, 3 k)."""
        k, J = len(x), point_jacobian(x).reshape(-1, 6)
        rest2 = self.belief.rest_mm**2
        at_weld, at_touches = self._tool
        own = self.belief.s2 * (self.touching + self.excess) + self.model + rest2 * self.white + at_touches
        total = J @ own @ J.T + rest2 * np.eye(3 * k) + np.tile(at_weld, (k, k))
        scaled = self.scale * self._scale_effect(x).ravel()
        total += np.outer(scaled, scaled)
        for length, a2, own in zip(self.belief.lengths_mm, self.belief.a2, self.fields, strict=True):
            G = np.tensordot(correlation(x, self.places, length), self.gain, axes=1)
            crossed = J @ G.transpose(1, 0, 2).reshape(6, 3 * k)
            field = J @ own @ J.T - crossed - crossed.T
            total += a2 * (field + np.kron(correlation(x, x, length), np.eye(3)))
        return np.asarray(total)

    def shares(self, points_base: ArrayLike) -> dict[str, float]:
        """Share of each contribution in the variance at the point with the largest error.

        `points_base`: shape (k, 3). Base frame, mm.
        """
        found: dict[str, float] = self._of_seams([("", as_points(points_base, name="points"))])[0]["shares"]
        return found

    def describe(self) -> str:
        """Return a phrase for a person: what the predicted errors rest on."""
        field = self.belief.field
        return self.sigma.describe() + (f"; {field.describe()}" if field.amplitude_mm + field.rest_mm > 0 else "")

    def to_record(self, seams: Sequence[tuple[str, FloatArray]]) -> dict[str, Any]:
        """Return plain values for a JSON file. `seams`: Names and points, shape (k, 3), in `base`, mm."""
        filled = [(name, points) for name, points in seams if len(points)]
        return {
            "robot": self.belief.field.to_record(),
            "contributions": [self._described(name) for name in CONTRIBUTIONS],
            "coverage": COVERAGE,
            "seams": self._of_seams(filled) if filled else [],
        }

    def _of_seams(self, seams: Sequence[tuple[str, FloatArray]]) -> list[dict[str, Any]]:
        """Describe the point with the largest error of each seam."""
        points = np.concatenate([points for _, points in seams])
        errors, ends = self.error_95_mm(points), np.cumsum([len(points) for _, points in seams]).tolist()
        worst = [start + int(first_least(-errors[start:end])) for start, end in zip([0, *ends], ends, strict=False)]
        found, freedom = self._shared_out(points[worst] - self.centre)
        traces = {name: np.trace(each, axis1=1, axis2=2) for name, each in found.items()}
        total = np.asarray(sum(traces.values()))
        combined, of_scale = np.sqrt(total * scale_of(freedom)).tolist(), np.where(total > 0.0, total, 1.0)
        shares = {name: (each / of_scale).tolist() for name, each in traces.items()}
        return [
            {
                "seam": name,
                "error_95_mm": float(errors[row]),
                "standard_uncertainty_mm": combined[k],
                "coverage_factor": float(errors[row]) / combined[k] if combined[k] else None,
                "degrees_of_freedom": None if math.isinf(freedom[k]) else float(freedom[k]),
                "shares": {part: each[k] for part, each in shares.items()},
            }
            for k, ((name, _), row) in enumerate(zip(seams, worst, strict=True))
        ]

    @property
    def _tool_source(self) -> str:
        if not self.tool.any():
            return "tool centre point: nothing stated"
        if self.tool_gain is None:
            per_axis = math.sqrt(2.0 / 3.0 * float(np.trace(self.tool)))
            return f"tool centre point in another posture, {per_axis:.2g} mm per axis, stated"
        axes = ", ".join(f"{each:.2g}" for each in np.sqrt(np.diag(self.tool)))
        return f"tool centre point, {axes} mm along x, y and z (the wire) of the tool, as the touches turned it; stated"

    def _described(self, name: str) -> dict[str, Any]:
        """Say what a contribution is, its type, and where its size comes from."""
        belief = self.belief
        is_a = self.sigma.source is SigmaSource.ESTIMATED if name == "touching" else False
        is_a = is_a or (name == "robot" and belief.origin is FieldOrigin.ESTIMATED)
        told = {
            "touching": self.sigma.describe(),
            "tool": self._tool_source,
            "robot": belief.field.describe(),
            "part": f"scale of the part, {1e6 * self.scale:.2g} ppm after the touches, {1e6 * PRIOR_SCALE:.0f} before: "
            "steel within 10 K of 20 °C, and one part in five is far off",
            "model": "tails of the residuals and what a fit of this kind does with them",
        }
        return {"name": name, "type": "A" if is_a else "B", "source": told[name]}


def farthest_ends(points: FloatArray) -> IntArray:
    """Return the rows of points, shape (k, 3), that are the farthest in some direction, ascending."""
    away = points - points.mean(axis=0)
    return np.unique(np.argmax(away @ _drawn(3 * JOINT_POINTS)[0], axis=0))


@lru_cache(maxsize=4)
def _drawn(width: int) -> tuple[FloatArray, FloatArray, Mapping[str, Any]]:
    """Return directions, shape (3, 4 JOINT_POINTS), and standard normal numbers, shape (JOINT_SAMPLES, width).

    And the state of the generator after them. They are the same in every call; to draw them takes a sixth of a fit.
    """
    rng = np.random.default_rng(0)
    directions, normal = rng.standard_normal((3, 4 * JOINT_POINTS)), rng.standard_normal((JOINT_SAMPLES, width))
    return frozen(directions), frozen(normal), rng.bit_generator.state


def _of_field(places: FloatArray, gain: FloatArray, excess: FloatArray, length_mm: float) -> FloatArray:
    """Covariance of η by the unit field, shape (6, 6)."""
    summed = np.tensordot(correlation(places, places, length_mm), gain, axes=1)
    own = np.asarray(np.einsum("nij,nkj->ik", gain, summed))
    return own + rigid_rest(places, length_mm) * excess if excess.any() else own


def _along(pairs: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return J C Jᵀ of points, shape (k, 3, 3). `pairs`: shape (k, 16). Products of each two of (1, x, y, z)."""
    parts = np.einsum("aij,jl,bkl->abik", JACOBIANS, covariance, JACOBIANS)
    return np.asarray(pairs @ parts.reshape(16, 9)).reshape(-1, 3, 3)


def _coarse(places: FloatArray, gain: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Put places of one cell of a grid together; their gains add."""
    step = np.ptp(places, axis=0).max() / 6.0
    _, cell = np.unique(np.floor((places - places.min(axis=0)) / step).astype(np.int64), axis=0, return_inverse=True)
    cell = cell.ravel()
    count = np.bincount(cell)
    middle = np.stack([np.bincount(cell, weights=column) / count for column in places.T], axis=1)
    summed = np.zeros((len(count), *gain.shape[1:]))
    np.add.at(summed, cell, gain)
    return middle, summed
