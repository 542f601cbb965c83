r"""What the touches tell of the robot's own error at the seams (kriging), where they show that there is one.

Residuals y of a fit with the gains Gᵢ have the covariance V = σ² I + a² F (`wpcal.calibrate.errors.robot_field`). Given
y, the field at the touches is :math:`a^2 K(\cdot, x) Q V^{-1} y`, and the wire at a seam point x is expected to be off
by :math:`J_x \sum_i G_i f(x_i) - f(x)`, averaged over what is believed of σ, a and the length. The seams are moved
against it. Without a field this would add errors: it is done only where the residuals are :math:`e^2` times as probable
with a field, of the sizes that are believed, as without one.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import logsumexp

from wpcal.calibrate.errors.budget import ErrorBudget
from wpcal.calibrate.errors.prediction import SigmaSource
from wpcal.calibrate.errors.robot_field import RobotField, correlation, evidence_of, solve_shared
from wpcal.core.arrays import FloatArray
from wpcal.core.issue import Issue
from wpcal.core.tangent import point_jacobian

LEAST_EVIDENCE = 2.0
"""Logarithm of the ratio of probabilities from which the seams are moved. Of 360 simulated calibrations without a
field none reached it; at 1, 1.5 % did, and errors grew by up to 3 %."""


@dataclass(frozen=True, slots=True, eq=False)
class FieldShift:
    """How far seams are moved for the robot's own error."""

    centre: FloatArray  #: shape (3,). Middle of the touches, mm.
    places: FloatArray  #: shape (n, 3). Of the touches, about the centre.
    lengths_mm: FloatArray  #: shape (L,).
    pulls: FloatArray  #: shape (L, n, 3). The field is the sum of these vectors, times their correlation.
    motion: FloatArray  #: shape (6,). What the field did to the pose, about the centre.
    log_evidence: float  #: Logarithm of how much more probable the residuals are with a field than without.

    @classmethod
    def of(cls, budget: ErrorBudget, robot: RobotField | None) -> FieldShift | None:
        """Return what the residuals tell; None where they do not tell of a field."""
        rows, without = budget.belief.rows, RobotField.none()
        if rows is None or not len(rows.y) or (robot is not None and not robot.amplitude_mm):
            return None
        if robot is not None:
            without = replace(robot, amplitude_mm=0.0)
        s = None if budget.sigma.source is SigmaSource.ESTIMATED else math.sqrt(budget.belief.s2)
        (nodes, found), (bare, nothing) = evidence_of(rows, s, robot), evidence_of(rows, s, without)
        smooth = nodes.prior * (nodes.amplitudes_mm > 0)
        evidence = _log_mean(found.log, smooth / smooth.sum()) - _log_mean(nothing.log, bare.prior)
        if evidence < LEAST_EVIDENCE:
            return None
        weight, s2, a2 = nodes.weighed(found.log), nodes.sigmas[:, None, None] ** 2, nodes.amplitudes_mm[:, None] ** 2
        pulls = np.zeros((len(nodes.lengths_mm), *rows.places.shape))
        at_touches = np.zeros_like(budget.places)
        for k, length in enumerate(nodes.lengths_mm.tolist()):
            seen, vectors = np.linalg.eigh(rows.field(length))
            variance = s2 + nodes.rest_mm**2 * rows.unit2 + a2 * np.maximum(seen, 0.0)
            shared = None if rows.shared is None else vectors.T @ rows.shared
            solved, _ = solve_shared(variance, shared, vectors.T @ rows.y)
            pull = rows.rest @ (vectors @ np.sum(weight[k][:, :, None] * a2 * solved, axis=(0, 1)))
            np.add.at(pulls[k], rows.owner, pull[:, None] * rows.root)
            at_touches += correlation(budget.places, rows.places, length) @ pulls[k]
        motion = np.einsum("nij,nj->i", budget.gain, at_touches)
        return cls(budget.centre, rows.places, nodes.lengths_mm, pulls, motion, evidence)

    def at(self, points_base: FloatArray) -> FloatArray:
        """Return by how much points are moved, shape (k, 3), mm."""
        x = points_base - self.centre
        moved = -np.asarray(point_jacobian(x) @ self.motion)
        for length, pull in zip(self.lengths_mm.tolist(), self.pulls, strict=True):
            moved += correlation(x, self.places, length) @ pull
        return moved

    def issue(self, most_mm: float) -> Issue:
        """What was done, and how to leave it out."""
        message = (
            f"the seams follow the robot's own error, up to {most_mm:.2g} mm: the residuals are "
            f"{math.exp(min(self.log_evidence, 20.0)):.0f} times as probable with such an error as without one; "
            "--rigid places them by the pose alone"
        )
        return Issue("field-followed", message)

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {
            "log_evidence": self.log_evidence,
            "centre_mm": self.centre.tolist(),
            "places_mm": self.places.tolist(),
            "lengths_mm": self.lengths_mm.tolist(),
            "pulls_mm": self.pulls.tolist(),
            "motion": self.motion.tolist(),
        }

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> FieldShift:
        """Read what `to_record` returned."""
        names = ("centre_mm", "places_mm", "lengths_mm", "pulls_mm", "motion")
        centre, places, lengths, pulls, motion = (np.array(record[name], dtype=np.float64) for name in names)
        return cls(centre, places, lengths, pulls, motion, record["log_evidence"])


def _log_mean(log: FloatArray, weight: FloatArray) -> float:
    return float(logsumexp(log, b=weight))
