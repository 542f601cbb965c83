"""Put a finished folder in the place of another as a whole, so that a reader finds all old files or all new ones.

Where the system can exchange two folders in one step (Linux and macOS, most file systems), it does. Where it cannot (a
mount point, a folder in which this process works, other systems), the files are replaced one by one. The first name of
`new_names` is then removed first and written last: without it a reader has no result.
"""

from __future__ import annotations

import ctypes
import errno
import os
import secrets
import shutil
import sys
import time
from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager, suppress
from enum import Enum, auto
from pathlib import Path

from wpcal.core.errors import ErrorCode, InputError

try:
    import fcntl
except ImportError:  # Windows
    fcntl = None  # type: ignore[assignment]

MARK = ".wpcal-"  #: Start of the names of temporary files and folders. The rest cannot be foreseen.
ABANDONED_S = 60.0  #: A younger folder may belong to a run that has not locked it yet.
_AT_FDCWD, _RENAME_EXCHANGE = -100, 2
_RENAME_SWAP = 2
_NO_EXCHANGE = (errno.ENOSYS, errno.EINVAL, errno.EBUSY, errno.EXDEV, errno.ENOTSUP, errno.EPERM)
"""Errors of a system or a place that cannot exchange folders."""
_NOT_EMPTY = (errno.ENOTEMPTY, errno.EEXIST)
_NOT_WRITTEN = (errno.EIO, errno.ENOSPC, errno.EDQUOT)
"""Errors that say that the disk does not have the data. Some file systems tell them only now."""


_flushes = True


def flush_later() -> None:
    """Leave it to the system when data of this process goes to the disk.

    For results that are checked by their hashes before anything is left undone because of them, and that another
    process flushes together with `flush_all`.
    """
    global _flushes  # noqa: PLW0603 - a property of the process, as its current folder is
    _flushes = False


@contextmanager
def flushed_later() -> Iterator[None]:
    """Do as `flush_later` says while a block runs."""
    global _flushes  # noqa: PLW0603 - as in `flush_later`
    before, _flushes = _flushes, False
    try:
        yield
    finally:
        _flushes = before


_tell_before_replacing: Callable[[], object] | None = None


def call_before_replacing(tell: Callable[[], object]) -> None:
    """Let this process call a function each time before it puts files in place: what is asked to stop is asked before.

    Whoever can interrupt the work must not do it any more when the function has returned.
    """
    global _tell_before_replacing  # noqa: PLW0603 - as in `flush_later`
    _tell_before_replacing = tell


def begin_replacing() -> None:
    """Tell that files are put in place now (`call_before_replacing`)."""
    if _tell_before_replacing is not None:
        _tell_before_replacing()


def flush_all(folder: Path) -> None:
    """Let the system write everything of the file system of a folder to the disk."""
    library = ctypes.CDLL(None) if os.name == "posix" else None
    if library is None or not hasattr(library, "syncfs"):
        _flush_tree(folder)
        return
    descriptor = os.open(folder, os.O_RDONLY)
    try:
        library.syncfs(descriptor)
    finally:
        os.close(descriptor)


def temporary_name() -> str:
    """Return a name that nobody can foresee; it begins with `MARK` and the number of this process."""
    return f"{MARK}{os.getpid():08x}{secrets.token_hex(4)}"


def remove_left_by(process: int, *places: Path) -> None:
    """Remove the temporary files and folders of a process that was killed, in some folders and beside them."""
    for folder in {each for place in places for each in (place.resolve(), place.resolve().parent)}:
        for left in folder.glob(f"{MARK}{process:08x}*"):
            _remove(left)


def _remove(left: Path) -> None:
    if left.is_dir() and not left.is_symlink():
        shutil.rmtree(left, ignore_errors=True)
    else:
        with suppress(OSError):
            left.unlink()


@contextmanager
def temporary_sibling(path: Path) -> Iterator[Path]:
    """Yield a new folder beside `path`, on the same file system; removed at the end with what it then holds."""
    _remove_abandoned(path.parent)
    folder = path.with_name(temporary_name())
    folder.mkdir()
    try:
        with _locked(folder):
            yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)


def put_in_place(new: Path, path: Path, *, overwrite: bool, head: str = "", leave_out: Collection[str] = ()) -> None:
    """Let a filled folder become `path`. What `path` holds under other names is kept.

    `head`: The file without which a reader has no result; by default the first by name.
    Raises `InputError` when `path` holds a folder under the name of a new file, or it holds files and `overwrite` is
    false, or another run is writing into it. Nothing was replaced.
    Raises `OSError` when the system refuses.
    """
    ours = sorted(_files_in(new), key=lambda name: (name != head, name))
    for name in ours:
        if (path / name).is_dir() and not (path / name).is_symlink():
            raise InputError(f"{path / name}: is a folder; wpcal writes a file of this name: move the folder away")
    if not overwrite or not path.is_dir():
        _flush_tree(new)
        begin_replacing()
        _rename_to_empty(new, path, ours)
        flush(path.parent)
        return
    not_kept = {*ours, *leave_out}
    _keep_others(path, new, not_kept)
    _flush_tree(new)
    with _locked(path) as lock:
        if lock is FolderLock.ANOTHERS:
            raise InputError(f"{path}: another run is writing into it now; its files are kept", code=ErrorCode.EXISTS)
        begin_replacing()
        if not _works_inside(path) and _exchange(new, path):
            flush(path.parent)
            _keep_others(new, path, not_kept)  # what somebody wrote meanwhile
        else:
            _replace_each(new, path, ours, leave_out)


def _files_in(folder: Path) -> Iterator[str]:
    for root, _, files in os.walk(folder):
        yield from (Path(root, file).relative_to(folder).as_posix() for file in files)


def _rename_to_empty(new: Path, path: Path, names: Sequence[str]) -> None:
    """Rename to a path where nothing is, or an empty folder. Of two runs at the same time the second is refused."""
    used = InputError(f"{path}: another run wrote into it meanwhile; its files are kept", code=ErrorCode.EXISTS)
    try:
        if path.is_dir():
            if sys.platform == "win32" or _works_inside(path) or path.is_mount():
                if any(path.iterdir()):
                    raise used
                _replace_each(new, path, names, ())
                return
            new.chmod(path.stat().st_mode)
        os.rename(new, path)
    except OSError as error:
        if error.errno not in _NOT_EMPTY:
            raise
        raise used from None


def _keep_others(old: Path, new: Path, not_kept: Collection[str], within: str = "") -> None:
    """Give `new` what `old` holds under other names. Files are linked, so that both folders have them."""
    for entry in os.scandir(old):
        source, target = Path(entry.path), new / entry.name
        if entry.is_dir(follow_symlinks=False):
            if not target.exists():
                target.mkdir()
                shutil.copystat(source, target)
            _keep_others(source, target, not_kept, f"{within}{entry.name}/")
        elif within + entry.name not in not_kept and not _is_same_file(source, target):
            target.unlink(missing_ok=True)
            _link(source, target)
    if not within:
        new.chmod(old.stat().st_mode)


def _is_same_file(first: Path, second: Path) -> bool:
    try:
        return os.path.samestat(first.lstat(), second.lstat())
    except FileNotFoundError:
        return False


def _link(source: Path, target: Path) -> None:
    try:
        os.link(source, target, follow_symlinks=False)
    except OSError:  # a file system without links
        shutil.copy2(source, target, follow_symlinks=False)


def _exchange(first: Path, second: Path) -> bool:
    """Exchange two folders in one step. False if this system or this place cannot."""
    if os.name != "posix":
        return False
    library = ctypes.CDLL(None, use_errno=True)
    one, two = os.fsencode(first), os.fsencode(second)
    if hasattr(library, "renameat2"):
        code = library.renameat2(_AT_FDCWD, one, _AT_FDCWD, two, _RENAME_EXCHANGE)
    elif hasattr(library, "renamex_np"):
        code = library.renamex_np(one, two, _RENAME_SWAP)
    else:
        return False
    if code == 0:
        return True
    number = ctypes.get_errno()
    if number in _NO_EXCHANGE:
        return False
    raise OSError(number, os.strerror(number))


def _works_inside(path: Path) -> bool:
    """Whether this process, and so most likely the user's shell, works in the folder: it must stay the same folder."""
    try:
        return Path.cwd().is_relative_to(path)
    except OSError:  # the current folder was removed
        return False


def _replace_each(new: Path, path: Path, names: Sequence[str], leave_out: Collection[str]) -> None:
    """Move the files one by one. Without the first of them, which comes last, a reader has no result."""
    for name in {*leave_out, *names[:1]}:
        (path / name).unlink(missing_ok=True)
    flush(path)
    for name in (*names[1:], *names[:1]):
        flush(path)
        (path / name).parent.mkdir(parents=True, exist_ok=True)
        os.replace(new / name, path / name)
    flush(path)


def _flush_tree(folder: Path) -> None:
    for root, _, files in os.walk(folder):
        for file in files:
            flush(Path(root, file))
        flush(Path(root))


def flush(path: Path) -> None:
    """Let the system write a file or the entries of a folder to the disk.

    Raises `OSError` when the disk does not take them.
    """
    if not _flushes:
        return
    try:
        descriptor = os.open(path, os.O_RDONLY)
        try:
            os.fsync(descriptor)
        finally:
            os.close(descriptor)
    except OSError as error:  # not every file system can, and on Windows a folder cannot be opened
        if error.errno in _NOT_WRITTEN:
            raise


class FolderLock(Enum):
    """Who holds the lock of a folder."""

    OURS = auto()
    ANOTHERS = auto()
    NONE = auto()  #: This system or file system has no locks.


@contextmanager
def _locked(folder: Path) -> Iterator[FolderLock]:
    """Hold the lock of a folder, if it is free."""
    if fcntl is None:
        yield FolderLock.NONE
        return
    try:
        descriptor = os.open(folder, os.O_RDONLY)
    except OSError:
        yield FolderLock.NONE
        return
    try:
        yield _take(descriptor)
    finally:
        os.close(descriptor)


def lock_taken(descriptor: int, wait_s: float, step_s: float) -> FolderLock:
    """Take the lock of a folder that is open, if it is free or becomes free soon; closing the folder releases it."""
    until = time.monotonic() + wait_s
    while (found := _take(descriptor)) is FolderLock.ANOTHERS and time.monotonic() < until:
        time.sleep(step_s)
    return found


def _take(descriptor: int) -> FolderLock:
    if fcntl is None:
        return FolderLock.NONE
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        return FolderLock.ANOTHERS
    except OSError:
        return FolderLock.NONE
    return FolderLock.OURS


def _remove_abandoned(parent: Path) -> None:
    """Remove what runs that were killed began to write: it is not new, and nobody holds the lock of a folder."""
    for left in parent.glob(MARK + "[0-9a-f]" * 16 + "*"):
        try:
            is_new = time.time() - left.lstat().st_mtime < ABANDONED_S
        except FileNotFoundError:
            continue
        if is_new or left.is_symlink():
            continue
        with _locked(left) as lock:
            if lock is FolderLock.OURS:
                _remove(left)
