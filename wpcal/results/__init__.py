"""A result folder: read, checked for agreement, compared; and the schema of every record."""

from wpcal.results.folder import FinishedCalibration, read_finished
from wpcal.results.report_files import ReportFiles, read_report_files

__all__ = ["FinishedCalibration", "ReportFiles", "read_finished", "read_report_files"]
