"""Workpiece calibration for robot welding: taught points in, calibrated weld seams out."""

__version__ = "0.1.0"
