"""The page of a plan of touches (``touches.html``): the part, its seams, and every search with its way.

The page plays through the searches in their order. ``touches.json`` holds the same numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.pages.html import build_page, json_blob
from wpcal.pages.report import PLACE_DIGITS, TURN_DIGITS
from wpcal.touch.searches.plan import Search, TouchPlan
from wpcal.touch.searches.setup import TouchSetup

BODY = """
<main id="page"></main>
<noscript>This page needs JavaScript to draw the searches; touches.json and touches.csv list them.</noscript>
"""


def build_touches_page(
    plan: TouchPlan,
    *,
    part_glb: bytes | None = None,
    seams: Mapping[str, FloatArray] | None = None,
    border_mm: Mapping[str, float | None] | None = None,
    setup: TouchSetup | None = None,
) -> str:
    """Return the page that shows a plan of touches, in the part's own frame.

    `seams`: By name: points along each seam in `part`, mm, shape (n, 3).
    Returns: A self-contained HTML file, the same for the same plan.
    """
    given = setup or TouchSetup()
    borders = border_mm or {}
    predicted = plan.predicted
    data = {
        "part": plan.part,
        "robot": plan.robot,
        "wire_mm": plan.wire_mm,
        "stick_out_mm": plan.stick_out_mm,
        "search_speed_mm_s": given.search_speed_mm_s,
        "air_speed_mm_s": given.air_speed_mm_s,
        "hold_s": given.hold_s,
        "notes": list(plan.notes),
        "predicted": None
        if predicted is None
        else {
            "error_95_mm": predicted.error_95_mm,
            "seam": predicted.seam,
            "by_seam": [{"seam": name, "error_95_mm": error} for name, error in predicted.by_seam_mm],
        },
        "searches": [_search(search, borders.get(search.name)) for search in plan.searches],
    }
    lines = [{"name": name, "p": _rounded(p)} for name, p in (seams or {}).items()]
    blobs = {"lines": json_blob(lines)}
    if part_glb is not None:
        blobs["part"] = part_glb
    return build_page(title=f"Touches of {plan.part}", entry="touches", body=BODY, data=data, blobs=blobs)


def _search(search: Search, border_mm: float | None) -> dict[str, Any]:
    return {
        "name": search.name,
        "kind": search.kind.value,
        "target": search.target,
        "feature": search.feature,
        "contact": search.contact.value,
        "stroke_mm": search.stroke_mm,
        "radius_mm": search.radius_mm,
        "border_mm": border_mm,
        "error_95_mm": search.error_95_mm,
        "normal": np.round(search.normal_part, TURN_DIGITS).tolist(),
        "R": np.round(search.R_part_tool, TURN_DIGITS).tolist(),
        "contact_mm": _rounded(search.contact_part),
        "planned": _rounded(search.planned),
        "via": _rounded(search.via.reshape(-1, 3)),
        **{name: _rounded(getattr(search, name)) for name in ("approach", "start", "end", "retract")},
    }


def _rounded(points: FloatArray) -> Any:
    return np.round(points, PLACE_DIGITS).tolist()
