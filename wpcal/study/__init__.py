"""Seeded simulation of calibrations: the error study of the paper."""

from wpcal.study.teaching_error import ErrorPlace, ErrorStudy, StudyOptions, run_error_study

__all__ = ["ErrorPlace", "ErrorStudy", "StudyOptions", "run_error_study"]
