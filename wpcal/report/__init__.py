"""The page people look at: `report.html` from the files of a finished calibration."""

from wpcal.report.files import ReportFiles, read_report_files
from wpcal.report.page import build_report
from wpcal.report.seams_page import build_seams_page

__all__ = ["ReportFiles", "build_report", "build_seams_page", "read_report_files"]
