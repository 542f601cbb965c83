"""HTML pages: a calibration, the seams of a part, a plan. Each page is one self-contained file.

The JavaScript is in ``source``; its README lists which file makes which part of a page. ``bundles`` is built from it.
"""

from wpcal.pages.html import build_page, json_blob
from wpcal.pages.report import build_report
from wpcal.pages.seams import build_seams_page

__all__ = ["build_page", "build_report", "build_seams_page", "json_blob"]
