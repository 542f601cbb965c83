"""What an answer about a part depends on besides the part and the options: the code of wpcal and of its libraries."""

from __future__ import annotations

import hashlib
import os
import platform
import sys
from functools import cache
from importlib.metadata import version
from importlib.util import find_spec
from pathlib import Path

OUR_PACKAGES = ("wpcal", "cad")
LIBRARIES = ("numpy", "scipy")
"""Libraries whose arithmetic may differ in the last digit from one version to the next."""
KERNEL = "OCP"
"""Package of the CAD kernel. Several distributions supply it, so its files are identified and not its version."""


@cache
def versions() -> tuple[str, ...]:
    """Return texts that change whenever an answer about the same part could change.

    Returns
    -------
    tuple of str
        SHA-256 of all Python files of wpcal, the versions of Python, NumPy and SciPy, the files of the CAD kernel with
        size and time of change, and the kind of processor.
    """
    return (
        _code_sha256(),
        sys.version,
        *(f"{name} {version(name)}" for name in LIBRARIES),
        *_kernel_files(),
        platform.machine(),
    )


def _code_sha256() -> str:
    """Hash the code itself: in a checkout it changes without a new version number."""
    digest = hashlib.sha256()
    for package in OUR_PACKAGES:
        for folder in _folders_of(package):
            for file in sorted(folder.rglob("*.py")):
                digest.update(f"{package}/{file.relative_to(folder)}\0".encode())
                digest.update(hashlib.sha256(file.read_bytes()).digest())
    return digest.hexdigest()


def _kernel_files() -> tuple[str, ...]:
    found = (entry for folder in _folders_of(KERNEL) for entry in os.scandir(folder) if entry.is_file())
    return tuple(sorted(f"{entry.path} {entry.stat().st_size} {entry.stat().st_mtime_ns}" for entry in found))


def _folders_of(package: str) -> list[Path]:
    spec = find_spec(package)
    return [] if spec is None else [Path(folder) for folder in spec.submodule_search_locations or ()]
