"""A result folder: read, checked for agreement, compared; and the schema of every record."""

from wpcal.core.schemas import schema_names, schema_text
from wpcal.results.folder import FinishedCalibration, ResultFolder, read_finished, read_result_folder

__all__ = ["FinishedCalibration", "ResultFolder", "read_finished", "read_result_folder", "schema_names", "schema_text"]
