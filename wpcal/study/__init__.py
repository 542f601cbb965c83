"""Seeded simulation of calibrations: the paper's error study, and whether predicted errors are right."""

from wpcal.study.coverage import CoverageStudy, run_coverage_study
from wpcal.study.teaching_error import ErrorPlace, ErrorStudy, run_error_study

__all__ = ["CoverageStudy", "ErrorPlace", "ErrorStudy", "run_coverage_study", "run_error_study"]
