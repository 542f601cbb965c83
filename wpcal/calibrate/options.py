"""How points are fitted and judged: the options of `wpcal fit`, `calibrate` and `pick`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.calibrate.solver_report import Solver
from wpcal.calibrate.trust.criteria import Criterion
from wpcal.core.options import opt

if TYPE_CHECKING:
    from wpcal.calibrate.observe.touches import Touches
    from wpcal.core.arrays import FloatArray
    from wpcal.core.pairs import PointPairs
    from wpcal.core.transform import RigidTransform
    from wpcal.optim.annealing import AnnealingSchedule

TOLERANCE_MM = 0.5  #: Allowed error, mm: what a fillet weld of common size takes without seam tracking.


@dataclass(frozen=True, slots=True, kw_only=True)
class FitOptions:
    """How points are fitted and judged."""

    tolerance_mm: float = opt(
        TOLERANCE_MM, "Allowed error: the verdict compares with it, and larger errors end with code 1."
    )
    criterion: Criterion | None = opt(
        None,
        "What is minimised: the largest distance (the published criterion), the sum of squares, the sum of squares "
        "weighted by the stated errors of the points, or the sum of squares over the points that agree.  [default: "
        "what predicts the least error of the seams]",
    )
    solver: Solver = opt(
        Solver.ANNEALING,
        "Where the search for minimax begins: at the result of simulated annealing (as published), or at the "
        "least-squares fit (faster). Both are then refined.",
    )
    seed: int = opt(0, "Seed of all random numbers.", least=0)
    teaching: TeachingError = field(default_factory=TeachingError)
    certify: bool = opt(False, "Close the gap to the lower bound by branch and bound (slow).")


@dataclass(frozen=True, slots=True, eq=False)
class Known:
    """What is known besides the fitted observations; see `wpcal.calibrate.run.calibrate`."""

    check: PointPairs | Touches | None
    T_nominal_part: RigidTransform | None
    nominal: RigidTransform  #: The identity where no place is given.
    schedule: AnnealingSchedule | None
    seam_points: FloatArray | None
    features: Mapping[str, FloatArray]
    postures: Mapping[str, FloatArray]
