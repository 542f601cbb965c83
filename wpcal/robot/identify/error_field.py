r"""How smooth the errors of held-out poses are: what `wpcal calibrate --robot-mm` takes of an identified arm.

Errors of an arm at near poses are alike. They are taken as a Gaussian process with the covariance
:math:`a^2 \exp(-d^2 / 2 l^2)` at a distance d, and an independent rest; a, l and the rest have the largest likelihood
of the errors without their mean (the same model as `wpcal.calibrate.errors.robot_field`).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray

LENGTHS_MM = np.geomspace(100.0, 2000.0, 14)
RATIOS = np.concatenate([[0.0], np.geomspace(0.05, 50.0, 25)])  #: Variance of the smooth errors over that of the rest.
MOST_POSES = 300  #: Of more poses this many are taken; more hardly say more about smooth errors.
LEAST_POSES = 8  #: Fewer poses tell no length.


@dataclass(frozen=True, slots=True)
class ErrorField:
    """Smooth errors of an arm and the rest, standard deviations per axis."""

    amplitude_mm: float
    length_mm: float
    rest_mm: float

    def to_record(self) -> dict[str, float]:
        """Return plain values for a JSON file."""
        return {"amplitude_mm": self.amplitude_mm, "length_mm": self.length_mm, "rest_mm": self.rest_mm}


def error_field(places: FloatArray, errors_mm: FloatArray) -> ErrorField | None:
    """Fit the model to position errors; None of fewer than `LEAST_POSES`.

    `places`, `errors_mm`: shape (n, 3). Of held-out poses, mm.
    """
    if len(places) > MOST_POSES:
        used = np.random.default_rng(0).choice(len(places), MOST_POSES, replace=False)
        places, errors_mm = places[used], errors_mm[used]
    n = len(places)
    if n < LEAST_POSES:
        return None
    Q = np.linalg.qr(np.ones((n, 1)), mode="complete")[0][:, 1:]
    y = Q.T @ errors_mm
    squares = np.sum((places[:, None] - places[None]) ** 2, axis=-1)
    best, found = -np.inf, ErrorField(0.0, 1.0, 0.0)
    for length in LENGTHS_MM.tolist():
        values, vectors = np.linalg.eigh(Q.T @ np.exp(-squares / (2.0 * length**2)) @ Q)
        seen = np.sum((vectors.T @ y) ** 2, axis=1)
        variance = 1.0 + RATIOS[:, None] * np.maximum(values, 0.0)
        scale = np.sum(seen / variance, axis=1) / (3.0 * (n - 1))
        log = -1.5 * np.sum(np.log(variance), axis=1) - 1.5 * (n - 1) * np.log(np.maximum(scale, 1e-300))
        k = int(np.argmax(log))
        if log[k] > best:
            rest = float(np.sqrt(scale[k]))
            best, found = float(log[k]), ErrorField(rest * float(np.sqrt(RATIOS[k])), length, rest)
    return found
