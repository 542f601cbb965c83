"""Which features of a part to teach: reads the part and finds its seams; `wpcal.touch.advice` makes the choice."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from cad.workpiece.advise_bodies import Advisable, advise_bodies
from cad.workpiece.answer_cache import NO_CACHE, AnswerCache
from cad.workpiece.bodies import BodiesOptions
from cad.workpiece.seams import SeamChoice, find_seams
from cad.workpiece.workpiece import Openable, Workpiece, open_workpiece
from wpcal.calibrate import Criterion
from wpcal.calibrate.errors.prediction import TeachingError
from wpcal.calibrate.errors.robot_field import USUAL_SIGMA_MM, RobotField
from wpcal.core.errors import InputError
from wpcal.core.options import opt
from wpcal.core.progress import Progress, no_progress
from wpcal.core.wording import counted
from wpcal.seam import Seam, SeamOptions
from wpcal.seam.names import seams_named, split_names
from wpcal.taught.features import POINT_KINDS, FeatureKind, feature_named, judge_features
from wpcal.touch.advice import Advice, advise
from wpcal.touch.moved_advice import HowMany, MovedAdvice

USUAL_POINTS = 4  #: With three points no residual shows that one of them is wrong.


@dataclass(frozen=True, slots=True)
class AdviseOptions:
    """Which features may be advised, and for what."""

    points: int | None = opt(
        None,
        "Number of touches: points to teach, with --have; with --bodies, to add.  [default: 4; with --bodies 2 per "
        "body]",
        "--count",
    )
    tolerance_mm: float | None = opt(
        None, "Allowed error: with --bodies, as many points as keep all accepted seams within it, with 95 % confidence."
    )
    seams: tuple[str, ...] = opt(
        (),
        "Only these seams: names and ranges. The error counts there.  [default: on all accepted seams]",
        "--only",
        metavar="W1,W5-W8",
        read=split_names,
    )
    sigma_mm: float = opt(USUAL_SIGMA_MM, "Teaching error: standard deviation per axis.")
    robot: RobotField | None = opt(
        None,
        "The robot's own smooth error: as in `wpcal calibrate`.",
        "--robot-mm",
        metavar="AMPLITUDE,LENGTH|FILE",
        read=RobotField.read,
    )
    criterion: Criterion = opt(
        Criterion.LEAST_SQUARES,
        "What is minimised: the criterion that `wpcal calibrate` will get.",
        choices=(Criterion.MINIMAX, Criterion.LEAST_SQUARES),
    )
    have: tuple[str, ...] = opt((), "Features that will be taught in any case.", metavar="V1,V4", read=split_names)
    exclude: tuple[str, ...] = opt((), "Features that must not be advised.", metavar="V3,H2", read=split_names)
    near: tuple[float, float, float, float] | None = opt(
        None, "Only features within R mm of this point of the part.", "--within", metavar="X,Y,Z,R"
    )
    kinds: tuple[FeatureKind, ...] = opt(
        POINT_KINDS, "Only these kinds of features.", "--kind", many=True, choices=POINT_KINDS
    )

    def __post_init__(self) -> None:
        if self.near is not None and not self.near[3] > 0:
            raise InputError(f"--within: expected a positive radius, got {self.near[3]:g}")


USUAL, USUAL_SEAMS = AdviseOptions(), SeamOptions()


def advise_points(
    step: Openable,
    *,
    options: AdviseOptions = USUAL,
    seam_options: SeamOptions = USUAL_SEAMS,
    choice: SeamChoice | None = None,
    cache: AnswerCache = NO_CACHE,
    progress: Progress = no_progress,
) -> Advice:
    """Choose the features of a part to teach.

    Raises `InputError` when the part cannot be read, or has no feature or seam of a given name.
    Raises `GeometryError` when the part has no seam, or too few features that may be taught.
    """
    workpiece = open_workpiece(step, cache=cache, progress=progress)
    choice = choice or SeamChoice()
    make = partial(_advise, workpiece, options, seam_options, choice, progress)
    return workpiece.answer("advice", (options, seam_options, choice), make)


def advise_weldment(
    step: Openable,
    *,
    bodies: BodiesOptions,
    options: AdviseOptions = USUAL,
    seam_options: SeamOptions = USUAL_SEAMS,
    choice: SeamChoice | None = None,
    cache: AnswerCache = NO_CACHE,
    progress: Progress = no_progress,
) -> MovedAdvice:
    """Choose the features of a weldment to teach whose bodies may have moved.

    Parameters and errors are those of `advise_points`, and of `cad.workpiece.advise_bodies.advise_bodies`.
    """
    workpiece = open_workpiece(step, cache=cache, progress=progress)
    asked = _asked(workpiece, options, seam_options, choice or SeamChoice(), progress)
    progress("choosing points")
    is_said = options.points is not None or options.tolerance_mm is not None
    return advise_bodies(
        asked,
        bodies,
        teaching=TeachingError(sigma_mm=options.sigma_mm, robot=options.robot),
        seam_options=seam_options,
        how_many=HowMany(options.points, options.tolerance_mm) if is_said else None,
    )


def _asked(
    workpiece: Workpiece, options: AdviseOptions, seam_options: SeamOptions, choice: SeamChoice, progress: Progress
) -> Advisable:
    have = [feature_named(workpiece.features, name) for name in options.have]
    excluded = {feature_named(workpiece.features, name).name for name in options.exclude}
    progress(f"finding seams: {workpiece.size}")
    found, workpiece = find_seams(workpiece, seam_options, choice)
    seams = _seams_named(found, options.seams)
    progress(f"judging {counted(len(workpiece.features), 'feature')}")
    *place, radius = (0.0, 0.0, 0.0, math.inf) if options.near is None else options.near
    allowed = [
        item
        for item in judge_features(workpiece.graph, workpiece.features)
        if item.feature.name not in excluded and item.feature.kind in options.kinds
        if np.linalg.norm(item.feature.p_mm - place) <= radius
    ]
    return Advisable(workpiece, seams, allowed, have)


def _advise(
    workpiece: Workpiece, options: AdviseOptions, seam_options: SeamOptions, choice: SeamChoice, progress: Progress
) -> Advice:
    asked = _asked(workpiece, options, seam_options, choice, progress)
    advised = advise(
        asked.allowed,
        asked.seams,
        points=USUAL_POINTS if options.points is None else options.points,
        sigma_mm=options.sigma_mm,
        robot=options.robot,
        criterion=options.criterion,
        have=asked.have,
        progress=progress,
    )
    return replace(advised, notes=(*advised.notes, *(issue.message for issue in asked.workpiece.issues)))


def _seams_named(seams: Sequence[Seam], names: Sequence[str]) -> list[Seam]:
    if not names:
        return [seam for seam in seams if seam.accepted]
    by_name = {seam.name: seam for seam in seams}
    return [by_name[name] for name in seams_named(names, list(by_name))]
