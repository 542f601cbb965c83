"""The pages people look at: a calibration, the seams of a part, a plan; each is one self-contained HTML file."""

from wpcal.pages.html import build_page, json_blob
from wpcal.pages.report import build_report
from wpcal.pages.seams import build_seams_page

__all__ = ["build_page", "build_report", "build_seams_page", "json_blob"]
