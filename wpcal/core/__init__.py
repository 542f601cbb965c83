"""Errors, arrays, rigid transforms, point pairs and records: the words every other package speaks."""

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
