"""The page of `wpcal seams --html`: the seams of a part, the refused candidates, the reasons, and an editor of seams.

The page gives away a ``seams.json`` with decisions and without frames. The commands carry the decisions out when they
get it with ``--seams``.
"""

from __future__ import annotations

from typing import Any

from wpcal.pages.html import build_page, json_blob
from wpcal.pages.report import seam_columns

BODY = """
<main id="page"></main>
<noscript>This page needs JavaScript to draw the seams; wpcal seams --json lists them.</noscript>
"""


def build_seams_page(seams: dict[str, Any], part_glb: bytes | None, *, file_name: str) -> str:
    """Return the page that shows seams on their part, in the part's own frame.

    Returns: A self-contained HTML file, the same for the same record.

    `part_glb`: The part's triangles, as `wpcal.brep.mesh_glb.write_part_glb` writes them. Without them the view shows
    only seams.
    """
    plain = [{key: value for key, value in seam.items() if key != "frames"} for seam in seams["seams"]]
    data = {"file": file_name, "record": {**seams, "seams": plain}}
    columns = seam_columns([seam["frames"] for seam in seams["seams"]])
    blobs = {"frames": json_blob(columns)}
    if part_glb is not None:
        blobs["part"] = part_glb
    return build_page(title=f"Seams of {file_name}", entry="seams", body=BODY, data=data, blobs=blobs)
