"""What wpcal tells the page about rows: their fit, the rows of a file, which features to touch next."""

from __future__ import annotations

import threading
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from cad.session.part import PickPart
from cad.session.rows import Rows, read_rows
from cad.session.touches import planned_touches, predict_touches, touch_on_face
from cad.workpiece.advise_bodies import Advisable, advise_bodies
from cad.workpiece.bodies import BodiesOptions, BodyGroup, find_bodies
from cad.workpiece.fit_part import fit_part
from cad.workpiece.fit_taught import CalibrateOptions, name_taught, prepare_fit
from cad.workpiece.moved_record import bodies_record
from cad.workpiece.moving import MovingChoice
from wpcal.calibrate import CalibrationResult, Criterion
from wpcal.calibrate.errors.prediction import Sigma, TeachingError
from wpcal.controllers.taught_program import is_program, parse_program
from wpcal.controllers.user_frames import ProgramReading, parse_uframes, points_in_base, usable_points
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError, WpcalError
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import printable
from wpcal.results.next_steps import next_steps
from wpcal.seam import Seam
from wpcal.taught.features import ReferenceFeature, feature_named
from wpcal.taught.programs import names_as_features
from wpcal.taught.table import TaughtPoints, taught_csv
from wpcal.touch.advice import advise_set
from wpcal.touch.moved_advice import HowMany

FIRST_LINE = 2  #: Line of the first complete row in the text of `Rows.to_csv`; the header is line 1.
FIRST_POINTS = 4
"""As many points or touches are suggested at first, then one at a time. With three points, the residuals cannot show
that one of them is wrong; four touches hold the whole part."""
SAME_MM = 1e-3  #: A feature this near to a touched point of the model is that point.
ERROR_DIGITS = 6  #: The page shows predicted errors with 3 decimals of a millimetre.


@dataclass(slots=True, eq=False)
class PickSession:
    """One part with the options of its fit."""

    part: PickPart
    options: CalibrateOptions = field(default_factory=CalibrateOptions)
    T_nominal_part: RigidTransform | None = None
    #: Which points of robot programs to read, and how they come into the base frame.
    program: ProgramReading = field(default_factory=ProgramReading)
    seams_revision: int = 1  #: Counts the changes of the seams.
    moving: MovingChoice = field(default_factory=MovingChoice)  #: Whether bodies may have moved.
    groups: tuple[BodyGroup, ...] = ()  #: Bodies of several solids, or with a tack tolerance of their own.
    _busy: threading.Lock = field(default_factory=threading.Lock)

    def choose(self, moving: MovingChoice) -> None:
        """Let bodies have moved from now on, or not. Raises `InputError` when the part is one body."""
        with self._busy:
            choice = moving.to_options(self.groups)
            if choice is not None:
                find_bodies(self.part.workpiece.trimmed, choice)
            self.moving = moving

    def use_seams(self, seams: tuple[Seam, ...]) -> None:
        """Predict errors at these seams from now on."""
        with self._busy:
            self.part = replace(self.part, seams=seams)
            self.seams_revision += 1

    def use_part(self, part: PickPart) -> None:
        """Take the same part with seams that were found anew."""
        with self._busy:
            self.part = part
            self.seams_revision += 1

    def fit(self, rows: Rows) -> dict[str, Any]:
        """Fit the complete rows exactly as `wpcal calibrate` fits the saved file.

        Raises `WpcalError` as in `wpcal calibrate`. `FormatError.line` is 2 for the first complete row.

        Returns: ``T_base_part``, ``verdict``, ``judgement``, ``criterion_advice`` and ``points`` as in
        ``calibration.json``; every point also has its ``row`` and ``residual_part_mm``. ``u95_mm`` of every seam's
        frames; ``features`` by row; ``notes``; ``again``: rows that do not fit the others; ``seams_revision``: which
        seams these are; ``exchanges``: rows that fit
        if they were touched on another feature. ``moving``: whether bodies may have moved, and then ``bodies`` as in
        ``calibration.json``.
        """
        with self._busy:
            taught = rows.to_taught()
            workpiece, options = self.part.workpiece, self.options
            named = name_taught(taught, workpiece.features, options=options, T_nominal_part=self.T_nominal_part)
            observed = prepare_fit(named.taught, workpiece, T_nominal_part=self.T_nominal_part)
            choice = self.moving.to_options(self.groups)
            found = fit_part(
                workpiece,
                observed,
                self.part.seams,
                replace(options, bodies=choice),
                T_nominal_part=self.T_nominal_part,
            )
            bodies = None if found.moved is None else bodies_record(found.moved, workpiece.graph)
            revision, moving = self.seams_revision, self.moving.to_record()
        record = _fit_record(rows, named.taught, found.result, found.u95_mm, bodies)
        return {**record, "seams_revision": revision, "moving": moving}

    def read(self, raw: bytes, *, name: str, uframe: str = "") -> tuple[Rows, tuple[str, ...]]:
        """Return the points of a table or a controller's program as rows.

        Returns `left_out`: tuple of str. Points of a program without coordinates, each with the reason.
        Raises `InputError` as in `wpcal.taught.read_taught` or `wpcal.controllers.read_taught_program`.
        """
        path = Path(name)
        if not is_program(path):
            return read_rows(raw, path=name), ()
        reading = self.program
        left_out: tuple[str, ...] = ()
        if uframe:
            reading = replace(reading, uframes=parse_uframes([uframe]))
        found = parse_program(raw, path)
        if reading.points is None:
            usable, faults = usable_points(found, arm=reading.arm)
            reading = replace(reading, points=usable or None)
            left_out = tuple(f"{point}: {fault}" for point, fault in faults.items())
        taught = names_as_features(points_in_base(found, reading), self.part.workpiece.features)
        taught = replace(taught, R_base_tool=None)  # a person who touches a point again types no posture
        return read_rows(taught_csv(taught).encode("utf-8"), path=name), left_out

    def suggest(self, rows: Rows) -> dict[str, Any]:
        """Choose the features to touch next: first enough for a good fit, then one at a time.

        Returns: ``features`` to add (empty if no further one helps); ``error_95_mm``, the largest 95 % error along the
        accepted seams that is predicted with them; the ``seam`` where it occurs; ``sigma_mm``, the teaching error per
        axis assumed. If bodies may have moved, ``touches`` says what each feature is for (`next_for_bodies`).

        Raises `InputError` when the name of a feature is unknown, rows were touched on faces of a part that is one
        body, or as in `wpcal.touch.advice.advise`.
        """
        choice = self.moving.to_options(self.groups)
        if choice is None and ("kind" in rows.columns or "feature" not in rows.columns):
            what = "without a column kind" if "kind" in rows.columns else "with a column feature"
            raise InputError(f"points are suggested for tables {what}")
        features = self.part.workpiece.features
        have, others = _named_in(rows, features)
        taken = {feature.name for feature in (*have, *others)}
        sigma_mm = Sigma.expected(self.options.teaching.per_axis_mm).mm
        if choice is not None:
            with self._busy:
                part = self.part
            ball_mm = self.options.ball_mm
            teaching = replace(self.options.teaching, sigma_mm=sigma_mm, bound_mm=None)
            return next_for_bodies(part, rows, (have, others), choice, teaching=teaching, ball_mm=ball_mm)
        chosen = advise_set(
            [item for item in self.part.touchables if item.feature.kind.is_point and item.feature.name not in taken],
            [seam for seam in self.part.seams if seam.accepted],
            points=max(FIRST_POINTS, len(have) + 1),
            sigma_mm=sigma_mm,
            robot=self.options.teaching.robot,
            criterion=Criterion.MINIMAX if self.options.criterion is Criterion.MINIMAX else Criterion.LEAST_SQUARES,
            have=have,
            seed=self.options.seed,
        )
        return {
            "features": [name for name in chosen.names if name not in taken],
            "error_95_mm": chosen.error_95_mm,
            "seam": chosen.seam,
            "sigma_mm": sigma_mm,
        }

    def touch(self, point: FloatArray, normal: FloatArray) -> dict[str, Any]:
        """Return what a click on the part touches; see `cad.session.touches.touch_on_face`.

        `point`, `normal`: shape (3,). In `part`, mm.
        """
        return touch_on_face(self.part, point, normal)

    def promise(self, rows: Rows) -> dict[str, Any]:
        """Predict what planned touches promise for the seams; see `cad.session.touches.predict_touches`.

        If bodies may have moved, no error is predicted: that of the part as one piece is too small.
        """
        found = predict_touches(self.part, rows, teaching=self.options.teaching, ball_mm=self.options.ball_mm)
        return {**found, "error_95_mm": None, "seam": ""} if self.moving.is_on else found


def _named_in(
    rows: Rows, features: Sequence[ReferenceFeature]
) -> tuple[list[ReferenceFeature], list[ReferenceFeature]]:
    """Return the features named by rows that are fitted, each once, and those named by other rows only."""
    if "feature" not in rows.columns:
        return [], []
    place, use = rows.columns.index("feature"), rows.columns.index("use") if "use" in rows.columns else None
    named: dict[bool, dict[str, ReferenceFeature]] = {True: {}, False: {}}
    for row in rows.cells:
        if row[place]:
            feature = feature_named(features, row[place])
            is_fitted = use is None or row[use].lower() in ("", "yes")
            named[is_fitted][feature.name] = feature
    return list(named[True].values()), [f for name, f in named[False].items() if name not in named[True]]


def fault_record(error: WpcalError, rows: Rows | None = None) -> dict[str, Any]:
    """Return what the page needs to know of an error.

    Returns: ``message`` for the reader; ``code``, the cause; ``row`` and ``column`` of the wrong cell, or None.
    """
    record: dict[str, Any] = {"message": _one_line(str(error)), "code": str(error.code), "row": None, "column": None}
    if rows is None or not isinstance(error, FormatError) or error.path or not error.line:
        return record
    index = error.line - FIRST_LINE
    complete = rows.complete()
    if not 0 <= index < len(complete):
        return {**record, "message": _one_line(error.what)}
    row = complete[index]
    name = rows.cells[row][rows.columns.index("name")] or f"row {row + 1}"
    column = error.column if isinstance(error.column, str) else None
    place = f"{name}, {column}" if column else name
    return {**record, "message": _one_line(f"{place}: {error.what}"), "row": row, "column": column}


def _fit_record(
    rows: Rows,
    taught: TaughtPoints,
    result: CalibrationResult,
    u95_mm: tuple[FloatArray, ...],
    bodies: dict[str, Any] | None,
) -> dict[str, Any]:
    record = result.to_record() if bodies is None else {**result.to_record(), "bodies": bodies}
    row_of = dict(zip(taught.names, rows.complete(), strict=True))
    place_points(record["points"], row_of, result.T_base_part)
    kept = ["verdict", "judgement", "tolerance_mm", "criterion", "objective_mm", "lower_bound_mm", "certified"]
    kept += ["T_base_part", "criterion_advice", "bodies", "points"]
    return {
        **{key: record[key] for key in kept if key in record},
        "u95_mm": [np.round(values, ERROR_DIGITS).tolist() for values in u95_mm],
        "features": {row_of[name]: feature for name, feature in zip(taught.names, taught.features, strict=True)},
        "steps": next_steps(record),
        "again": [row_of[name] for name in record.get("suspect", {}).get("names", ())],
        "notes": [issue["message"] for issue in record["issues"]],
        "exchanges": [
            {"row": row_of[exchange["name"]], "feature": exchange["feature"], "largest_mm": exchange["largest_mm"]}
            for exchange in record.get("suspect", {}).get("exchanges", ())
        ],
    }


def place_points(points: list[dict[str, Any]], row_of: Mapping[str, int], T_base_part: RigidTransform) -> None:
    """Add ``row`` and ``residual_part_mm`` to the points of a record of a calibration, for arrows at the part."""
    for point in points:
        point["row"] = row_of[point["name"]]
        point["residual_part_mm"] = (T_base_part.R.T @ np.array(point["residual_mm"])).tolist()


def _one_line(message: str) -> str:
    """Return a message without line ends and control characters, which come from names in a request."""
    return printable(" ".join(message.split()))


def next_for_bodies(
    part: PickPart,
    rows: Rows,
    named: tuple[Sequence[ReferenceFeature], Sequence[ReferenceFeature]],
    choice: BodiesOptions,
    *,
    teaching: TeachingError,
    ball_mm: float,
) -> dict[str, Any]:
    """Choose the features that lower the error of the worst seam most.

    Returns: As of `PickSession.suggest`, and ``touches``: for each feature its body, the seam that it serves, the error
    of this seam before and after, and a sentence.
    """
    have, others = named
    taken = {feature.name for feature in (*have, *others)}
    planned = planned_touches(part, rows, ball_mm)
    touched, points = (None, have) if planned is None else (planned[0], ())
    made = np.zeros((0, 3)) if touched is None else touched.p_base
    free = [
        item
        for item in part.touchables
        if item.feature.kind.is_point
        and item.feature.name not in taken
        and not (np.linalg.norm(made - item.feature.p_mm, axis=1) < SAME_MM).any()
    ]
    accepted = [seam for seam in part.seams if seam.accepted]
    found = advise_bodies(
        Advisable(part.workpiece, accepted, free, points),
        choice,
        teaching=teaching,
        seam_options=part.seam_options,
        touched=touched,
        how_many=HowMany(max(FIRST_POINTS - len(points) - len(made), 1)),
    )
    return {
        "features": [touch.name for touch in found.touches],
        "error_95_mm": found.error_95_mm,
        "seam": found.seam,
        "sigma_mm": teaching.per_axis_mm,
        "touches": [touch.to_record() for touch in found.touches],
    }
