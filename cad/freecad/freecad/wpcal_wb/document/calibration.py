# SPDX-License-Identifier: MIT
"""A calibration in a document: what wpcal is asked, and what is kept of its answer."""

from __future__ import annotations

from typing import Any, Mapping

import FreeCAD

from ..words import translate
from .kinds import Kind, data_of, ensure_object, object_of, set_data
from .moved_solids import MovedSolid, moved_solids
from .placed import add_frames, place_part, remove_frames, remove_placed, seam_frames
from .session import Session
from .shown import Shown

FRAME_CHOICES = {"": None, "ends": True, "all": False}
"""Which seam frames become coordinate systems: none, those at the ends, every one (the value of `ends_only`)."""


def fit_params(document: Any, options: Mapping[str, Any] | None = None) -> dict[str, Any]:
    """Return what `calibrate` and `save` are asked: taught points, options, decisions about seams.

    Raises `ValueError` if the document has no taught points.
    """
    taught = object_of(document, Kind.TAUGHT)
    table = data_of(taught, "Table") if taught is not None else None
    if not table or not table.get("rows"):
        raise ValueError(translate("There are no taught points yet. Take them in the panel Taught points."))
    taught_rows = {"columns": table["columns"], "rows": table["rows"]}
    given = fit_options(document) if options is None else options
    return {"taught": taught_rows, **seam_params(document, given)}


def fit_options(document: Any) -> dict[str, Any]:
    """Return the options of the fit that a document keeps."""
    taught = object_of(document, Kind.TAUGHT)
    return (data_of(taught, "FitOptions") or {}) if taught is not None else {}


def keep_options(document: Any, options: Mapping[str, Any]) -> None:
    """Keep options of the fit, without those that only repeat the search for seams. Call it inside a `transaction`."""
    of_seams = seam_params(document, {})["options"]
    own = {name: value for name, value in options.items() if of_seams.get(name) != value}
    set_data(ensure_object(document, Kind.TAUGHT), "FitOptions", own or None)


def seam_params(document: Any, options: Mapping[str, Any]) -> dict[str, Any]:
    """Return options, with those of the seams that the document keeps, and the decisions about seams."""
    seams = object_of(document, Kind.SEAMS)
    if seams is None:
        return {"options": dict(options), "decisions": []}
    return {"options": {**(data_of(seams, "SeamOptions") or {}), **options}, "decisions": data_of(seams, "Edits") or []}


def kept_fit_of(obj: Any) -> dict[str, Any] | None:
    """Return the fit that a calibration object has; None without one."""
    return data_of(obj, "Calibration") if obj is not None else None


def shown_of(obj: Any) -> Shown:
    """Return what is drawn of a calibration object."""
    data = (data_of(obj, "Shown") or {}) if obj is not None else {}
    return Shown(**{name: value for name, value in data.items() if name in Shown._fields})


def keep_fit(session: Session, fit: dict[str, Any], shown: Shown) -> Any:
    """Keep a fit in its document, and show the part where it is. Call it inside a `transaction`.

    Raises `ValueError` if more seam frames are wanted as coordinate systems than FreeCAD can show.
    """
    document = session.document
    obj = ensure_object(document, Kind.CALIBRATION)
    set_data(obj, "Shown", shown._asdict())
    set_data(obj, "Calibration", fit)
    obj.Verdict = fit["record"]["verdict"]
    pose = pose_of(fit["T_base_part"])
    obj.Pose = pose
    if session.part is not None:
        obj.PartFrame = session.part.frame
    with session.own_changes():
        _show_place(session, fit, shown, pose)
    return obj


def _show_place(session: Session, fit: dict[str, Any], shown: Shown, pose: Any) -> None:
    document = session.document
    if not shown.at_pose or session.part is None:
        remove_placed(document)
        return
    part = place_part(document, session.part.objects, pose, moves_in(session, fit))
    ends_only = FRAME_CHOICES.get(shown.datums)
    if ends_only is None:
        remove_frames(document)
    else:
        add_frames(document, part, seam_frames(fit["seams"] or (), pose.inverse(), ends_only=ends_only))


def moves_in(session: Session, fit: Mapping[str, Any]) -> dict[str, list[MovedSolid] | None]:
    """Return how the solids of each object moved, as `moved_solids` does; empty if the part was fitted as one piece."""
    bodies = fit["record"].get("bodies")
    if not bodies or session.part is None or session.opened is None:
        return {}
    return moved_solids(session.part.objects, session.opened["features"], bodies["bodies"])


def pose_of(matrix: Any) -> Any:
    """Return a 4 × 4 matrix, row by row, as a placement."""
    return FreeCAD.Placement(FreeCAD.Matrix(*(value for row in matrix for value in row)))
