"""The picker's page: the part with its features and seams in the frame `part`, and the rows."""

from __future__ import annotations

from typing import Any

from cad.pick.part import PickPart
from cad.pick.rows import Rows
from cad.workpiece.fit_taught import CalibrateOptions
from wpcal.pages.html import build_page, json_blob
from wpcal.pages.report import seam_columns
from wpcal.seam.record import seams_record
from wpcal.taught.columns import USES
from wpcal.taught.kinds import KINDS

BODY = """
<main id="page"></main>
<noscript>The picker needs JavaScript.</noscript>
"""
SHOWN = ("name", "accepted", "joint", "weld", "solids", "length_mm")


def build_pick_page(part: PickPart, rows: Rows, options: CalibrateOptions, *, saves_to: str, command: str) -> str:
    """Return the page. It sends requests to its own server: ``POST fit``, ``save``, ``suggest`` and ``read``.

    Parameters
    ----------
    part : PickPart
    rows : Rows
        The table at the start.
    options : CalibrateOptions
    saves_to : str
        Name of the file that the button "save" writes.
    command : str
        The command that calibrates from that file with the same options.
    """
    record = seams_record(part.seams)
    features = [
        {**item.feature.to_record(), "letter": item.feature.kind.value, "ease": item.ease.word}
        for item in part.touchables
        if item.feature.kind.is_point
    ]
    data: dict[str, Any] = {
        "file": part.file_name,
        "notes": list(part.notes),
        "seams": [{key: seam[key] for key in SHOWN} for seam in record["seams"]],
        "table": rows.to_record(),
        "choices": {"use": list(USES), "kind": list(KINDS)},
        "tolerance_mm": options.tolerance_mm,
        "saves_to": saves_to,
        "command": command,
    }
    columns = [seam_columns(seam["frames"]) for seam in record["seams"]]
    blobs = {"features": json_blob(features), "frames": json_blob(columns)}
    if part.part_glb is not None:
        blobs["part"] = part.part_glb
    return build_page(title=f"Pick {part.file_name}", entry="pick", body=BODY, data=data, blobs=blobs, connects=True)
