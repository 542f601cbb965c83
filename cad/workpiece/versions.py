"""What an answer about a part depends on besides the part and the options: the code of wpcal and of its libraries."""

from __future__ import annotations

import os
import platform
import sys
from functools import cache
from importlib.metadata import version

from wpcal.core.own_code import code_sha256, folders_of

LIBRARIES = ("numpy", "scipy")  #: Libraries whose arithmetic may differ in the last digit from one version to the next.
KERNEL = "OCP"
"""Package of the CAD kernel. Several distributions supply it, so its files are identified and not its version."""


@cache
def versions() -> tuple[str, ...]:
    """Return texts that change whenever an answer about the same part could change.

    Returns: SHA-256 of all Python files of wpcal, the versions of Python, NumPy and SciPy, the files of the CAD kernel
    with size and time of change, and the kind of processor.
    """
    return (
        code_sha256(),
        sys.version,
        *(f"{name} {version(name)}" for name in LIBRARIES),
        *_kernel_files(),
        platform.machine(),
    )


def _kernel_files() -> tuple[str, ...]:
    found = (entry for folder in folders_of(KERNEL) for entry in os.scandir(folder) if entry.is_file())
    return tuple(sorted(f"{entry.path} {entry.stat().st_size} {entry.stat().st_mtime_ns}" for entry in found))
