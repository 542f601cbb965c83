"""From taught rows to the fit of a part, in three steps that need no kernel.

`name_taught` finds which features the rows are, `prepare_fit` what each row lies on, and `run_fit` the pose and the
error of every seam. The main job and the picker both take these steps, so that their numbers are the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import partial

import numpy as np

from cad.workpiece.bodies import BodiesOptions
from cad.workpiece.seams import SeamChoice
from cad.workpiece.touched_bodies import bodies_touched
from cad.workpiece.workpiece import Workpiece
from wpcal.calibrate import CalibrationResult, Touches, calibrate
from wpcal.calibrate.errors.prediction import Sigma, TeachingError
from wpcal.calibrate.options import FitOptions
from wpcal.calibrate.size import PartSize
from wpcal.calibrate.trust.scale import STEEL_PER_K
from wpcal.calibrate.trust.silent import SilentSearches
from wpcal.calibrate.trust.verdict import Suggest
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import WpcalError, blamed_on
from wpcal.core.options import opt
from wpcal.core.pairs import PointPairs
from wpcal.core.progress import Progress, no_progress
from wpcal.core.transform import RigidTransform
from wpcal.seam import Seam, SeamOptions
from wpcal.taught.features import ReferenceFeature, feature_named
from wpcal.taught.match import name_points
from wpcal.taught.programs import names_as_features
from wpcal.taught.resolve import named_axes, touches_of
from wpcal.taught.table import TaughtPoints, pair_points
from wpcal.touch.advice import advise_set
from wpcal.touch.touch_results import SilentRows


class ScaleChoice(Enum):
    """Whether the scale of the part that five observations or more tell is only reported, or applied to the seams."""

    FIXED = "fixed"
    FREE = "free"


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrateOptions(FitOptions):
    """How a workpiece is calibrated."""

    ball_mm: float = opt(0.0, "Radius of the ball in touches on faces.")
    scale: ScaleChoice = opt(
        ScaleChoice.FIXED,
        "Whether the size of the part is that of its model, or fitted (five points or more) and applied to the seams.",
    )
    rigid: bool = opt(
        False, "Place the seams by the pose of the part alone, also where the touches show the robot's own error there."
    )
    part_celsius: float | None = opt(
        None,
        "Temperature of the part while it is touched and welded, °C: the seams are those of a part of 20 °C, expanded.",
        "--part-temperature",
        above=-273.15,
    )
    expansion_per_k: float = opt(
        STEEL_PER_K, "Linear expansion of the part, 1/K (aluminium: 23e-6).", "--expansion", above=0.0, most=1e-3
    )
    seams: SeamOptions = field(default_factory=SeamOptions)
    choice: SeamChoice = field(default_factory=SeamChoice)  #: What a person decided about the seams.
    bodies: BodiesOptions | None = None  #: Which bodies may have moved; None: the part is one body.


@dataclass(frozen=True, slots=True, eq=False)
class NamedPoints:
    """Taught points that all have a feature or model coordinates."""

    taught: TaughtPoints
    found_names: bool  #: Whether features were found for points without one.


def name_taught(
    given: TaughtPoints,
    features: Sequence[ReferenceFeature],
    *,
    options: CalibrateOptions,
    T_nominal_part: RigidTransform | None = None,
    progress: Progress = no_progress,
) -> NamedPoints:
    """Find the features of points without one; parameters and errors as in `wpcal.taught.match.name_points`.

    Touches on edges and faces stay as they are. Touches without a ball radius get that of the options.
    """
    if given.has_touches:
        return NamedPoints(given.with_ball(options.ball_mm), found_names=False)
    asked = names_as_features(given, features)
    with blamed_on(given.path):
        points = name_points(
            asked, features, sigma_mm=options.teaching.per_axis_mm, T_nominal_part=T_nominal_part, progress=progress
        )
    return NamedPoints(points, points is not asked)


@dataclass(frozen=True, slots=True, eq=False)
class Observed:
    """Taught rows with what each of them lies on: ready to be fitted."""

    taught: TaughtPoints  #: The rows, with their features (`name_taught`).
    fitted: PointPairs | Touches
    check: PointPairs | Touches | None  #: Rows that are not fitted; they test the fit.
    #: shape (3,). Places that can be touched as points, in `part`, mm: a suspicious point is tried on them.
    features: dict[str, FloatArray] = field(default_factory=dict)
    silent: SilentSearches | None = None  #: Searches of a touch program that found nothing.
    body_of: dict[str, str] = field(default_factory=dict)  #: The solid that each row lies on, by its name.

    def of_model(self, size: PartSize) -> Observed:
        """Return what would have been observed of a part that has the size of its model."""
        silent = self.silent
        if silent is not None:
            silent = replace(silent, ends=size.of_model(silent.ends), starts=silent.starts / (1.0 + size.scale))
        return replace(self, fitted=size.of_model(self.fitted), check=size.of_model(self.check), silent=silent)


def prepare_fit(
    taught: TaughtPoints,
    workpiece: Workpiece,
    *,
    T_nominal_part: RigidTransform | None = None,
    silent: SilentRows | None = None,
) -> Observed:
    """Find what every taught row lies on.

    Raises `FormatError` that names the row whose feature or face the part does not have.
    """
    features = workpiece.features
    if not taught.has_touches:
        places = {feature.name: feature.p_mm for feature in features if feature.kind.is_point}
        solids = {feature.name: feature.solid for feature in features}
        named = zip(taught.names, taught.features, strict=True)
        bodies = {row: solids.get(feature or row, "") for row, feature in named}
        found = pair_points(taught, features)
        return Observed(taught, *found, places, body_of=bodies)
    find = partial(touches_of, taught, workpiece.trimmed, features, T_nominal_part=T_nominal_part)
    checked = find(use="check") if "check" in taught.use else None
    fitted = replace(find(use="yes"), axes=named_axes(features))
    unmet = None
    if silent is not None:
        ends = touches_of(silent.ends, workpiece.trimmed, features, use="yes", T_nominal_part=T_nominal_part)
        unmet = SilentSearches(ends, silent.starts, silent.was_active)
    names, solid = workpiece.graph.solid_names, bodies_touched(fitted, workpiece.graph.face_solid)
    bodies = {row: names[k] for row, k in zip(fitted.names, solid.tolist(), strict=True) if k >= 0}
    return Observed(taught, fitted, checked, silent=unmet, body_of=bodies)


def next_points(
    shares: Sequence[float],
    taught: TaughtPoints,
    workpiece: Workpiece,
    seams: Sequence[Seam],
    *,
    teaching: TeachingError,
) -> tuple[str, ...]:
    """Choose the fewest features whose touch brings the predicted error of the seams to ``shares[number - 1]`` of now.

    `taught`: With their features (`name_taught`).
    Returns: Names; none if rows were touched on faces or have no feature, or no further feature helps.
    """
    used = [name for name, use in zip(taught.features, taught.use, strict=True) if use == "yes"]
    if taught.has_touches or not all(taught.features):
        return ()
    taken = {feature_named(workpiece.features, name).name for name in taught.features}
    have = [feature_named(workpiece.features, name) for name in dict.fromkeys(used)]
    free = [item for item in workpiece.judged if item.feature.kind.is_point and item.feature.name not in taken]
    try:
        chosen = advise_set(
            free,
            [seam for seam in seams if seam.accepted],
            points=len(have) + 1,
            shares=shares,
            sigma_mm=Sigma.expected(teaching.per_axis_mm).mm,
            robot=teaching.robot,
            have=have,
        )
    except WpcalError:  # no seam to advise for, or no feature that is left
        return ()
    return tuple(name for name in chosen.names if name not in taken)


def run_fit(
    observed: Observed,
    seams: Sequence[Seam],
    *,
    options: CalibrateOptions,
    T_nominal_part: RigidTransform | None = None,
    suggest: Suggest | None = None,
) -> tuple[CalibrationResult, tuple[FloatArray, ...]]:
    """Fit what was observed, and predict the error that each seam will see.

    Raises `GeometryError` or `UnitError` when the observations cannot be fitted.

    Returns `u95_mm`: shape (frames,) per seam.
    """
    accepted = [seam for seam in seams if seam.accepted]
    bias_mm = max(options.teaching.tcp_bias_mm, observed.taught.tcp_bias_mm)
    result = calibrate(
        observed.fitted,
        check=observed.check,
        criterion=options.criterion,
        solver=options.solver,
        seed=options.seed,
        tolerance_mm=options.tolerance_mm,
        T_nominal_part=T_nominal_part,
        teaching=replace(options.teaching, tcp_bias_mm=bias_mm),
        certify=options.certify,
        seam_points=np.concatenate([seam.frames.p for seam in accepted]) if accepted else None,
        seam_names=[seam.name for seam in accepted for _ in range(len(seam.frames))],
        suggest=suggest,
        features=observed.features,
        postures=observed.taught.postures,
        silent=observed.silent,
        body_of=observed.body_of,
    )
    if not seams:
        return result, ()
    u95_mm = result.predict_error_mm(np.concatenate([seam.frames.p for seam in seams]))
    ends = np.cumsum([len(seam.frames) for seam in seams])
    return result, tuple(np.split(u95_mm, ends[:-1]))
