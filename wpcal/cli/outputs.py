"""What a command checks about the files it will write, before any work is done."""

from __future__ import annotations

import errno
import os
from pathlib import Path


def require_new(path: Path, *, overwrite: bool) -> None:
    """Refuse a file that cannot be written, unless an existing one may be overwritten.

    Raises
    ------
    InputError
        If the file exists and `overwrite` is false, or there is no folder to write it into, or it cannot be written.
    """
    from wpcal.core.errors import ErrorCode, InputError
    from wpcal.core.records import require_place

    if path.exists() and not overwrite:
        raise InputError(f"{path}: exists; allow overwriting to replace it", code=ErrorCode.EXISTS)
    if not path.parent.is_dir():
        reason = os.strerror(errno.ENOTDIR if path.parent.exists() else errno.ENOENT).lower()
        raise InputError(f"{path}: cannot be written: {reason}")
    require_place(path)
