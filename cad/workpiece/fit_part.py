"""The fit of a part to its taught rows, as the main job and the picker make it: as one body or several, in its size."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from cad.workpiece.fit_taught import CalibrateOptions, Observed, ScaleChoice, next_points, run_fit
from cad.workpiece.workpiece import Workpiece
from wpcal.calibrate import CalibrationResult, Criterion
from wpcal.calibrate.errors.field_shift import FieldShift
from wpcal.calibrate.size import PartSize
from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform
from wpcal.seam import Seam

if TYPE_CHECKING:
    from cad.workpiece.moved_bodies import MovedWorkpiece


@dataclass(frozen=True, slots=True, eq=False)
class FittedPart:
    """A part where it is, and its seams there."""

    result: CalibrationResult
    u95_mm: tuple[FloatArray, ...]  #: shape (frames,). 95 % error at every frame of each seam, mm.
    seams: tuple[Seam, ...]  #: In `part`.
    moved: MovedWorkpiece | None = None  #: The motions of the bodies, if they were fitted.

    def sized(self, size: PartSize) -> FittedPart:
        """Return the part in its size."""
        if not size.told:
            return self
        result, moved = size.of_part(self.result), self.moved
        if moved is not None:
            own = tuple(replace(each, seam=_sized_seam(each.seam, 1.0 + size.scale)) for each in moved.seams)
            moved = replace(moved, result=result, seams=own)
        return FittedPart(result, self.u95_mm, tuple(_sized_seam(seam, 1.0 + size.scale) for seam in self.seams), moved)


def fit_part(
    workpiece: Workpiece,
    observed: Observed,
    seams: Sequence[Seam],
    options: CalibrateOptions,
    *,
    T_nominal_part: RigidTransform | None = None,
) -> FittedPart:
    """Fit what was observed; `workpiece`: with the curves on which its seams lie."""

    def fitted(size: PartSize) -> FittedPart:
        asked, own = replace(options, teaching=size.teaching(options.teaching)), observed.of_model(size)
        suggest = partial(
            next_points, taught=observed.taught, workpiece=workpiece, seams=seams, teaching=options.teaching
        )
        result, u95 = run_fit(own, seams, options=asked, T_nominal_part=T_nominal_part, suggest=suggest)
        if options.bodies is None:
            return FittedPart(result, u95, tuple(seams)) if options.rigid else _following(result, u95, seams)
        from cad.workpiece.moved_bodies import fit_weldment

        moved = fit_weldment(workpiece, own, result, seams, asked, options.bodies)
        return FittedPart(moved.result, moved.u95_mm, moved.told_seams(), moved)

    size = PartSize.stated(options.part_celsius, options.expansion_per_k)
    found = fitted(size)
    if options.scale is ScaleChoice.FREE:
        size = size.freed(found.result.scale)
        found = fitted(size)
    return found.sized(size)


def _following(result: CalibrationResult, u95: tuple[FloatArray, ...], seams: Sequence[Seam]) -> FittedPart:
    """Move the seams for the robot's own error, where the touches tell of one and none of them may be wrong.

    Minimax is the paper's rigid fit.
    """
    T, shift, is_doubted = result.T_base_part, None, bool(result.suspect or result.distrusted)
    if seams and not is_doubted and result.criterion is not Criterion.MINIMAX:
        shift = FieldShift.of(result.budget, result.teaching.robot)
    if shift is None:
        return FittedPart(result, u95, tuple(seams))
    moved = [shift.at(T.apply(seam.frames.p)) for seam in seams]
    most = max(float(np.linalg.norm(each, axis=1).max()) for each in moved)
    result = replace(result, field_shift=shift, issues=(*result.issues, shift.issue(most)))
    frames = [replace(seam.frames, p=seam.frames.p + by @ T.R) for seam, by in zip(seams, moved, strict=True)]
    return FittedPart(result, u95, tuple(replace(seam, frames=own) for seam, own in zip(seams, frames, strict=True)))


def _sized_seam(seam: Seam, factor: float) -> Seam:
    frames = replace(seam.frames, s_mm=factor * seam.frames.s_mm, p=factor * seam.frames.p)
    return replace(seam, frames=frames, length_mm=factor * seam.length_mm)
