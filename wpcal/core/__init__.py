"""Errors, arrays, rigid transforms, point pairs and records: what every other package builds on."""

from wpcal.core.errors import (
    ConvergenceError,
    ErrorCode,
    FormatError,
    FrameError,
    GeometryError,
    InputError,
    KernelError,
    UnitError,
    WpcalError,
    blamed_on,
)
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs, Residuals
from wpcal.core.transform import RigidTransform, SixTuple

__all__ = [
    "ConvergenceError",
    "ErrorCode",
    "FormatError",
    "FrameError",
    "GeometryError",
    "InputError",
    "Issue",
    "KernelError",
    "PointPairs",
    "Residuals",
    "RigidTransform",
    "SixTuple",
    "UnitError",
    "WpcalError",
    "blamed_on",
]
