"""The points or touches that the others contradict, and the answer with them and without them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.calibrate.trust.criteria import Criterion, CriterionFit, FitProblem, FitSummary
from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import log_rotation


@dataclass(frozen=True, slots=True)
class Distrusted:
    """Observations that the others contradict, and what leaving them out changes."""

    names: tuple[str, ...]
    off_mm: tuple[float, ...]  #: How far each of them lies from the fit of the others.
    criterion: Criterion  #: Of both fits.
    with_them: FitSummary
    without_them: FitSummary
    shift_mm: float  #: The furthest that leaving them out moves a point of the seams.
    turn_rad: float  #: The angle by which leaving them out turns the part.

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {
            "names": list(self.names),
            "off_mm": list(self.off_mm),
            "criterion": self.criterion.value,
            "with": self.with_them.to_record(),
            "without": self.without_them.to_record(),
            "shift_mm": self.shift_mm,
            "turn_rad": self.turn_rad,
        }


def compare_without(
    problem: FitProblem, names: Sequence[str], fit: CriterionFit, *, seam_points: FloatArray
) -> Distrusted:
    """Fit without observations that are distrusted, by the criterion of `fit` with them.

    `seam_points`: shape (k, 3). Part frame, mm.
    Raises `GeometryError` when the observations that remain do not fix a rotation.
    """
    used = Criterion.LEAST_SQUARES if fit.criterion is Criterion.ROBUST else fit.criterion
    out = np.array([problem.names.index(name) for name in names], dtype=np.int64)
    rest = problem.select(np.setdiff1d(np.arange(len(problem.names)), out))
    first = fit if fit.criterion is used else problem.fit(used)
    second = rest.fit(used)
    moved = second.T.apply(seam_points) - first.T.apply(seam_points)
    return Distrusted(
        tuple(names),
        tuple(float(d) for d in problem.select(out).distances_mm(second.T)),
        used,
        FitSummary.of(problem, first, seam_points),
        FitSummary.of(rest, second, seam_points),
        float(np.linalg.norm(moved, axis=1).max()),
        float(np.linalg.norm(log_rotation(second.T.R @ first.T.R.T))),
    )
