"""The page people look at: `report.html` from the files of a finished calibration."""

from wpcal.report.files import ReportFiles, read_report_files
from wpcal.report.page import build_report

__all__ = ["ReportFiles", "build_report", "read_report_files"]
