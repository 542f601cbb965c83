r"""What earlier jobs in a cell tell of the touches and of the robot: a small file that `wpcal calibrate` takes.

The error of a touch differs from job to job, the robot's own error at a place does not. The scatter of each residual
about its median over the jobs is therefore the teaching error, and the medians are what a rigid fit leaves of the
robot's smooth error (and of a model that differs from the part). Their likelihood, with the prior of the class of
uncalibrated six-axis arms, gives amplitude and length; few jobs or points leave nearly the prior. Where the rows say
how the tool was turned, the residuals of each job tell of its stick-out and of its tool centre point.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
from scipy.spatial.transform import Rotation

from wpcal.calibrate.errors.prediction import Sigma, ToolError
from wpcal.calibrate.errors.robot_field import FieldOrigin, ResidualRows, RobotField, correlation, evidence_of
from wpcal.calibrate.trust.tool_offset import LEAST_SEEN
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.tangent import point_jacobian
from wpcal.study.drift.jobs import PartJobs

CELL_ERRORS_SCHEMA = "wpcal/cell-errors/1"
LEAST_JOBS = 8  #: Of one part: the scatter of fewer is known to a third at best.
LEAST_POINTS = 3
LEAST_POSED = 4  #: Three points leave three numbers, as many as the tool has.
TOOL_ERRORS_MM = np.geomspace(0.03, 3.0, 24)  #: Standard deviations of the tool that are weighed.
MOST_SQUARE = 20.0  #: A job that is further off, by its normalised square, has a blunder, and counts as this far.
NORMAL_MAD = 1.4826  #: Standard deviation over the median distance from the median, of normal errors.

Seen: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]
"""Shapes (3 p, k), (k, 3) and (p, 3): directions of residuals, what errors of the tool make of them, and places."""


@dataclass(frozen=True, slots=True)
class CellErrors:
    """Teaching error and robot's own error of a cell."""

    sigma_mm: float  #: Standard deviation per axis of a touch.
    field: RobotField
    jobs: int  #: How many were used.
    tool: ToolError | None = None  #: None where too few jobs say how the tool was turned, or turned it too little.

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        field = {"amplitude_mm": self.field.amplitude_mm, "length_mm": self.field.length_mm, "rest_mm": 0.0}
        return {
            "schema": CELL_ERRORS_SCHEMA,
            "jobs": self.jobs,
            "sigma_mm": self.sigma_mm,
            "error_field": {"nominal": field, "identified": None},
            **({} if self.tool is None else {"tool": self.tool.to_record()}),
        }


def pool_jobs(parts: Sequence[PartJobs]) -> CellErrors:
    """Pool the residuals of all parts that have enough jobs and points. Raises `InputError` when no part has."""
    used = [part for part in parts if len(part.names) >= LEAST_JOBS and len(part.points) >= LEAST_POINTS]
    if not used:
        raise InputError(
            f"the errors of a cell need {LEAST_JOBS} jobs of one part with {LEAST_POINTS} points in all of them"
        )
    squares, weight, by_tool = 0.0, 0, [[*_by_tool(part)] for part in used]
    for part, seen in zip(used, by_tool, strict=True):
        count, taken = part.residuals[0].size, 6.0 + float(np.mean([U.shape[1] for U, _, _ in seen]))
        left = np.array([r.ravel() - U @ (U.T @ r.ravel()) for r, (U, _, _) in zip(part.residuals, seen, strict=True)])
        scatter = NORMAL_MAD * np.median(np.abs(left - np.median(left, axis=0)), axis=0)
        squares += len(part.names) * float(np.mean(scatter**2)) * count / max(count - taken, 1.0)
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
    field = RobotField(math.sqrt(total), length, FieldOrigin.POOLED)
    return CellErrors(sigma, field, weight, _pooled_tool(used, by_tool, sigma, field))


def _pooled_tool(
    parts: Sequence[PartJobs], by_tool: Sequence[Sequence[Seen]], sigma_mm: float, field: RobotField
) -> ToolError | None:
    """Weigh errors of the tool by what the residuals of each job tell: with a log-even prior, and without blunders."""
    pairs = [pair for part, seen in zip(parts, by_tool, strict=True) for pair in zip(part.residuals, seen, strict=True)]
    told = [(left.ravel(), *each) for left, each in pairs if each[0].shape[1]]
    if len(told) < LEAST_JOBS:
        return None
    side2, along2 = (each.ravel()[:, None] ** 2 for each in np.meshgrid(TOOL_ERRORS_MM, TOOL_ERRORS_MM))
    prior = np.concatenate([side2, side2, along2], axis=1)
    log = np.zeros(len(prior))
    for left, U, S, places in told:
        smooth = np.kron(correlation(places, places, field.length_mm), np.eye(3))
        y, own = U.T @ left, sigma_mm**2 * np.eye(U.shape[1]) + field.amplitude_mm**2 * U.T @ smooth @ U
        V = own + np.einsum("ij,gj,kj->gik", S, prior, S)
        drawn = np.einsum("i,gij,j->g", y, np.linalg.inv(V), y)
        log -= 0.5 * (np.linalg.slogdet(V)[1] + np.minimum(drawn, MOST_SQUARE))
    weight = np.exp(log - log.max())
    side, along = (math.sqrt(float(weight @ each[:, 0] / weight.sum())) for each in (side2, along2))
    return ToolError(side, along)


def _by_tool(part: PartJobs) -> Iterator[Seen]:
    """Yield for each job the directions of residuals along which errors of the tool show, and how much they do."""
    for T, angles in zip(
        part.T_base_part, part.residuals * np.nan if part.angles is None else part.angles, strict=True
    ):
        places, k = part.places @ T[:3, :3].T, 0
        turned = Rotation.from_euler("ZYX", np.nan_to_num(angles)).as_matrix().reshape(-1, 3)
        Q = np.linalg.qr(point_jacobian(places - places.mean(axis=0)).reshape(-1, 6))[0]
        U, S, Vt = np.linalg.svd(turned - Q @ (Q.T @ turned), full_matrices=False)
        if len(angles) >= LEAST_POSED and not np.isnan(angles).any():
            k = int(np.count_nonzero(LEAST_SEEN * math.sqrt(len(angles)) <= S))
        yield U[:, :k], S[:k, None] * Vt[:k], places
