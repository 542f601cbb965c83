r"""From the error of a taught point to the error of a weld.

A taught point is off by a small random vector. The fit turns these vectors into a small motion
:math:`\xi = (\omega, v)` of the part (`wpcal.core.tangent`: rotation first, about the base's origin). A point
:math:`p` of the part is then off by :math:`\omega \times p + v`. The covariance of :math:`\xi` is computed in
`wpcal.calibrate.errors.linear_fit` and `wpcal.calibrate.errors.of_touches`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import chdtri, fdtri

from wpcal.calibrate.errors.robot_field import (
    RESOLUTION_MM,
    RESOLUTION_SIGMA_MM,
    TYPICAL_AMPLITUDE_MM,
    USUAL_SIGMA_MM,
    Belief,
    ResidualRows,
    RobotField,
    believe,
    believed_freedom,
    rigid_rest,
    scale_of,
)
from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.core.input_file import read_bytes
from wpcal.core.options import opt
from wpcal.core.records import parse_json
from wpcal.core.tangent import point_jacobian

COVERAGE = 0.95  #: Share of the errors that stay below the predicted error.
LEAST_FREEDOM = 4
"""With fewer numbers in the residuals the usual teaching error decides, and it counts as assumed. Three points have
three."""
JOINT_SAMPLES = 8192  #: Simulated errors behind the error of all seams together: its 95 % quantile is then good to 1 %.
EXCESS_POINTS = 64
"""Of larger clouds this many points are simulated. More points only make the simulated part smaller."""
EXCESS_GOAL = 1e-8  #: Scaled optimality error of a simulated fit: far below the sampling error.
EXCESS_SAMPLES = 256
"""Simulated fits behind the part of the minimax covariance that has no closed form: its scale is then good to 5 %."""
LEAST_ERROR_MM = 1e-6  #: Below 1 nm an error says nothing of a robot, and its square may be no number any more.


@dataclass(frozen=True, slots=True)
class ToolError:
    """Standard deviations of the tool centre point: per axis sideways, and along the wire, with its stick-out.

    Raises `InputError` when one is negative or not finite.
    """

    side_mm: float
    along_mm: float

    def __post_init__(self) -> None:
        if not all(math.isfinite(each) and each >= 0 for each in (self.side_mm, self.along_mm)):
            raise InputError(f"tool error: expected lengths that are not negative, got {self.side_mm}, {self.along_mm}")

    @classmethod
    def read(cls, text: str) -> ToolError:
        """Read ``side,along`` in mm, or a file of earlier jobs (`wpcal.study.drift.pooled`)."""
        try:
            if text.endswith(".json"):
                found = parse_json(read_bytes(Path(text)), path=text)["tool"]
                return cls(found["side_mm"], found["along_mm"])
            side, along = (float(word) for word in text.split(","))
        except (ValueError, KeyError, TypeError):
            what = "a file in which jobs tell of the tool (wpcal drift --cell-errors), or sideways and along the wire"
            raise InputError(f"tool error: expected {what} in mm, as 0.2,0.5; got {text!r}") from None
        return cls(side, along)

    @property
    def covariance(self) -> FloatArray:
        """In the axes of the tool, of which z is along the wire, shape (3, 3), mm²."""
        return np.diag([self.side_mm**2, self.side_mm**2, self.along_mm**2])

    def to_record(self) -> dict[str, float]:
        """Return plain values for a JSON file."""
        return {"side_mm": self.side_mm, "along_mm": self.along_mm}


@dataclass(frozen=True, slots=True)
class TeachingError:
    """What is known of the error of a taught point, per axis of the base.

    Raises `InputError` when both are given, or one is negative, not finite, or neither 0 nor `LEAST_ERROR_MM` at least.
    """

    sigma_mm: float | None = opt(None, "Teaching error: standard deviation per axis.")
    bound_mm: float | None = opt(None, "Teaching error: largest error per axis.")
    tcp_bias_mm: float = opt(0.0, "Error of the tool centre point.")
    robot: RobotField | None = opt(
        None,
        "The robot's own smooth error: standard deviation per axis, and the distance over which it changes (0.3,500). "
        "Or an identification.json, or a file of wpcal drift --cell-errors. Without it, the prior of an uncalibrated "
        "six-axis arm and the residuals tell.",
        "--robot-mm",
        metavar="AMPLITUDE,LENGTH|FILE",
        read=RobotField.read,
    )
    tool: ToolError | None = opt(
        None,
        "Standard deviations of the tool centre point, sideways and along the wire with its stick-out (0.2,0.5), or a "
        "file of wpcal drift --cell-errors. Where rows say how the tool was turned, what they share cancels in part.",
        "--tool-mm",
        metavar="SIDE,ALONG|FILE",
        read=ToolError.read,
    )
    scale_error: float | None = None  #: Standard deviation of the scale of the part, if it was fitted and is applied.

    def __post_init__(self) -> None:
        for name in ("sigma_mm", "bound_mm", "tcp_bias_mm"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value >= 0):
                raise InputError(f"teaching error: {name} is a length that is not negative, got {value}")
            if value is not None and 0.0 < value < LEAST_ERROR_MM:
                raise InputError(f"teaching error: expected {name} 0, or at least {LEAST_ERROR_MM:g}, got {value}")
        if self.sigma_mm is not None and self.bound_mm is not None:
            raise InputError("teaching error: give sigma_mm or bound_mm, not both")

    @property
    def per_axis_mm(self) -> float | None:
        """Standard deviation per axis, mm; bound / √3 for an even distribution."""
        return self.bound_mm / math.sqrt(3.0) if self.bound_mm is not None else self.sigma_mm

    def believed(self, rows: ResidualRows, covariances: FloatArray | None) -> tuple[Belief, Sigma]:
        """Weigh what is stated and the residuals.

        `covariances`: shape (n, 3, 3). Those that the observations state themselves, mm².
        """
        if covariances is not None:
            return self.believe(rows, 1.0), Sigma.of_each(covariances)
        if self.per_axis_mm is not None:
            sigma = Sigma.stated(self.per_axis_mm)
            return self.believe(rows, sigma.mm), sigma
        seen = float(np.sqrt(np.mean(rows.y**2))) if len(rows.y) else 0.0
        is_exact = len(rows.y) >= LEAST_FREEDOM and seen < RESOLUTION_SIGMA_MM
        if len(rows.y) < LEAST_FREEDOM or is_exact:  # residuals of three points may be small by luck
            sigma = Sigma(RESOLUTION_SIGMA_MM if is_exact else max(USUAL_SIGMA_MM, seen), SigmaSource.ASSUMED)
            return replace(self.believe(rows, sigma.mm), chance=1.0), sigma
        belief = self.believe(rows, None)
        return belief, Sigma.believed(belief)

    def believe(self, rows: ResidualRows, s: float | None) -> Belief:
        """Weigh residuals, as `believe`; a scale that was applied has the error of its fit."""
        belief = believe(rows, s, self.robot)
        return belief if self.scale_error is None else replace(belief, scale=self.scale_error)

    def tested_sigma_mm(self, places: FloatArray, postures: FloatArray | None = None) -> float | None:
        """Standard deviation per axis of residuals, if the teaching error is stated: with those of robot and tool.

        A wrong touch shows against this. What is believed of the robot before the touches counts, because a wrong touch
        would make the robot look worse.

        `places`: shape (n, 3), in the base if `postures`, shape (n, 3, 3), says how the touches turned the tool, mm.
        """
        if self.per_axis_mm is None:
            return None
        by_tool = self._tool_residual_mm(places, self.shared(postures))
        return math.hypot(self.per_axis_mm, self.robot_residual_mm(places), by_tool)

    @staticmethod
    def _tool_residual_mm(places: FloatArray, shared: FloatArray | None) -> float:
        """Standard deviation per axis that the tool's error leaves in the residuals of places, shape (n, 3)."""
        n = len(places)
        if shared is None or n < 3:
            return 0.0
        Q = np.linalg.qr(point_jacobian(places - places.mean(axis=0)).reshape(-1, 6))[0]
        left = float(np.sum(shared**2) - np.sum((Q.T @ shared.reshape(3 * n, -1)) ** 2))
        return math.sqrt(max(left, 0.0) / (3 * n - 6))

    def shared(self, postures: FloatArray | None) -> FloatArray | None:
        """Return what postures, shape (n, 3, 3), make of each standard deviation of the tool's error, shape alike."""
        sigma = np.sqrt(np.diag(self.tool_covariance))
        return None if postures is None or not sigma.any() else np.asarray(postures * sigma)

    def robot_residual_mm(self, places: FloatArray) -> float:
        """Standard deviation per axis that the robot's own error leaves in the residuals of places, shape (n, 3)."""
        prior, about = believe(None, 1.0, self.robot), places - places.mean(axis=0)
        a2s = prior.a2 if self.robot is not None else TYPICAL_AMPLITUDE_MM**2 * prior.a2 / prior.a2.sum()
        pairs = zip(prior.lengths_mm.tolist(), a2s.tolist(), strict=True)
        return math.sqrt(prior.rest_mm**2 + sum(a2 * rigid_rest(about, length) for length, a2 in pairs if a2))

    @property
    def tool_covariance(self) -> FloatArray:
        """Covariance of the tool centre point in the axes of the tool, shape (3, 3), mm²."""
        stated = np.zeros((3, 3)) if self.tool is None else self.tool.covariance
        return stated + self.tcp_bias_mm**2 / 3.0 * np.eye(3)

    @property
    def tool_mm(self) -> float:
        """Standard deviation per axis of the tool's error in another posture, mm.

        A bias fixed in the tool moves by 2 sin(angle / 2) times its length when the wrist turns: √2 for a quarter turn.
        """
        return math.sqrt(2.0 / 3.0 * float(np.trace(self.tool_covariance)))

    @property
    def is_bounded(self) -> bool:
        """Whether the error is evenly distributed within a bound."""
        return self.bound_mm is not None


def postures_of(names: Sequence[str], known: Mapping[str, FloatArray]) -> FloatArray | None:
    """Return the axes of the tool at observations, shape (n, 3, 3), by their names; None if one is not known."""
    return np.array([known[name] for name in names]) if known and known.keys() >= set(names) else None


class SigmaSource(Enum):
    """Where the teaching error behind a predicted error comes from."""

    STATED = "stated"
    ESTIMATED = "estimated"  #: From the residuals.
    ASSUMED = "assumed"
    """The usual teaching error, because the residuals show too little; or the last digit of a controller, because they
    are smaller than it explains."""


@dataclass(frozen=True, slots=True)
class Sigma:
    """The teaching error behind a predicted error, and how it is known."""

    mm: float  #: Standard deviation per axis; the root mean square if every observation states its own.
    source: SigmaSource
    degrees_of_freedom: float = math.inf  #: Behind an estimate; infinite otherwise.

    @classmethod
    def believed(cls, belief: Belief) -> Sigma:
        """Take what the residuals and the prior of the usual teaching error say together."""
        s2 = np.array(belief.s2)
        freedom = believed_freedom(s2, belief.s4 - s2**2)
        return cls(math.sqrt(float(s2 * scale_of(freedom))), SigmaSource.ESTIMATED, float(freedom))

    @classmethod
    def stated(cls, mm: float) -> Sigma:
        """Take a stated error per axis, mm, or `RESOLUTION_SIGMA_MM` if it is smaller."""
        if mm < RESOLUTION_SIGMA_MM:
            return cls(RESOLUTION_SIGMA_MM, SigmaSource.ASSUMED)
        return cls(mm, SigmaSource.STATED)

    @classmethod
    def expected(cls, stated_mm: float | None) -> Sigma:
        """Take a stated error per axis, mm, or `USUAL_SIGMA_MM` where nothing is stated and no residual tells."""
        return cls(USUAL_SIGMA_MM, SigmaSource.ASSUMED) if stated_mm is None else cls.stated(stated_mm)

    @classmethod
    def of_each(cls, covariances: FloatArray) -> Sigma:
        """Summarise observations that each state their error, shape (n, 3, 3), mm²."""
        return cls(float(np.sqrt(np.mean(np.trace(covariances, axis1=1, axis2=2)) / 3.0)), SigmaSource.STATED)

    def describe(self) -> str:
        """Return a phrase for a person: the value and where it comes from."""
        how = self.source.value
        if self.source is SigmaSource.ESTIMATED:
            how = f"estimated from the residuals with {self.degrees_of_freedom:.0f} degrees of freedom"
        elif self.source is SigmaSource.ASSUMED and self.mm == RESOLUTION_SIGMA_MM:
            how = f"assumed: a controller shows {RESOLUTION_MM:g} mm"
        return f"teaching error {self.mm:.2g} mm per axis, {how}"

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        freedom = None if math.isinf(self.degrees_of_freedom) else self.degrees_of_freedom
        return {"used_sigma_mm": self.mm, "provenance": self.source.value, "degrees_of_freedom": freedom}


def _satterthwaite(covariances: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the traces of n covariances, and the degrees of freedom m of their squared lengths, 1 to 3, shape (n,)."""
    trace = np.trace(covariances, axis1=1, axis2=2)
    square = np.einsum("kij,kij->k", covariances, covariances)
    return trace, np.divide(trace**2, square, out=np.ones_like(trace), where=square > 0)


def _square_quantile(m: FloatArray, level: float, degrees_of_freedom: FloatArray | float) -> FloatArray:
    """Return the quantile of a squared length over its mean, shape (n,)."""
    freedom = np.broadcast_to(degrees_of_freedom, m.shape)
    quantile = np.asarray(chdtri(m, 1.0 - level) / m)
    known = np.isfinite(freedom)
    quantile[known] = fdtri(m[known], freedom[known], level)
    return quantile


def length_quantile(
    covariances: FloatArray, level: float, *, degrees_of_freedom: FloatArray | float = math.inf
) -> FloatArray:
    """Length that Gaussian vectors stay below with a given probability.

    The squared length of one with covariance C is close to tr C · F(m, ν) with m = (tr C)² / tr C² (Satterthwaite).

    `covariances`: shape (k, 3, 3). mm².
    `degrees_of_freedom`: Behind the scale of the covariances, shape (k,) or one for all.
    Returns shape (k,). mm.
    """
    trace, m = _satterthwaite(covariances)
    return frozen(np.sqrt(np.maximum(trace, 0.0) * _square_quantile(m, level, degrees_of_freedom)))


def symmetric_root(covariances: FloatArray) -> FloatArray:
    """Return the symmetric roots of covariances, shape (..., n, n), which may be singular.

    Round-off turns eigenvectors of equal values: with another root each turn would draw other errors.
    """
    values, vectors = np.linalg.eigh(covariances)
    return np.asarray((vectors * np.sqrt(np.maximum(values, 0.0))[..., None, :]) @ vectors.swapaxes(-1, -2))
