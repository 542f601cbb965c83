"""What tests need and do not test, found once in a run: the worker that asks first finds it, the others read it."""

import fcntl
import hashlib
import os
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

import pytest

from cad.work.plain_data import pack, unpack

Found = TypeVar("Found")
_FOUND: dict[str, object] = {}
_FOLDERS: list[Path] = []


def folder_of_run(factory: pytest.TempPathFactory) -> Path:
    """Return the folder of this run for all its workers."""
    folder = factory.getbasetemp()
    return folder.parent if "PYTEST_XDIST_WORKER" in os.environ else folder


def keep_in(folder: Path) -> None:
    """Share what this process finds from now on with all processes that name the same folder."""
    folder.mkdir(exist_ok=True)
    _FOLDERS.append(folder)


def kept(what: str, find: Callable[[], Found]) -> Found:
    """Return what a function finds, which is plain data (`cad.work.plain_data`) and the same in every process."""
    if what not in _FOUND:
        _FOUND[what] = _shared(what, find) if _FOLDERS else find()
    return _FOUND[what]  # type: ignore[return-value]


def _shared(what: str, find: Callable[[], Found]) -> Found:
    path = _FOLDERS[-1] / f"{hashlib.sha256(what.encode()).hexdigest()[:20]}.packet"
    with path.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not path.exists():
            path.write_bytes(pack(find()))
    found: Found = unpack(path.read_bytes())
    return found
