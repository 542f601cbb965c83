"""Answers about parts, kept in files, so that the next command on the same part need not find them again.

An answer is looked up by a hash of everything that it depends on (`AnswerCache.answer`). There is thus no answer that
is out of date: whatever changes, another answer is looked up. A file that is damaged, incomplete or of another user is
ignored, and replaced. Files are read as plain data (`cad.work.plain_data`): no code runs while they are read.

Several processes may use one folder. A file is written beside its place and renamed, so nobody reads half of one. When
the files exceed the limit, those that were not used for the longest time are removed.
"""

from __future__ import annotations

import errno
import hashlib
import os
import platform
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import TypeVar

from cad.work.plain_data import pack, unpack
from cad.work.plain_types import PlainDataError
from wpcal.core.errors import InputError
from wpcal.core.input_file import sha256_of
from wpcal.core.numbers import parse_number
from wpcal.core.own_code import code_sha256, folders_of

FOLDER_VARIABLE, SIZE_VARIABLE = "WPCAL_CACHE", "WPCAL_CACHE_MB"
"""Environment variables: the folder (or `OFF`), and the largest size of all files, MB."""
OFF = "off"
USUAL_MOST_MB = 500.0  #: About 30 parts of 6000 faces, or thousands of small ones.
BYTES_PER_MB = 1_000_000
SUFFIX, NEW_SUFFIX = ".answer", ".new"
ABANDONED_S = 3600.0  #: A file that was begun this long ago belongs to a process that was ended.
_HEAD = b"wpcal answer 1\n"
_NO_UNNAMED = (errno.EOPNOTSUPP, errno.EISDIR, errno.EINVAL, errno.ENOENT)
"""Errors of a place where files cannot be without a name."""
Answer = TypeVar("Answer")


class KernelNeededError(Exception):
    """An answer is not kept, and this process must not load the CAD kernel to find it."""


@dataclass(frozen=True, slots=True)
class AnswerCache:
    """A folder of answers."""

    folder: Path | None = None  #: Created when the first answer is kept. Without a folder nothing is kept.
    most_mb: float = USUAL_MOST_MB  #: Largest size of all answers together, MB.
    kernel: bool = True  #: Whether this process may load the CAD kernel to find what is missing.

    def answer(self, what: str, of: Sequence[object], make: Callable[[], Answer]) -> Answer:
        """Return an answer that is kept, or find it and keep it.

        `what`: The question.
        `of`: Everything that the answer depends on, besides the code and its libraries (`versions`): plain data.
        `make`: Finds the answer: plain data.
        """
        if self.folder is None:
            return make()
        key = key_of(what, of)
        packet = _read(self.folder / f"{key}{SUFFIX}", key)
        if packet is not None:
            with suppress(PlainDataError):
                found: Answer = unpack(packet)
                return found
        made = make()
        self._keep(self.folder, key, pack(made))
        return made

    def holds(self, what: str, of: Sequence[object]) -> bool:
        """Whether there is a file for an answer. It may turn out to be damaged."""
        return self.folder is not None and (self.folder / f"{key_of(what, of)}{SUFFIX}").is_file()

    def _keep(self, folder: Path, key: str, packet: bytes) -> None:
        """Write an answer, unless the folder cannot be written: then the next command finds the answer again."""
        if len(packet) > self.most_mb * BYTES_PER_MB:
            return
        with suppress(OSError):
            folder.mkdir(parents=True, exist_ok=True, mode=0o700)
            path, data = folder / f"{key}{SUFFIX}", _head(key, packet) + packet
            if not _write_unnamed(path, data):
                _write_renamed(path, data)
            _remove_oldest(folder, self.most_mb * BYTES_PER_MB)


NO_CACHE = AnswerCache()  #: Keeps nothing.


def user_cache() -> AnswerCache:
    """Return the cache of this user, as the environment states it.

    Raises `InputError` if a variable of the environment is not usable.
    """
    text = os.environ.get(FOLDER_VARIABLE, "")
    if text == OFF:
        return NO_CACHE
    size = os.environ.get(SIZE_VARIABLE, "")
    try:
        most_mb = parse_number(size) if size else USUAL_MOST_MB
    except InputError:
        most_mb = -1.0
    if not most_mb > 0:
        raise InputError(
            f"{SIZE_VARIABLE}: expected a size in MB above 0, got {size!r}; {FOLDER_VARIABLE}=off keeps nothing"
        )
    return AnswerCache(Path(text) if text else _usual_folder(), most_mb)


def key_of(what: str, of: Sequence[object]) -> str:
    """Return the name under which an answer is kept: SHA-256 of the question and all that the answer depends on."""
    return hashlib.sha256(pack((what, tuple(of), versions()))).hexdigest()


def file_identity(path: Path, data: bytes) -> tuple[str, str]:
    """Return what an answer about a file depends on: its bytes, by SHA-256, and its name, which messages contain."""
    return (sha256_of(data), path.name)


def _usual_folder() -> Path | None:
    """Return the folder for caches of this user on this system; None without a home folder."""
    try:
        home = Path.home()
    except RuntimeError:
        return None
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA") or home / "AppData" / "Local") / "wpcal" / "cache"
    if sys.platform == "darwin":
        return home / "Library" / "Caches" / "wpcal"
    stated = Path(os.environ.get("XDG_CACHE_HOME", ""))
    return (stated if stated.is_absolute() else home / ".cache") / "wpcal"


def _write_unnamed(path: Path, data: bytes) -> bool:
    """Write a file that gets its name when it is whole: of a process that is killed nothing stays.

    False if the system or the file system cannot.
    """
    if not hasattr(os, "O_TMPFILE"):
        return False
    try:
        descriptor = os.open(path.parent, os.O_TMPFILE | os.O_WRONLY, 0o600)
    except OSError as error:
        if error.errno in _NO_UNNAMED:
            return False
        raise
    with os.fdopen(descriptor, "wb") as file:
        file.write(data)
        file.flush()
        for _ in range(2):
            try:
                os.link(f"/proc/self/fd/{descriptor}", path, src_dir_fd=descriptor, follow_symlinks=True)
            except FileExistsError:  # a damaged one, or another process was first
                path.unlink(missing_ok=True)
            except FileNotFoundError:  # a system without /proc
                return False
            else:
                return True
    return True


def _write_renamed(path: Path, data: bytes) -> None:
    descriptor, new = tempfile.mkstemp(suffix=NEW_SUFFIX, dir=path.parent)
    try:
        with os.fdopen(descriptor, "wb") as file:
            file.write(data)
        os.replace(new, path)
    except BaseException:
        with suppress(OSError):
            os.unlink(new)
        raise


def _head(key: str, packet: bytes) -> bytes:
    return _HEAD + f"{key}\n{hashlib.sha256(packet).hexdigest()}\n".encode("ascii")


def _read(path: Path, key: str) -> bytes | None:
    """Return the packet in a file of this user; None if there is none, or it is not what was written."""
    try:
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_BINARY", 0))
        with os.fdopen(descriptor, "rb") as file:
            found = os.fstat(descriptor)
            if not stat.S_ISREG(found.st_mode) or (hasattr(os, "geteuid") and found.st_uid != os.geteuid()):
                return None
            data = file.read()
    except OSError:
        return None
    head = len(_head(key, b""))
    if data[:head] != _head(key, data[head:]):
        return None
    with suppress(OSError):
        os.utime(path)  # used now
    return data[head:]


def _remove_oldest(folder: Path, most_bytes: float) -> None:
    """Remove the answers that were not used for the longest time, until the others are within the limit."""
    kept = []
    for entry in os.scandir(folder):
        with suppress(OSError):  # another process may have removed it
            found = entry.stat(follow_symlinks=False)
            if entry.name.endswith(SUFFIX):
                kept.append((found.st_mtime, found.st_size, entry.path))
            elif entry.name.endswith(NEW_SUFFIX) and time.time() - found.st_mtime > ABANDONED_S:
                os.unlink(entry.path)
    total = sum(size for _, size, _ in kept)
    for _, size, path in sorted(kept):
        if total <= most_bytes:
            return
        with suppress(OSError):
            os.unlink(path)
        total -= size


HERE: ContextVar[AnswerCache | None] = ContextVar("here", default=None)
"""Where answers are kept if commands work with the kernel in this process."""


@contextmanager
def kernel_in_this_process(cache: AnswerCache) -> Iterator[None]:
    """Let commands that run inside work with the kernel here: this process is a child of another one already.

    `cache`: Where their answers are kept.
    """
    before = HERE.set(cache)
    try:
        yield
    finally:
        HERE.reset(before)


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
