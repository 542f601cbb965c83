"""Read the files that a user names: regular files up to a size limit, under names that can be written down.

Every reader gets its bytes here. A pipe could keep a command waiting for ever, and a link to a device without an end
would fill the memory; both are refused before anything is read.
"""

from __future__ import annotations

import hashlib
import os
import stat
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager, suppress
from contextvars import ContextVar
from difflib import get_close_matches
from pathlib import Path

from wpcal.core.errors import InputError

LIMIT_VARIABLE = "WPCAL_MOST_MB"  #: Environment variable that replaces the size limits below, MB.
MOST_MB = 200.0  #: Tables, programs, records and meshes. The seams of a structure of 30 000 faces take 25 MB.
MOST_STEP_MB = 2000.0  #: STEP files. The largest real part that was tried has 170 MB.
BYTES_PER_MB = 1_000_000
NEAR_NAME = 0.75
"""Likeness (of `difflib`) from which a name is a slip of another one: hoper.step of hopper.step has 0.95."""
STDIN = "-"  #: As the name of a file: standard input.
_NOTED: ContextVar[Callable[[Path, bytes], None] | None] = ContextVar("_NOTED", default=None)
"""Notes files that are read."""
_OWN = Path(__file__).parents[1]
"""Files in it belong to the version of wpcal."""
_KINDS = {
    stat.S_IFDIR: "is a folder",
    stat.S_IFIFO: "is a pipe",
    stat.S_IFSOCK: "is a socket",
    stat.S_IFCHR: "is a device",
    stat.S_IFBLK: "is a device",
}


@contextmanager
def noted_files(known: Iterable[tuple[str, str]] = ()) -> Iterator[dict[str, str]]:
    """Note the files that are read as a whole while the block runs: SHA-256 by the name under which each is opened.

    Results depend on them, also on those that a file names: the arms of a cell, both files of a run of touches. Files
    of wpcal itself are not noted. What is noted of a file holds for all that is made of it: a file that is changed
    between two readings is refused, also if it is changed back later.

    Raises `InputError` at the end of the block, when a file had other contents when it was read once more.
    """
    noted: dict[str, str] = {}
    expected, changed = {str(Path(name)): sha256 for name, sha256 in known}, set[str]()

    def note(path: Path, data: bytes) -> None:
        name, sha256 = str(path), sha256_of(data)
        if sha256 != expected.setdefault(name, sha256):
            changed.add(name)
        noted.setdefault(name, sha256)

    token = _NOTED.set(note)
    try:
        yield noted
    finally:
        _NOTED.reset(token)
    if changed:
        raise InputError(f"{min(changed)}: was changed while it was read; run this again")


def read_bytes(path: Path, *, most_mb: float = MOST_MB, first: int | None = None, expected: str = "a file") -> bytes:
    """Return the bytes of a file.

    Raises `InputError` when it cannot be opened, is not a regular file, is larger than the limit, or its name is not
    UTF-8 text.
    """
    data = _read(path, _limit_mb(most_mb), first, expected)
    note = _NOTED.get()
    if note is not None and first is None and _OWN not in path.parents:
        note(path, data)
    return data


def _read(path: Path, most: float, first: int | None, expected: str) -> bytes:
    require_name(path)
    try:
        if str(path) == STDIN:
            return _within(sys.stdin.buffer.read(int(most * BYTES_PER_MB) + 1), path, most)
        _require_regular(path, path.stat().st_mode, expected)  # opening some devices has effects
        descriptor = os.open(path, os.O_RDONLY | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0))
        with os.fdopen(descriptor, "rb") as file:
            found = os.fstat(descriptor)
            _require_regular(path, found.st_mode, expected)
            if found.st_size > most * BYTES_PER_MB:
                raise InputError(f"{path}: has {found.st_size / BYTES_PER_MB:.4g} MB, {_over(most)}")
            if first is not None:
                return file.read(first)
            data = file.read(int(most * BYTES_PER_MB) + 1)
    except FileNotFoundError as error:
        raise InputError(f"{path}: {(error.strerror or str(error)).lower()}{_near(path)}") from None
    except OSError as error:
        raise InputError(f"{path}: {(error.strerror or str(error)).lower()}") from None
    return _within(data, path, most)  # it may have grown, or its file system does not know its size


def _near(path: Path) -> str:
    """Return the file of the same folder that was probably meant, as the end of a message."""
    try:
        names = {entry.name.lower(): entry.name for entry in path.parent.iterdir()}
    except OSError:
        return ""
    found = get_close_matches(path.name.lower(), names, n=1, cutoff=NEAR_NAME)
    return f"; did you mean {path.with_name(names[found[0]])}?" if found else ""


def _within(data: bytes, path: Path, most: float) -> bytes:
    if len(data) > most * BYTES_PER_MB:
        raise InputError(f"{path}: has more than {most:g} MB, {_over(most)}")
    return data


def sha256_of(data: bytes) -> str:
    """Return the SHA-256 of what was read from a file, hexadecimal: a second reading may find other bytes."""
    return hashlib.sha256(data).hexdigest()


def sha256_of_own(path: Path) -> str:
    """Return the SHA-256 of a file that this process wrote, hexadecimal, without holding its bytes."""
    with path.open("rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def require_name(path: Path) -> None:
    """Refuse a path that no file can have, or whose name cannot be written into a record.

    Raises `InputError` when the path is not UTF-8 text, holds a null character, or is too long for the file system.
    """
    shown = os.fsencode(path).decode("utf-8", errors="backslashreplace")
    try:
        str(path).encode("utf-8")
        with suppress(FileNotFoundError, NotADirectoryError, PermissionError):
            os.lstat(path)
    except UnicodeEncodeError:
        raise InputError(f"{shown}: the name is not UTF-8 text; rename the file or the folder") from None
    except ValueError:
        what = "the name holds a null character"
        raise InputError(f"{shown!r}: {what}") from None
    except OSError as error:
        raise InputError(f"{shown}: {(error.strerror or str(error)).lower()}") from None


def holds_file(folder: Path, name: str) -> bool:
    """Tell whether a folder holds a file that another file names; False for a name that no file can have."""
    try:
        return Path(name).name == name and (folder / name).is_file()
    except (OSError, ValueError):  # too long, or not text that a name can be
        return False


def require_folder(path: Path, expected: str) -> None:
    """Raise `InputError` unless there is a folder; `expected` says what it should hold."""
    if not path.is_dir():
        raise InputError(f"{path}: {'is not a' if path.exists() else 'no such'} folder; expected {expected}")


def is_same_file(one: Path, other: Path) -> bool:
    """Tell whether two paths lead to one file that is there."""
    return one.exists() and other.exists() and one.samefile(other)


def _require_regular(path: Path, mode: int, expected: str) -> None:
    if not stat.S_ISREG(mode):
        kind = _KINDS.get(stat.S_IFMT(mode), "is not a regular file")
        what = f"{kind}, expected {expected}"
        if kind == "is a pipe":
            what += "; write its data to a file and give that"
        raise InputError(f"{path}: {what}")


def _limit_mb(usual: float) -> float:
    text = os.environ.get(LIMIT_VARIABLE, "")
    if not text:
        return usual
    if not (text.isascii() and text.isdigit() and int(text[:10]) > 0 and len(text) < 10):
        raise InputError(f"{LIMIT_VARIABLE}: expected a size in MB as a whole number, got {text!r}")
    return float(text)


def _over(most: float) -> str:
    return f"more than the limit of {most:g} MB; to read it, set the environment variable {LIMIT_VARIABLE}"
