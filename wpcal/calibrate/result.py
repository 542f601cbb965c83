"""`CalibrationResult`: the pose of the part, how good the fit is and could be, and the error that a weld will see."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from wpcal.calibrate.errors.budget import ErrorBudget
from wpcal.calibrate.errors.prediction import Sigma, TeachingError
from wpcal.calibrate.solve.minimax import CERTIFIED_MM
from wpcal.calibrate.solver_report import SolverReport
from wpcal.calibrate.trust.blame import Suspect
from wpcal.calibrate.trust.criteria import CriteriaComparison, Criterion
from wpcal.calibrate.trust.scale import ScaleFit
from wpcal.calibrate.trust.tool_offset import ToolOffset
from wpcal.calibrate.trust.touch_evidence import TouchEvidence
from wpcal.calibrate.trust.verdict import Verdict, VerdictKind
from wpcal.calibrate.trust.without import Distrusted
from wpcal.core.arrays import FloatArray, as_points, frozen
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs, Residuals
from wpcal.core.pendant import NOTATIONS
from wpcal.core.result_files import CALIBRATION_SCHEMA
from wpcal.core.rotations import rx_ry_rz_deg
from wpcal.core.transform import RigidTransform

if TYPE_CHECKING:
    from wpcal.calibrate.errors.field_shift import FieldShift
    from wpcal.calibrate.size import PartSize


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class CalibrationResult:
    """The answer of `calibrate`."""

    #: `pairs`, `check`: What was fitted, and what tests the fit without being fitted.
    pairs: PointPairs
    check: PointPairs | None
    #: `T_base_part`, `T_nominal_part`, `T_base_nominal`: The result, where the model has the part, and the correction:
    #: ``T_base_part = T_base_nominal @ T_nominal_part``.
    T_base_part: RigidTransform
    T_nominal_part: RigidTransform
    T_base_nominal: RigidTransform
    criterion: Criterion
    objective_mm: float  #: What the criterion minimises: the largest distance (minimax) or a root mean square.
    lower_bound_mm: float  #: No rigid transform has a smaller objective.
    #: shape (6, 6). Of the small motion ξ = (ω, v) of the part **about the origin of the base**, as in
    #: `wpcal.core.tangent`: ``T_true = exp(ξ) T_base_part``; rad², rad·mm, mm².
    covariance: FloatArray
    sigma: Sigma  #: The teaching error behind the covariance, and how it is known.
    budget: ErrorBudget  #: The contributions to every predicted error.
    #: Points of each accepted seam in `part`, mm, by its name; fitted points by an empty name; none if bodies moved.
    seams: tuple[tuple[str, FloatArray], ...]
    teaching: TeachingError  #: What was stated.
    judgement: Verdict  #: Whether the seams are shown to be within the tolerance, as a sentence.
    solver: SolverReport
    criteria: CriteriaComparison | None  #: None for very large clouds.
    #: What is wrong with the observations, what they cannot show, and what exceeds the tolerance.
    issues: tuple[Issue, ...]
    tolerance_mm: float
    versions: dict[str, str]  #: wpcal, numpy, scipy.
    #: The points that the others contradict, and the answer with and without them.
    distrusted: Distrusted | None = None
    suspect: Suspect | None = None  #: The observations that are wrong, as far as the data tell, with their probability.
    #: How far the tip is from the tool centre point of the controller, if the postures of the touches show it.
    tool: ToolOffset | None = None
    size: PartSize | None = None  #: How large the part is against its model, where this was stated or asked for.
    field_shift: FieldShift | None = None  #: By how much the seams follow the robot's own error, if they do.
    scale: ScaleFit | None = None  #: How much larger the part is than its model. None of fewer than five observations.
    #: What only touches on faces and edges have; their lower bound is zero. None for points.
    touches: TouchEvidence | None = None
    #: Which other criterion to take, and what it would give. None if minimax is as good, or was not asked for.
    criterion_advice: str | None = None
    #: shape (n,). 95 % errors of the fitted points, then of the check points, where bodies of the part moved: the
    #: covariance does not give them then.
    known_errors_mm: FloatArray | None = None
    #: shape (3, 3). The axes of the tool in the base, by the names of the points that say them.
    postures: Mapping[str, FloatArray] = field(default_factory=dict)

    def __repr__(self) -> str:
        return f"CalibrationResult({self.verdict}: {len(self.pairs)} points, largest residual {self.largest_mm:.3f} mm)"

    @property
    def residuals(self) -> Residuals:
        """Of the fitted points, base frame."""
        return Residuals.of(self.pairs, self.T_base_part)

    @property
    def check_residuals(self) -> Residuals | None:
        """Of the check points."""
        return None if self.check is None else Residuals.of(self.check, self.T_base_part)

    @property
    def gap_mm(self) -> float:
        """Objective minus lower bound, mm."""
        return max(self.objective_mm - self.lower_bound_mm, 0.0)

    @property
    def certified(self) -> bool:
        """Whether the bound proves that no rigid transform is better by more than 1e-6 mm; of points only."""
        return self.touches is None and self.gap_mm <= CERTIFIED_MM

    @property
    def rms_mm(self) -> float:
        """Root of the mean squared distance of the fitted points, mm."""
        return self.residuals.rms_mm

    @property
    def largest_mm(self) -> float:
        """Largest distance of a fitted or a check point, mm."""
        check = self.check_residuals
        return max(self.residuals.largest_mm, 0.0 if check is None else check.largest_mm)

    @property
    def worst(self) -> str:
        """Name of the fitted or check point with the largest distance."""
        check = self.check_residuals
        if check is not None and check.largest_mm > self.residuals.largest_mm:
            return check.worst
        return self.residuals.worst

    @property
    def verdict(self) -> VerdictKind:
        """``PASS``, ``UNSURE`` or ``FAIL``; `judgement` says why."""
        return self.judgement.kind

    def predict_error_mm(self, points_part: ArrayLike) -> FloatArray:
        """Length that the error of points of the part stays below with 95 % probability, shape (k,), mm.

        `points_part`: shape (k, 3). Part frame, mm.
        """
        return self.budget.error_95_mm(self.T_base_part.apply(as_points(points_part, name="points")))

    def point_errors_mm(self, rows: Sequence[int] | None = None, *, check: bool = False) -> FloatArray:
        """Return the 95 % errors of the fitted points, or of the check points, mm, shape (k,)."""
        pairs = self.check if check else self.pairs
        count = 0 if pairs is None else len(pairs)
        at = np.arange(count) if rows is None else np.asarray(rows, dtype=np.int64)
        if pairs is None or self.known_errors_mm is None:
            return frozen(np.zeros(0)) if pairs is None else self.predict_error_mm(pairs.p_source[at])
        return frozen(self.known_errors_mm[at + (len(self.pairs) if check else 0)])

    def to_record(self) -> dict[str, Any]:
        """Return the record of ``calibration.json``, without the fields of the part's file."""
        parts = {
            "suspect": self.suspect,
            "tool_offset": self.tool,
            "scale": self.scale,
            "applied_scale": self.size,
            "field_shift": self.field_shift,
        }
        found = {key: each.to_record() for key, each in parts.items() if each is not None}
        touches = {} if self.touches is None else {"touches": self.touches.to_record(self.pairs.names)}
        return {**self._record(), **found, **touches}

    def _record(self) -> dict[str, Any]:
        return {
            "schema": CALIBRATION_SCHEMA,
            "robot_space": self.pairs.space.value,
            "verdict": self.verdict.value,
            "judgement": self.judgement.to_record(),
            "criterion_advice": self.criterion_advice,
            "tolerance_mm": self.tolerance_mm,
            "criterion": self.criterion.value,
            "objective_mm": self.objective_mm,
            "annealed_objective_mm": self.solver.annealed_objective_mm,
            "lower_bound_mm": self.lower_bound_mm,
            "gap_mm": self.gap_mm,
            "certified": self.certified,
            "rms_mm": self.rms_mm,
            "T_base_part": self.T_base_part.matrix.tolist(),
            "pendant": {notation.maker: notation.record(self.T_base_part) for notation in NOTATIONS},
            "correction": {
                "T_base_nominal": self.T_base_nominal.matrix.tolist(),
                "T_nominal_part": self.T_nominal_part.matrix.tolist(),
                "six_tuple": self.T_base_nominal.six_tuple.to_record(),
            },
            "points": self._point_records(),
            "covariance": {
                "order": ["omega_x_rad", "omega_y_rad", "omega_z_rad", "v_x_mm", "v_y_mm", "v_z_mm"],
                "about": "origin of base",
                "degrees_of_freedom": self.sigma.to_record()["degrees_of_freedom"],
                "values": self.covariance.tolist(),
            },
            "teaching_error": {
                "sigma_mm": self.teaching.sigma_mm,
                "bound_mm": self.teaching.bound_mm,
                "tcp_bias_mm": self.teaching.tcp_bias_mm,
                **({} if self.teaching.tool is None else {"tool": self.teaching.tool.to_record()}),
                **self.sigma.to_record(),
            },
            "budget": self.budget.to_record([(name, self.T_base_part.apply(p)) for name, p in self.seams]),
            "criteria": None if self.criteria is None else self.criteria.to_record(),
            "distrusted": None if self.distrusted is None else self.distrusted.to_record(),
            "issues": [issue.to_record() for issue in self.issues],
            "solver": self.solver.to_record(),
            "seed": self.solver.seed,
            "versions": self.versions,
        }

    def _point_records(self) -> list[dict[str, Any]]:
        records = []
        for pairs, use in ((self.pairs, "yes"), (self.check, "check")):
            if pairs is None:
                continue
            vectors = pairs.p_target - self.T_base_part.apply(pairs.p_source)
            errors = self.point_errors_mm(check=use == "check")
            columns = (pairs.p_source, pairs.p_target, vectors, errors)
            for name, p_part, p_base, vector, error in zip(pairs.names, *columns, strict=True):
                records.append(
                    {
                        "name": name,
                        "use": use,
                        "p_part_mm": p_part.tolist(),
                        "p_base_mm": p_base.tolist(),
                        "residual_mm": vector.tolist(),
                        "distance_mm": float(np.linalg.norm(vector)),
                        "error_95_mm": float(error),
                        **(
                            {"rx_ry_rz_deg": rx_ry_rz_deg(self.postures[name]).tolist()}
                            if name in self.postures
                            else {}
                        ),
                    }
                )
        return records
