"""HTML pages: a calibration, the seams of a part, a plan. Each page is one self-contained file. `draw` makes pictures.

The JavaScript is in ``source``; its README lists which file makes which part of a page. ``bundles`` is built from it.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from wpcal.core.lazy_names import lazy_names

if TYPE_CHECKING:
    from wpcal.pages.html import build_page, json_blob
    from wpcal.pages.report import build_report
    from wpcal.pages.seams import build_seams_page

_HOMES = {
    "build_page": "wpcal.pages.html:build_page",
    "build_report": "wpcal.pages.report:build_report",
    "build_seams_page": "wpcal.pages.seams:build_seams_page",
    "json_blob": "wpcal.pages.html:json_blob",
}
__all__ = ["build_page", "build_report", "build_seams_page", "json_blob"]
__getattr__, __dir__ = lazy_names(__name__, _HOMES)
