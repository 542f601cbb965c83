"""Touches before they are made: what a click on the part touches, and what the rows promise for the seams."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from cad.session.part import PickPart
from cad.session.rows import Rows
from wpcal.calibrate import Criterion, TeachingError
from wpcal.calibrate.errors.budget import ErrorBudget
from wpcal.calibrate.errors.of_touches import budget_of_touches
from wpcal.calibrate.errors.prediction import Sigma
from wpcal.calibrate.errors.robot_field import foresee
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.solve.touches import Pose
from wpcal.calibrate.trust.held_motions import held_motions
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, GeometryError, InputError, WpcalError
from wpcal.seam import Seam
from wpcal.taught.columns import MODEL_COLUMNS, TAUGHT_COLUMNS
from wpcal.taught.features import ReferenceFeature, feature_named
from wpcal.taught.resolve import named_axes, touches_of
from wpcal.taught.touched_face import touched_face

MODEL_DIGITS = 4  #: Decimals of mm in the table: a click on the screen is known to some tenths of a millimetre.


def touch_on_face(part: PickPart, point: FloatArray, normal: FloatArray) -> dict[str, Any]:
    """Return what a click on the part touches.

    Returns: ``kind`` of a taught table, ``p_mm`` on the face, its outward ``normal`` and ``border_mm``.

    `point`, `normal`: shape (3,). Of the triangle that was clicked, in `part`, mm.
    Raises `InputError` when a table could not say which face is meant: near the border of the face, or where two solids
    touch.
    """
    found = touched_face(part.workpiece.trimmed, point, normal)
    place = tuple(f"{v:.{MODEL_DIGITS}f}" for v in found.p_part)
    columns = ("name", "kind", *TAUGHT_COLUMNS, *MODEL_COLUMNS)
    row = Rows(columns, (("T1", found.kind.value, *place, *place),))
    try:
        touches_of(row.to_taught().with_ball(0.0), part.workpiece.trimmed, part.workpiece.features, use="yes")
    except FormatError:
        border = "" if found.border_mm is None else f", {found.border_mm:.1f} mm from its border"
        what = f"the {found.kind.value} here is as near as another face{border}"
        raise InputError(f"{what}; click farther inside, or the edge") from None
    return {
        "kind": found.kind.value,
        "p_mm": np.round(found.p_part, MODEL_DIGITS).tolist(),
        "normal": found.normal_part.tolist(),
        "border_mm": found.border_mm,
    }


def predict_touches(part: PickPart, rows: Rows, *, teaching: TeachingError, ball_mm: float) -> dict[str, Any]:
    """Predict what rows promise, with or without coordinates: the touches as they are planned.

    Raises `WpcalError` when a row cannot be understood.

    Returns: ``touches``: for each row on a face or an edge its index ``row``, ``p_mm`` and outward ``normal`` (zero on
    an edge), in `part`. ``error_95_mm`` and ``seam``: the largest predicted error of the accepted seams, and where;
    without seams, or while the touches leave the part free, null. ``free``: which motion is free, or empty.
    """
    planned, sigma_mm = planned_touches(part, rows, ball_mm), Sigma.expected(teaching.per_axis_mm).mm
    nothing: dict[str, Any] = {"touches": [], "error_95_mm": None, "seam": "", "free": "", "sigma_mm": sigma_mm}
    if planned is None:
        return nothing
    touches, index = planned
    pose = Pose.of(touches, np.eye(3), np.zeros(3))
    near = touches.targets.nearest(touches.rows, touches.p_base)
    is_point = np.isclose(np.trace(near.projector, axis1=1, axis2=2), 3.0)
    arrows = [
        {"row": row, "p_mm": p.tolist(), "normal": normal.tolist()}
        for row, p, normal, skip in zip(index, near.p, near.normal, is_point, strict=True)
        if not skip
    ]
    try:
        held_motions(touches, pose)
    except GeometryError as error:
        return {**nothing, "touches": arrows, "free": str(error)}
    stated = replace(teaching, sigma_mm=sigma_mm, bound_mm=None)
    budget = budget_of_touches(touches, pose, Criterion.LEAST_SQUARES, stated)
    assert budget.belief.rows is not None  # of touches that hold the part
    belief = foresee(budget.belief.rows, 1.0 if touches.covariances is not None else sigma_mm, teaching.robot)
    budget = replace(budget, belief=belief, scale=belief.scale)
    return {**nothing, "touches": arrows, **_worst(part.seams, budget)}


def planned_touches(part: PickPart, rows: Rows, ball_mm: float) -> tuple[Touches, list[int]] | None:
    """Return the touches of rows at their model points, as if the part were at the base."""
    columns = rows.columns
    if "kind" not in columns:
        return None
    use = columns.index("use") if "use" in columns else None
    cells, index = [], []
    for number, row in enumerate(rows.cells):
        place = _model_point(dict(zip(columns, row, strict=True)), part.workpiece.features)
        if place is not None and (use is None or row[use].lower() in ("", "yes")):
            given = dict(zip(TAUGHT_COLUMNS, place, strict=True))
            cells.append(tuple(given.get(name, cell) for name, cell in zip(columns, row, strict=True)))
            index.append(number)
    if not cells:
        return None
    taught = Rows(columns, tuple(cells)).to_taught().with_ball(ball_mm)
    features = part.workpiece.features
    found = touches_of(taught, part.workpiece.trimmed, features, use="yes")
    on_model = found.linearised(np.eye(3), np.zeros(3)).contact_part
    return replace(found, p_base=on_model, axes=named_axes(features)), index


def _model_point(row: dict[str, str], features: Sequence[ReferenceFeature]) -> tuple[str, ...] | None:
    """Return the model coordinates of a row as text; None if it names no place."""
    place = tuple(row.get(name, "") for name in MODEL_COLUMNS)
    if all(place):
        return place
    named = row.get("feature", "") or (row["name"] if row["kind"] in ("", "point") and "feature" not in row else "")
    if not named:
        return None
    try:
        return tuple(str(float(v)) for v in feature_named(features, named).p_mm)
    except WpcalError:  # the fit says so where the name is typed
        return None


def _worst(seams: Sequence[Seam], budget: ErrorBudget) -> dict[str, Any]:
    errors = [(budget.largest_error_95(seam.frames.p)[1], seam.name) for seam in seams if seam.accepted]
    if not errors:
        return {}
    largest, name = max(errors)
    return {"error_95_mm": largest, "seam": name}
