r"""A part that is larger than its model: the scale that a temperature or the touches tell, applied to the seams.

A real part is :math:`1 + \varepsilon` times as large as its model. What the robot touched is divided by this factor and
fitted; positions of the answer are then multiplied by it: ``p_base = T_base_part @ (1 + ε) p_model``.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, TypeVar

from scipy.special import ndtri

from wpcal.calibrate.errors.prediction import COVERAGE, TeachingError
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.result import CalibrationResult
from wpcal.calibrate.trust.scale import LEAST_POINTS, ScaleFit
from wpcal.core.errors import InputError
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs
from wpcal.core.transform import RigidTransform

REFERENCE_CELSIUS = 20.0  #: The temperature at which a model has its size (ISO 1).
APPLIED = "scale-applied"  #: Code of the issue that the seams are those of a larger or smaller part.
Observed = TypeVar(
    "Observed", PointPairs, Touches, PointPairs | Touches, PointPairs | None, PointPairs | Touches | None
)


@dataclass(frozen=True, slots=True)
class PartSize:
    """How large the part is against its model."""

    scale: float = 0.0  #: Relative: 5e-4 is 0.5 mm per metre.
    told: str = ""  #: How it is known, in words; empty where nothing is applied.
    fitted: ScaleFit | None = None  #: What the touches told of it, if it was fitted.

    @classmethod
    def stated(cls, celsius: float | None, expansion_per_k: float) -> PartSize:
        """Return the size at a temperature; that of the model without one."""
        if celsius is None:
            return cls()
        told = f"{celsius:g} °C, {1e6 * expansion_per_k:.3g} ppm per K"
        return cls(expansion_per_k * (celsius - REFERENCE_CELSIUS), told)

    def freed(self, found: ScaleFit | None) -> PartSize:
        """Return the size with what the touches told beside it; `InputError` when they are too few."""
        if found is None:
            raise InputError(f"a free scale needs at least {LEAST_POINTS} observations that are fitted")
        before = f"{self.told}, and then " if self.told else ""
        told = f"{before}fitted to the touches, ± {1e3 * found.error_95:.2f} mm per metre"
        return PartSize((1.0 + self.scale) * (1.0 + found.scale) - 1.0, told, found)

    @property
    def issue(self) -> Issue:
        """What was applied, and where."""
        size = f"{1e3 * abs(self.scale):.2f} mm per metre {'larger' if self.scale > 0 else 'smaller'}"
        what = f"the seams are those of a part that is {size} than its model ({self.told})"
        return Issue(APPLIED, f"{what}; a moved STEP file keeps the size of the model")

    def teaching(self, stated: TeachingError) -> TeachingError:
        """Return what is known of errors, with that of a fitted scale."""
        if self.fitted is None:
            return stated
        return replace(stated, scale_error=self.fitted.error_95 / float(ndtri((1.0 + COVERAGE) / 2.0)))

    def of_model(self, observed: Observed) -> Observed:
        """Return observations of a part that has the size of its model."""
        f = 1.0 + self.scale
        if observed is None or not self.scale:
            return observed
        if isinstance(observed, PointPairs):
            return replace(observed, p_target=observed.p_target / f)
        return replace(observed, p_base=observed.p_base / f, radius_mm=observed.radius_mm / f)

    def of_part(self, found: CalibrationResult) -> CalibrationResult:
        """Return a calibration in the size of the part."""
        if not self.told:
            return found
        f, T = 1.0 + self.scale, found.T_base_part
        T = RigidTransform(T.R, f * T.t_mm, T.target, T.source)
        return replace(
            found,
            pairs=self._larger(found.pairs),
            check=None if found.check is None else self._larger(found.check),
            T_base_part=T,
            T_base_nominal=T @ found.T_nominal_part.inverse(),
            budget=replace(found.budget, centre=f * found.budget.centre),
            seams=tuple((name, f * points) for name, points in found.seams),
            scale=self.fitted or found.scale,
            size=self,
            issues=(self.issue, *found.issues),
        )

    def _larger(self, pairs: PointPairs) -> PointPairs:
        f = 1.0 + self.scale
        return replace(pairs, p_source=f * pairs.p_source, p_target=f * pairs.p_target)

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return {"scale": self.scale, "source": self.told}
