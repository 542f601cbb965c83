"""Which code of wpcal runs: in a checkout it changes without a new version number."""

from __future__ import annotations

import hashlib
from importlib.util import find_spec
from pathlib import Path

OUR_PACKAGES = ("wpcal", "cad")


def code_sha256() -> str:
    """Return the SHA-256 of all Python files of wpcal."""
    digest = hashlib.sha256()
    for package in OUR_PACKAGES:
        for folder in folders_of(package):
            for file in sorted(folder.rglob("*.py")):
                digest.update(f"{package}/{file.relative_to(folder)}\0".encode())
                digest.update(hashlib.sha256(file.read_bytes()).digest())
    return digest.hexdigest()


def folders_of(package: str) -> list[Path]:
    """Return the folders of a package, without importing it; none if it is not installed."""
    spec = find_spec(package)
    return [] if spec is None else [Path(folder) for folder in spec.submodule_search_locations or ()]
