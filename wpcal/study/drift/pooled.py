r"""What earlier jobs in a cell tell of the touches and of the robot: a small file that `wpcal calibrate` takes.

The error of a touch differs from job to job, the robot's own error at a place does not. The scatter of each residual
about its median over the jobs is therefore the teaching error, and the medians are what a rigid fit leaves of the
robot's smooth error (and of a model that differs from the part). Their likelihood, with the prior of the class of
uncalibrated six-axis arms, gives amplitude and length; few jobs or points leave nearly the prior.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.calibrate.errors.prediction import Sigma
from wpcal.calibrate.errors.robot_field import FieldOrigin, ResidualRows, RobotField, evidence_of
from wpcal.core.errors import InputError
from wpcal.core.tangent import point_jacobian
from wpcal.study.drift.jobs import PartJobs

CELL_ERRORS_SCHEMA = "wpcal/cell-errors/1"
LEAST_JOBS = 8  #: Of one part: the scatter of fewer is known to a third at best.
LEAST_POINTS = 3
NORMAL_MAD = 1.4826  #: Standard deviation over the median distance from the median, of normal errors.


@dataclass(frozen=True, slots=True)
class CellErrors:
    """Teaching error and robot's own error of a cell."""

    sigma_mm: float  #: Standard deviation per axis of a touch.
    field: RobotField
    jobs: int  #: How many were used.

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        field = {"amplitude_mm": self.field.amplitude_mm, "length_mm": self.field.length_mm, "rest_mm": 0.0}
        return {
            "schema": CELL_ERRORS_SCHEMA,
            "jobs": self.jobs,
            "sigma_mm": self.sigma_mm,
            "error_field": {"nominal": field, "identified": None},
        }


def pool_jobs(parts: Sequence[PartJobs]) -> CellErrors:
    """Pool the residuals of all parts that have enough jobs and points.

    Raises `InputError` when no part has.
    """
    used = [part for part in parts if len(part.names) >= LEAST_JOBS and len(part.points) >= LEAST_POINTS]
    if not used:
        raise InputError(
            f"the errors of a cell need {LEAST_JOBS} jobs of one part with {LEAST_POINTS} points in all of them"
        )
    squares, weight = 0.0, 0
    for part in used:
        count = part.residuals[0].size
        scatter = NORMAL_MAD * np.median(np.abs(part.residuals - np.median(part.residuals, axis=0)), axis=0)
        squares += len(part.names) * float(np.mean(scatter**2)) * count / max(count - 6, 1)
        weight += len(part.names)
    sigma = Sigma.stated(math.sqrt(squares / weight)).mm
    logs = []
    for part in used:
        T = np.median(part.T_base_part, axis=0)
        places = part.places @ T[:3, :3].T
        places = places - places.mean(axis=0)
        left, unit = np.median(part.residuals, axis=0), np.tile(np.eye(3), (len(places), 1, 1))
        rows = ResidualRows.of(places, point_jacobian(places), left, unit)
        # the median of n errors scatters by 1.25 / √n of one
        nodes, found = evidence_of(rows, 1.25 * sigma / math.sqrt(len(part.names)), None)
        logs.append(found.log)
    a2 = np.sum(nodes.weighed(np.sum(logs, axis=0)) * nodes.amplitudes_mm**2, axis=(1, 2))
    total = float(a2.sum())
    length = float(nodes.lengths_mm @ a2 / total) if total else float(nodes.lengths_mm.mean())
    return CellErrors(sigma, RobotField(math.sqrt(total), length, FieldOrigin.POOLED), weight)
