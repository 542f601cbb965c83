"""The page people look at: `report.html` from the files of a finished calibration."""

from wpcal.report.page import build_report

__all__ = ["build_report"]
