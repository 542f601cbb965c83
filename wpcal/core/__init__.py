"""Errors, arrays, rigid transforms, point pairs and records: what every other package builds on.

The names are imported when they are used: a process sets its threads (`wpcal.core.process`) before NumPy is loaded.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from wpcal.core.lazy_names import lazy_names

if TYPE_CHECKING:
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
__getattr__, __dir__ = lazy_names(
    __name__,
    {
        "ConvergenceError": "wpcal.core.errors:ConvergenceError",
        "ErrorCode": "wpcal.core.errors:ErrorCode",
        "FormatError": "wpcal.core.errors:FormatError",
        "FrameError": "wpcal.core.errors:FrameError",
        "GeometryError": "wpcal.core.errors:GeometryError",
        "InputError": "wpcal.core.errors:InputError",
        "Issue": "wpcal.core.issue:Issue",
        "KernelError": "wpcal.core.errors:KernelError",
        "PointPairs": "wpcal.core.pairs:PointPairs",
        "Residuals": "wpcal.core.pairs:Residuals",
        "RigidTransform": "wpcal.core.transform:RigidTransform",
        "SixTuple": "wpcal.core.transform:SixTuple",
        "UnitError": "wpcal.core.errors:UnitError",
        "WpcalError": "wpcal.core.errors:WpcalError",
        "blamed_on": "wpcal.core.errors:blamed_on",
    },
)
