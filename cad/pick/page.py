"""The picker's page: the part with its features and seams in the frame `part`, and the rows."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from cad.pick.shared_seams import seams_of, solids_record
from cad.session.part import PickPart
from cad.workpiece.fit_taught import CalibrateOptions
from wpcal.pages.html import build_page, json_blob
from wpcal.taught.columns import USES
from wpcal.taught.kinds import KINDS

BODY = """
<main id="page"></main>
<noscript>The picker needs JavaScript.</noscript>
"""


def build_pick_page(
    part: PickPart, options: CalibrateOptions, *, notes: Sequence[str] = (), revision: int = 1, robot: str = ""
) -> str:
    """Return the page. It asks its own server for the table, so that a reload shows the table as it is."""
    shown = seams_of(part)
    features = [
        {**item.feature.to_record(), "letter": item.feature.kind.value, "ease": item.ease.word}
        for item in part.touchables
        if item.feature.kind.is_point
    ]
    data: dict[str, Any] = {
        "file": part.file_name,
        "notes": [*notes, *part.notes],
        "seams": shown["seams"],
        "seams_revision": revision,
        "join_mm": part.seam_options.most_join_mm,
        **solids_record(part),
        "choices": {"use": list(USES), "kind": list(KINDS)},
        "tolerance_mm": options.tolerance_mm,
        "robot": robot.partition(",")[0],
    }
    blobs = {"features": json_blob(features), "frames": json_blob(shown["frames"])}
    if part.part_glb is not None:
        blobs["part"] = part.part_glb
    return build_page(title=f"Pick {part.file_name}", entry="pick", body=BODY, data=data, blobs=blobs, connects=True)
