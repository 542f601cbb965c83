r"""Is the tool centre point of the controller the tip? Touches in several postures of the tool tell.

If the controller's point lies beside the tip by a vector b that is fixed in the tool, every shown point is off by
:math:`R_i b`, with the posture :math:`R_i` of the tool at touch i. In one posture that is a shift of the whole part,
which leaves no residual. In several postures it does:

.. math:: r_i = J_i \xi + R_i b + e_i.

b is estimated together with the small motion of the part, and tested against zero, or against what is stated of it (F
test; :math:`\chi^2` where the teaching error is stated). A single wrong touch takes as many numbers as b. The two
explanations are therefore compared by their likelihood.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.special import chdtrc, chdtri, fdtrc, fdtri

from wpcal.calibrate.trust.residuals import FALSE_ALARM, FLOOR_MM, NAMED_PROBABILITY
from wpcal.core.arrays import FloatArray

TOOL_OFFSET = "tool-centre-point"  #: Code of the issue that the tool centre point of the controller is not at the tip.
LEAST_SEEN = 0.1
"""A direction in the tool is seen if b along it leaves this share of itself in the residuals: postures that differ by
about 6 degrees or more."""
LEAST_ROWS = 4  #: Three points leave three numbers, as many as b has.


@dataclass(frozen=True, slots=True, eq=False)
class PosedRows:
    """Residuals of the best fit at touches whose posture is known."""

    residuals: FloatArray  #: shape (n, 3). In the base, mm.
    jacobians: FloatArray  #: shape (n, 3, 6). Their derivative by comparable coordinates of the motion of the part.
    #: shape (n, 3, 3). The axes of the tool in the base, as columns, projected on the directions that each touch
    #: constrains.
    postures: FloatArray
    information: FloatArray  #: shape (n, 3, 3). Inverse covariances, mm⁻²; of unit size if no error is stated.
    numbers: int  #: How many numbers were observed: 3 at a point, 1 on a face.
    is_scaled: bool  #: Whether the information is known with its size.
    #: shape (3, 3). What is stated of b, as of the stick-out of the wire, in the axes of the tool, mm².
    stated: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))


@dataclass(frozen=True, slots=True, eq=False)
class ToolOffset:
    """The tip beside the tool centre point that the controller holds."""

    #: shape (3,). From the controller's tool centre point to the tip, along the axes of the tool, mm. Directions that
    #: the postures do not show are 0.
    tip_mm: FloatArray
    covariance: FloatArray  #: shape (3, 3). mm².
    chance: float  #: Probability that touches with a right tool centre point leave such residuals.
    probability: float  #: That the tool is wrong, and not single touches; both were equally likely before.
    is_complete: bool  #: Whether the postures show all three directions.
    degrees_of_freedom: float  #: Behind the scale of the covariance; infinite if the teaching error is stated.

    @property
    def size_mm(self) -> float:
        """Distance of the tip from the controller's tool centre point, mm."""
        return float(np.linalg.norm(self.tip_mm))

    @property
    def error_95_mm(self) -> float:
        """Length that the error of `tip_mm` stays below with about 95 % probability, mm."""
        f = self.degrees_of_freedom
        square = float(chdtri(3.0, 0.05)) / 3.0 if math.isinf(f) else float(fdtri(3.0, f, 0.95))
        return math.sqrt(float(np.trace(self.covariance)) * square)

    @property
    def bound_mm(self) -> float:
        """The tip lies at most this far away, with about 95 % probability, mm."""
        return self.size_mm + self.error_95_mm

    @property
    def sentence(self) -> str:
        """What was found and what to do."""
        x, y, z = (f"{v:+.2f}" for v in self.tip_mm)
        least = "" if self.is_complete else "at least "
        chance = "below 0.0001" if self.chance < 1e-4 else f"{self.chance:.1g}"
        return (
            f"the tip is {least}{self.size_mm:.2g} ± {self.error_95_mm:.2g} mm beside the tool centre point of the "
            f"controller (x {x}, y {y}, z {z} mm in the tool's frame; probability {100 * self.probability:.0f} %, by "
            f"chance {chance}): calibrate the tool (wpcal tcp) and touch again"
        )

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {
            "tip_mm": self.tip_mm.tolist(),
            "covariance_mm2": self.covariance.tolist(),
            "error_95_mm": self.error_95_mm,
            "chance": self.chance,
            "probability": self.probability,
            "is_complete": self.is_complete,
            "sentence": self.sentence,
        }


def find_tool_offset(rows: PosedRows, *, rival_squares: float | None = None, rival_count: int = 1) -> ToolOffset | None:
    """Estimate the offset of the tool, and test whether there is one.

    `rival_squares`: Least sum of squares that remains without `rival_count` touches, in the unit of the rows: the other
    explanation.

    Returns: None if the postures do not differ, the touches agree with a right tool, or wrong touches explain them
    better.
    """
    n, freedom = len(rows.residuals), rows.numbers - 6
    if n < LEAST_ROWS:
        return None
    r, B, C = _whitened(rows)
    Q = np.linalg.svd(B / np.maximum(np.linalg.norm(B, axis=0), 1e-300), full_matrices=False)[0]
    seen = C - Q @ (Q.T @ C)
    U, S, Vt = np.linalg.svd(seen, full_matrices=False)
    k = int(np.count_nonzero(LEAST_SEEN * np.linalg.norm(C) / math.sqrt(3.0) <= S))
    left = freedom - k
    if k == 0 or left < 1:
        return None
    r = r - Q @ (Q.T @ r)
    along = U[:, :k].T @ r
    total, drop = float(r @ r), float(along @ along)
    rest = max(total - drop, 0.0)
    floor = left * float(np.trace(rows.information, axis1=1, axis2=2).mean()) / 3.0 * FLOOR_MM**2
    unit = 1.0 if rows.is_scaled else (rest + floor) / left
    shown = S[:k, None] * Vt[:k]
    unexpected = float(along @ np.linalg.solve(unit * np.eye(k) + shown @ rows.stated @ shown.T, along))
    chance = float(chdtrc(k, unexpected) if rows.is_scaled else fdtrc(k, left, unexpected / k))
    b = Vt[:k].T @ (along / S[:k])
    if chance >= FALSE_ALARM or np.linalg.norm(b) <= FLOOR_MM:
        return None
    probability = 1.0
    if rival_squares is not None:
        probability = _share(rows, rest + floor, k, rival_squares + floor, rival_count)
    if probability < NAMED_PROBABILITY:
        return None
    scale = 1.0 if rows.is_scaled else rest / left
    covariance = scale * (Vt[:k].T / S[:k] ** 2) @ Vt[:k]
    return ToolOffset(-b, covariance, chance, probability, k == 3, math.inf if rows.is_scaled else float(left))


def _whitened(rows: PosedRows) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Residuals, derivatives by the motion and by b, in units of their errors: shapes (3 n,), (3 n, 6), (3 n, 3)."""
    values, vectors = np.linalg.eigh(rows.information)
    root = np.sqrt(np.maximum(values, 0.0))[:, :, None] * vectors.transpose(0, 2, 1)
    return (
        np.einsum("nij,nj->ni", root, rows.residuals).reshape(-1),
        (root @ rows.jacobians).reshape(-1, 6),
        (root @ rows.postures).reshape(-1, 3),
    )


def _share(rows: PosedRows, mine: float, k: int, other: float, count: int) -> float:
    """Probability of the tool against wrong touches, by the Bayesian information criterion (Schwarz 1978).

    Each of the sets of as many touches was as likely before, all of them together as likely as the tool.
    """
    n = len(rows.residuals)
    if rows.is_scaled:
        gain = 0.5 * (other - mine)
    else:
        left = max(rows.numbers - 6 - max(3 * count, k), 1)
        gain = 0.5 * left * math.log(max(other, 1e-300) / max(mine, 1e-300))
    gain += 0.5 * (3 * count - k) * math.log(rows.numbers) + math.log(math.comb(n, count))
    return 1.0 / (1.0 + math.exp(-min(max(gain, -700.0), 700.0)))
