"""`report.html`: one calibration as a page, from its records and its mesh. It holds no clock, path or host name."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import islice
from typing import Any

import numpy as np

from wpcal.brep.mesh_glb import read_part_glb
from wpcal.core.errors import FormatError
from wpcal.core.pendant import NOTATIONS
from wpcal.core.result_files import SEAMS_FILE
from wpcal.core.transform import RigidTransform
from wpcal.pages.html import build_page, json_blob
from wpcal.results.next_steps import HELP_PAGE, next_steps

BODY = """
<main id="page"></main>
<noscript>This page needs JavaScript to draw the calibration; its numbers are in calibration.json.</noscript>
"""
PLACE_DIGITS, ANGLE_DIGITS, TURN_DIGITS = 4, 4, 5
"""The page shows 3 decimals of a millimetre and 1 of a degree; axes with 5 digits are exact to 0.01 pixel."""
ERROR_DIGITS = 6
"""The page shows 4 decimals of predicted errors; two more digits here hide that they are rounded twice."""

OF_BODIES = {"across": "u95_across_mm", "placing": "u95_placing_mm", "unseen": "u95_unseen_mm", "gap": "gap_mm"}
"""Columns of seams between bodies that moved."""


def build_report(calibration: dict[str, Any], seams: dict[str, Any], part_glb: bytes | None = None) -> str:
    """Return the page of a calibration. A self-contained HTML file, the same for the same records.

    Raises `FormatError` if a record lacks a field, or `part_glb` is not a mesh of wpcal.

    `part_glb`: The part's triangles, as `wpcal.brep.mesh_glb.write_part_glb` writes them. Without them the view shows
    only seams and points.
    """
    try:
        heads = [{key: value for key, value in seam.items() if key != "frames"} for seam in seams["seams"]]
        columns = seam_columns([seam["frames"] for seam in seams["seams"]])
        T_base_part = RigidTransform.from_matrix(calibration["T_base_part"], target="base", source="part")
        title = f"{calibration['verdict']} {calibration.get('inputs', {}).get('part', {}).get('file', 'calibration')}"
    except (KeyError, TypeError, AttributeError) as error:
        raise FormatError(f"is not a complete seams file: {type(error).__name__} {error}", path=SEAMS_FILE) from None
    data: dict[str, Any] = {
        "calibration": calibration,
        "seams": heads,
        "mesh": None,
        "pendant": {notation.maker: notation.orientation_text(T_base_part) for notation in NOTATIONS},
        "steps": next_steps(calibration),
        "help": HELP_PAGE,
    }
    blobs = {"frames": json_blob(columns)}
    if part_glb is not None:
        data["mesh"] = {"deflection_mm": read_part_glb(part_glb).deflection_mm}
        blobs["part"] = part_glb
    return build_page(title=title, entry="report", body=BODY, data=data, blobs=blobs)


def seam_columns(seams: Sequence[list[dict[str, Any]]]) -> list[dict[str, Any]]:
    """Return the frames of each seam as columns, rounded to what a page can show."""
    found: list[dict[str, Any]] = [{} for _ in seams]
    for name, key in OF_BODIES.items():
        for columns, seam, values in zip(found, seams, _rounded(seams, key, ERROR_DIGITS), strict=True):
            if key in (seam or [{}])[0]:
                columns[name] = values
    shown = {
        "s": _rounded(seams, "s_mm", PLACE_DIGITS),
        "p": _rounded(seams, "p_mm", PLACE_DIGITS),
        "R": _rounded(seams, "R", TURN_DIGITS),
        "u95": _rounded(seams, "u95_mm", ERROR_DIGITS),
        "slope": _rounded(seams, "slope_deg", ANGLE_DIGITS),
        "rotation": [_optional(seam, "rotation_deg", lambda value: round(value, ANGLE_DIGITS)) for seam in seams],
        "position": [_optional(seam, "position", str) for seam in seams],
    }
    return [{**first, **{name: values[row] for name, values in shown.items()}} for row, first in enumerate(found)]


def _rounded(seams: Sequence[list[dict[str, Any]]], key: str, digits: int) -> list[Any]:
    """Return a column of numbers of each seam, or None where the file has none."""
    having = [bool(seam) and key in seam[0] for seam in seams]
    values = [frame[key] for seam, has_key in zip(seams, having, strict=True) if has_key for frame in seam]
    rounded = iter(np.round(np.array(values, dtype=np.float64), digits).tolist())
    return [list(islice(rounded, len(seam))) if has_key else None for seam, has_key in zip(seams, having, strict=True)]


def _optional(frames: list[dict[str, Any]], key: str, shown: Callable[[Any], Any]) -> Any:
    """Return a column in which a value may be null."""
    if not frames or key not in frames[0]:
        return None
    return [None if frame[key] is None else shown(frame[key]) for frame in frames]
