"""What a command checks about the files it will write, before any work is done."""

from __future__ import annotations

from pathlib import Path


def require_new(path: Path, *, overwrite: bool) -> None:
    """Refuse a file that exists unless it may be overwritten.

    Raises
    ------
    InputError
        If the file exists and `overwrite` is false.
    """
    from wpcal.core.errors import InputError

    if path.exists() and not overwrite:
        raise InputError(f"{path}: exists; give --force to overwrite it")
