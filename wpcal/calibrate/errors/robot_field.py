r"""The robot's own error as a smooth random field over the base, and what is believed of it and of the touches.

A robot that shows :math:`x` has its tip at :math:`x - f(x)`. The components of :math:`f` are independent Gaussian
processes with mean zero and covariance :math:`a^2 \exp(-d^2 / 2 l^2)` at a distance d. The same robot teaches and
welds, so that what is common to touches and seams cancels; the rest grows with their distance and falls with l.

What nobody states is believed with weights: a grid of teaching errors, amplitudes and lengths, each weighed by its
prior and by the restricted likelihood of the residuals, which does not know the pose.

References: Patterson, Thompson (1971), Recovery of inter-block information when block sizes are unequal, Biometrika 58.
Slamani, Nubiola, Bonev (2012), Assessment of the positioning performance of an industrial robot, Industrial Robot 39:
an arm of 1.45 m reach, as delivered, is off by up to 0.65 mm along lines of its working space.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import chdtrc

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.core.input_file import read_bytes
from wpcal.core.records import parse_json
from wpcal.core.tangent import point_jacobian

USUAL_SIGMA_MM = 0.3  #: Teaching error per axis if none is stated: a careful touch with a worn wire tip.
RESOLUTION_MM = 0.01  #: Last digit that a controller shows. No point is known better than that.
RESOLUTION_SIGMA_MM = RESOLUTION_MM / math.sqrt(12.0)
"""Least teaching error per axis: that of rounding to the last digit. Exact residuals do not show a smaller one."""
SIGMA_FACTOR = 2.5  #: Prior of a teaching error that nobody states: within this factor of the usual one (68 %).
SIGMA_NODES = 48
CLASS_AMPLITUDES_MM = np.array([0.0, 0.1, 0.2, 0.3, 0.5, 1.0, 2.0])
CLASS_WEIGHTS = np.array([0.2, 0.24, 0.24, 0.2, 0.09, 0.02, 0.01])
"""Prior of the amplitude of an uncalibrated six-axis arm. Most are within 0.3 mm per axis, as one that was measured to
be off by up to 0.65 mm along lines (Slamani, Nubiola, Bonev 2012); one in thirty is far worse."""
ELSEWHERE, ELSEWHERE_WEIGHTS = np.array([0.5, 1.0, 2.0]), np.array([0.25, 0.5, 0.25])
"""How much an amplitude of other poses or jobs may differ here: an arm is not off alike in all of its space."""
TYPICAL_AMPLITUDE_MM = 0.26
"""Against this amplitude a wrong touch must stand out. The tail of the prior would hide it."""
CLASS_LENGTHS_MM = np.array([250.0, 500.0, 1000.0])
"""Prior of the length, equally likely: errors of joints and links change over a good part of the arm's reach."""
USUAL_SCALE = 1e-4
"""Standard deviation of the scale between model and robot before anything is touched: steel, 10 K from 20 °C."""
SCALES, SCALE_WEIGHTS = np.array([USUAL_SCALE, 1e-3]), np.array([0.8, 0.2])
"""One part in five is far off: hot from welding, or touched by a robot whose links are longer than it knows. One in
twenty covered 91 % of parts that are off by 1000 ppm; one in five costs no ``PASS`` where the size is right."""
PRIOR_SCALE = float(np.sqrt(SCALE_WEIGHTS @ SCALES**2))
MOST_EVIDENCE = 60  #: Observations of which the residuals are weighed; more hardly say more about a smooth field.


class FieldOrigin(Enum):
    """Where the amplitude and the length of the robot's error come from."""

    STATED = "stated"
    IDENTIFIED = "identified"  #: From held-out poses of the identification of this arm.
    POOLED = "pooled"  #: From earlier jobs in the same cell.
    ESTIMATED = "estimated"  #: From the residuals of this part, with the prior of the class.
    ASSUMED = "assumed"  #: The class of uncalibrated six-axis arms.


@dataclass(frozen=True, slots=True)
class RobotField:
    """The robot's own smooth error: standard deviation per axis, and the distance over which it changes.

    >>> RobotField.read("0.3,500").describe()
    'robot 0.3 mm per axis over 500 mm, stated'
    """

    amplitude_mm: float
    length_mm: float
    origin: FieldOrigin = FieldOrigin.STATED
    rest_mm: float = 0.0  #: Standard deviation per axis of what is independent from place to place, as of the posture.

    def __post_init__(self) -> None:
        for value in (self.amplitude_mm, self.rest_mm):
            if not (math.isfinite(value) and value >= 0):
                raise InputError(f"robot error: an amplitude is a length that is not negative, got {value}")
        if not (math.isfinite(self.length_mm) and self.length_mm > 0):
            raise InputError(f"robot error: the length is positive, got {self.length_mm}")

    @classmethod
    def read(cls, text: str) -> RobotField:
        """Read ``amplitude,length`` in mm, or the errors in a file (``FILE``, ``FILE:identified``).

        The file is an ``identification.json``, or of earlier jobs (`wpcal.study.drift.pooled`). Without a word after
        the colon, the errors are those of the nominal arm, by which the controller computes.
        """
        name, _, arm = text.rpartition(":") if text.endswith((":nominal", ":identified")) else (text, "", "nominal")
        if name.endswith(".json"):
            return cls._of_file(name, arm)
        try:
            amplitude, length = (float(word) for word in text.split(","))
        except ValueError:
            raise InputError(f"robot error: expected amplitude and length in mm, as 0.3,500; got {text!r}") from None
        return cls(amplitude, length)

    @classmethod
    def _of_file(cls, name: str, arm: str) -> RobotField:
        try:
            record = parse_json(read_bytes(Path(name)), path=name)
            found = record["error_field"][arm]
            origin = FieldOrigin.POOLED if "jobs" in record else FieldOrigin.IDENTIFIED
            return cls(found["amplitude_mm"], found["length_mm"], origin, found["rest_mm"])
        except (ValueError, KeyError, TypeError):
            raise InputError(
                f"robot error: {name} holds no errors of the {arm} arm (wpcal identify, wpcal drift --cell-errors)"
            ) from None

    @classmethod
    def none(cls) -> RobotField:
        """Return the field of a robot without errors of its own, as in a simulation."""
        return cls(0.0, 1000.0)

    def describe(self) -> str:
        """Return a phrase for a person: the values and where they come from."""
        how = self.origin.value
        if self.origin is FieldOrigin.ASSUMED:
            how = "assumed: uncalibrated six-axis arm"
        elif self.origin is FieldOrigin.ESTIMATED:
            how = "estimated from the residuals"
        if self.rest_mm:
            how = f"{self.rest_mm:.2g} mm from place to place, {how}"
        return f"robot {self.amplitude_mm:.2g} mm per axis over {self.length_mm:.0f} mm, {how}"

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {
            "amplitude_mm": self.amplitude_mm,
            "length_mm": self.length_mm,
            "rest_mm": self.rest_mm,
            "origin": self.origin.value,
        }


def correlation(a: FloatArray, b: FloatArray, length_mm: float) -> FloatArray:
    """Correlation of the field between places, shapes (..., n, 3) and (..., k, 3); shape (..., n, k)."""
    squares = np.sum(a**2, -1)[..., :, None] + np.sum(b**2, -1)[..., None, :] - 2.0 * a @ np.swapaxes(b, -1, -2)
    return np.asarray(np.exp(np.maximum(squares, 0.0) / (-2.0 * length_mm**2)))


def rigid_rest(places: FloatArray, length_mm: float) -> float:
    """Mean variance per axis that a rigid fit leaves of the unit field at places, shape (n, 3)."""
    n = len(places)
    if n < 3:
        return 0.0
    Q = np.linalg.qr(point_jacobian(places).reshape(-1, 6))[0].reshape(n, 18)
    left = 3 * n - float(np.sum(Q * (correlation(places, places, length_mm) @ Q)))
    return max(left / (3 * n - 6), 0.0)


@dataclass(frozen=True, slots=True, eq=False)
class ResidualRows:
    """Residuals of observations as rows of unit error, with the six motions of the pose taken out."""

    places: FloatArray  #: shape (n, 3). About their middle, mm.
    owner: IntArray  #: shape (m,). The observation of each row.
    root: FloatArray  #: shape (m, 3). What a row sees of an error of its observation, in units of its own error.
    rest: FloatArray  #: shape (m, m - 6). Basis of what the pose does not explain.
    y: FloatArray  #: shape (m - 6,). The residuals there.
    z: FloatArray  #: shape (m - 6,). What a part of twice its size would leave there.
    unit2: float  #: Square of 1 mm in the unit of the rows, on average.
    #: shape (m - 6, s). What one standard deviation of each error that all observations share leaves there.
    shared: FloatArray | None = None

    @classmethod
    def of(
        cls, places: FloatArray, J: FloatArray, d: FloatArray, information: FloatArray, shared: FloatArray | None = None
    ) -> ResidualRows:
        """Take out of residuals d what the pose explains.

        `places`, `d`: shape (n, 3), mm. `J`: shape (n, 3, 6). `information`: shape (n, 3, 3), up to one factor.
        `shared`: shape (n, 3, s). What each observation sees of one standard deviation of errors that all share, mm.
        """
        if len(places) > MOST_EVIDENCE:
            used = np.sort(np.random.default_rng(0).choice(len(places), MOST_EVIDENCE, replace=False))
            places, J, d, information = places[used], J[used], d[used], information[used]
            shared = None if shared is None else shared[used]
        values, vectors = np.linalg.eigh(information)
        owner, axis = np.nonzero(values > 1e-9 * values.max())
        root = np.sqrt(values[owner, axis])[:, None] * vectors[owner, :, axis]
        by_motion = np.einsum("mi,mik->mk", root, J[owner])
        rest = np.linalg.qr(by_motion / np.maximum(np.linalg.norm(by_motion, axis=0), 1e-300), mode="complete")[0][
            :, 6:
        ]
        y, z = (rest.T @ np.einsum("mi,mi->m", root, each[owner]) for each in (d, places))
        common = None if shared is None else rest.T @ np.einsum("mi,mis->ms", root, shared[owner])
        return cls(places, owner, root, rest, y, z, float(np.mean(np.sum(root**2, axis=1))), common)

    def field(self, length_mm: float) -> FloatArray:
        """Covariance of `y` by the unit field."""
        K = correlation(self.places, self.places, length_mm)[np.ix_(self.owner, self.owner)]
        return np.asarray(self.rest.T @ (K * (self.root @ self.root.T)) @ self.rest)


@dataclass(frozen=True, slots=True, eq=False)
class Belief:
    """Moments of what is believed: s is the factor on the stated covariances or the teaching error, a the amplitude."""

    s2: float
    s4: float
    lengths_mm: FloatArray  #: shape (L,).
    #: shape (L,). Moments where the length is this one: E[a² 1], E[a⁴ 1], E[s² a² 1], each times its probability.
    a2: FloatArray
    a4: FloatArray
    s2a2: FloatArray
    chance: float = 1.0  #: Probability of residuals as large as these, if the stated errors are true.
    origin: FieldOrigin = FieldOrigin.STATED
    rows: ResidualRows | None = None  #: The residuals that were weighed.
    rest_mm: float = 0.0  #: The robot's error that is independent from place to place.
    scale: float = PRIOR_SCALE  #: Root mean square of the scale of the part.

    @property
    def field(self) -> RobotField:
        """The field in two numbers."""
        total = float(self.a2.sum())
        length = float(self.lengths_mm @ self.a2 / total) if total > 0 else float(self.lengths_mm.mean())
        return RobotField(math.sqrt(total), length, self.origin, self.rest_mm)


@dataclass(frozen=True, slots=True, eq=False)
class Nodes:
    """Lengths, teaching errors and amplitudes that are weighed, with weights of shape (lengths, sigmas, amplitudes)."""

    lengths_mm: FloatArray
    sigmas: FloatArray
    amplitudes_mm: FloatArray
    prior: FloatArray
    rest_mm: float

    @classmethod
    def of(cls, rows: ResidualRows | None, s: float | None, field: RobotField | None) -> Nodes:
        """Lay out what may be, with its prior; what is stated has one node."""
        sigmas, log_s = _sigma_nodes(rows) if s is None else (np.array([s]), np.zeros(1))
        amplitudes, weights, lengths = CLASS_AMPLITUDES_MM, CLASS_WEIGHTS, CLASS_LENGTHS_MM
        if field is not None:
            amplitudes, weights, lengths = np.array([field.amplitude_mm]), np.ones(1), np.array([field.length_mm])
            if field.origin is not FieldOrigin.STATED:
                amplitudes, weights = ELSEWHERE * field.amplitude_mm, ELSEWHERE_WEIGHTS
        prior = np.broadcast_to(np.exp(log_s)[:, None] * weights, (len(lengths), len(sigmas), len(amplitudes)))
        return cls(lengths, sigmas, amplitudes, prior / prior.sum(), 0.0 if field is None else field.rest_mm)

    def weighed(self, log: FloatArray) -> FloatArray:
        """Return the weights after residuals with this log likelihood, of the shape of the prior."""
        weight = self.prior * np.exp(log - log.max())
        return np.asarray(weight / weight.sum())

    def evidence(self, rows: ResidualRows) -> Evidence:
        """Return what residuals tell at each node."""
        found: list[tuple[FloatArray, ...]] = []
        for length in self.lengths_mm.tolist():
            seen, vectors = np.linalg.eigh(rows.field(length))
            smooth = (self.amplitudes_mm[:, None] ** 2) * np.maximum(seen, 0.0)
            variance = self.sigmas[:, None, None] ** 2 + self.rest_mm**2 * rows.unit2 + smooth
            y, z = vectors.T @ rows.y, vectors.T @ rows.z
            shared = None if rows.shared is None else vectors.T @ rows.shared
            (of_y, log_det), (of_z, _) = (solve_shared(variance, shared, each) for each in (y, z))
            square, size, weight = (np.sum(a * b, axis=-1) for a, b in ((of_y, y), (of_y, z), (of_z, z)))
            found.append((log_det, square, size / np.maximum(weight, np.finfo(float).tiny), weight))
        return Evidence(*(np.stack(each) for each in zip(*found, strict=True)))


def solve_shared(variance: FloatArray, shared: FloatArray | None, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Divide y, shape (m,), by covariances, and return their log determinants.

    `variance`: shape (..., m). Of independent errors. `shared`: shape (m, s). One standard deviation of shared ones.
    """
    log_det = np.log(variance).sum(axis=-1)
    if shared is None:
        return np.asarray(y / variance), log_det
    scaled = shared / variance[..., None]
    added = np.eye(shared.shape[1]) + shared.T @ scaled  # Woodbury: the shared errors are of low rank
    less = scaled @ np.linalg.solve(added, (y @ scaled)[..., None])
    return np.asarray(y / variance - less[..., 0]), log_det + np.linalg.slogdet(added)[1]


@dataclass(frozen=True, slots=True, eq=False)
class Evidence:
    """What residuals tell at each node of `Nodes`."""

    log_det: FloatArray  #: Of their covariance, without a scale.
    square: FloatArray  #: Their normalised sum of squares, without a scale.
    size: FloatArray  #: The scale that fits best.
    weight: FloatArray  #: The inverse of its variance.

    @property
    def log(self) -> FloatArray:
        """Log restricted likelihood. A scale counts as errors here: what is believed of these is then not too small."""
        return np.asarray(-0.5 * (self.log_det + self.square))

    def left(self, share: FloatArray | float) -> FloatArray:
        """Return the normalised sum of squares without a share of the fitted scale, of the shape of `size` or one."""
        return np.asarray(self.square - share * self.size**2 * self.weight)

    @property
    def scale(self) -> tuple[FloatArray, FloatArray]:
        """Return how much of the fitted scale is believed, and the mean square of the scale, after the residuals."""
        weight, size2 = self.weight[..., None], self.size[..., None] ** 2
        share = weight / (weight + SCALES**-2)
        log = 0.5 * (np.log1p(-share) + share * weight * size2) + np.log(SCALE_WEIGHTS)
        p = np.exp(log - log.max(axis=-1, keepdims=True))
        p /= p.sum(axis=-1, keepdims=True)
        return np.sum(p * share, axis=-1), np.sum(p * (share**2 * size2 + (1.0 - share) * SCALES**2), axis=-1)


@lru_cache(maxsize=8)
def evidence_of(rows: ResidualRows, s: float | None, field: RobotField | None) -> tuple[Nodes, Evidence]:
    """Lay out what may be, and what residuals tell there: as `believe`."""
    nodes = Nodes.of(rows, s, field)
    return nodes, nodes.evidence(rows)


@lru_cache(maxsize=8)
def believe(rows: ResidualRows | None, s: float | None, field: RobotField | None) -> Belief:
    """Weigh teaching errors, amplitudes and lengths by their priors and the residuals.

    `rows`: None before anything was touched.
    `s`: The factor that is known, or None.
    """
    nodes = Nodes.of(rows, s, field)
    weight, chance, scale2 = nodes.prior, 1.0, PRIOR_SCALE**2
    origin = FieldOrigin.ASSUMED if field is None else field.origin
    if rows is not None and len(rows.y):
        found = evidence_of(rows, s, field)[1]
        share, after = found.scale
        tail = chdtrc(len(rows.y), found.left(share))
        usual = nodes.prior * (nodes.amplitudes_mm <= max(2.0 * TYPICAL_AMPLITUDE_MM, nodes.amplitudes_mm.min()))
        chance = 1.0 if s is None else float(np.sum(usual * tail) / np.sum(usual))
        weight = nodes.weighed(found.log)
        scale2 = float(np.sum(weight * after))
        if field is None and len(rows.y) >= LEAST_ESTIMATED:
            origin = FieldOrigin.ESTIMATED
    s2, a2 = nodes.sigmas[None, :, None] ** 2, nodes.amplitudes_mm[None, None, :] ** 2
    of_field, square, both = (np.sum(weight * value, axis=(1, 2)) for value in (a2, a2**2, s2 * a2))
    known = float(np.sum(weight * s2)), float(np.sum(weight * s2**2))
    moments = (*known, nodes.lengths_mm, of_field, square, both)
    return Belief(*moments, chance, origin, rows, nodes.rest_mm, math.sqrt(scale2))


def foresee(rows: ResidualRows, s: float, field: RobotField | None) -> Belief:
    """Return what is believed before the touches of these rows are made, with what they will tell of the scale.

    `rows`: With residuals of zero: a part that has the size of its model is expected.
    """
    nodes, found = evidence_of(rows, s, field)
    return replace(believe(None, s, field), scale=math.sqrt(float(np.sum(nodes.prior * found.scale[1]))))


def believed_freedom(mean: FloatArray, scatter: FloatArray) -> FloatArray:
    """Degrees of freedom ν of variances that are believed with this mean and variance: 4 + 2 mean² / scatter.

    `mean`, `scatter`: shape (k,), or of a number.

    A variance that n independent residuals of one size tell has an inverse χ² distribution with ν = n. Errors are then
    distributed as Student's t with ν degrees of freedom and the square scale (1 − 2/ν) mean (`scale_of`).
    """
    ratio = 4.0 + 2.0 * mean**2 / np.maximum(scatter, mean**2 / FIRM + np.finfo(float).tiny)
    return np.asarray(np.where(ratio > FIRM, np.inf, ratio))


def scale_of(freedom: FloatArray) -> FloatArray:
    """Ratio of the square scale of the t distribution to the mean of the variance; `freedom` has the shape (k,)."""
    return np.asarray(1.0 - 2.0 / freedom)


FIRM = 1e3  #: More degrees of freedom than this are infinite.
LEAST_ESTIMATED = 12  #: Residual numbers from which a field counts as estimated: six points.


def _sigma_nodes(rows: ResidualRows | None) -> tuple[FloatArray, FloatArray]:
    """Return teaching errors of a grid that holds the residuals and the usual one, and their log prior."""
    seen = USUAL_SIGMA_MM if rows is None or not len(rows.y) else float(np.sqrt(np.mean(rows.y**2)))
    low = max(RESOLUTION_SIGMA_MM, min(seen, USUAL_SIGMA_MM) / 4.0)
    nodes = np.geomspace(low, max(4.0 * USUAL_SIGMA_MM, 4.0 * seen, 2.0 * low), SIGMA_NODES)
    return nodes, -0.5 * (np.log(nodes / USUAL_SIGMA_MM) / math.log(SIGMA_FACTOR)) ** 2
