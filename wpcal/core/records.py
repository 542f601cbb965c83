"""Versioned JSON records and files that appear whole or not at all."""

from __future__ import annotations

import errno
import json
import os
import secrets
from collections.abc import Collection, Iterator, Mapping
from contextlib import contextmanager, suppress
from functools import cache
from json.encoder import encode_basestring
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.core.errors import ErrorCode, FormatError, InputError
from wpcal.core.input_file import read_bytes, require_name
from wpcal.core.record_check import check_record
from wpcal.core.whole_folder import MARK, flush, put_in_place, temporary_sibling


def to_json(record: Mapping[str, Any]) -> str:
    """Write a record as JSON: keys in the order given, arrays as lists, no NaN, one newline at the end.

    Numbers are written with all their digits (the shortest text that reads back to the same float64).
    """
    return _text(record, "\n") + "\n"


def _text(value: Any, line: str) -> str:
    """Return a value as ``json.dumps(value, indent=1)`` does; `line` begins a line at its depth.

    With an indent, the standard library passes every number up through as many generators as it is deep. This takes
    half of that time, which counts for the seams of a large part.
    """
    kind = type(value)
    if kind is float:
        if value - value != 0.0:
            raise ValueError(f"{value} is not JSON compliant")
        return repr(value)
    if kind is list or kind is tuple or kind is dict:
        within, brackets = f"{line} ", "{}" if kind is dict else "[]"
        if kind is dict:
            texts = [f"{_key(key)}: {_text(item, within)}" for key, item in value.items()]
        else:
            texts = [
                repr(item) if type(item) is float and item - item == 0.0 else _text(item, within) for item in value
            ]
        return f"{brackets[0]}{within}{f',{within}'.join(texts)}{line}{brackets[1]}" if texts else brackets
    if isinstance(value, np.ndarray | np.generic):
        return _text(value.tolist(), line)
    if kind is str:
        return encode_basestring(value)
    if value is None or isinstance(value, str | int | float):
        return json.dumps(value, ensure_ascii=False, allow_nan=False)
    if isinstance(value, Mapping):
        return _text(dict(value), line)
    raise TypeError(f"a record cannot hold a {kind.__name__}")


@cache
def _key(key: str) -> str:
    return json.dumps(key, ensure_ascii=False)


def read_json(path: Path, *, schema: str) -> dict[str, Any]:
    """Read a record and check it against its schema (`wpcal.core.record_check`).

    Parameters
    ----------
    path : Path
    schema : str
        Name and version, for example ``wpcal/calibration/1``.

    Raises
    ------
    InputError
        When the file cannot be opened.
    FormatError
        When it is not a JSON object, is of another schema, or a value is not what the schema says.
    """
    record = parse_json(read_bytes(path), path=str(path))
    found = record.get("schema") if isinstance(record, dict) else None
    if not isinstance(record, dict) or found != schema:
        what = f"expected a record of schema {schema}, found {found if isinstance(found, str) else 'none'}"
        raise FormatError(what, path=str(path))
    check_record(record, schema, path=str(path))
    return record


def parse_json(raw: bytes, *, path: str) -> Any:
    """Return the value that the bytes of a JSON file hold. Its numbers and texts are not checked.

    Parameters
    ----------
    raw : bytes
        UTF-8, also with a byte order mark.
    path : str
        Name of the file in messages.

    Raises
    ------
    FormatError
        When it is not JSON.
    """
    try:
        return json.loads(raw.decode("utf-8-sig"))
    except UnicodeDecodeError:
        raise FormatError("is not a UTF-8 text file", path=path) from None
    except json.JSONDecodeError as error:
        raise FormatError(f"is not JSON: {error.msg}", path=path, line=error.lineno, column=error.colno) from None
    except RecursionError:
        raise FormatError("has too many lists or objects in one another", path=path) from None
    except ValueError:  # Python refuses to convert it
        raise FormatError("holds a whole number of thousands of digits", path=path) from None


@contextmanager
def new_directory(path: Path, *, overwrite: bool, head: str = "", leave_out: Collection[str] = ()) -> Iterator[Path]:
    """Fill a temporary folder, and put it in its place as a whole when all files are written.

    Parameters
    ----------
    path : Path
        The folder as the user named it. Other files in it are kept.
    overwrite : bool
        Whether to write into an existing folder that is not empty.
    head : str
        The file without which a reader has no result (`wpcal.core.whole_folder`).
    leave_out : collection of str
        Files in the folder that are not kept: an earlier run wrote them.

    Yields
    ------
    Path
        A temporary folder on the same file system.

    Raises
    ------
    InputError
        When the folder is not empty and `overwrite` is false, or it cannot be written, or has a folder under the name
        of a file to write. In all these cases nothing is replaced.
    """
    check_writable(path, overwrite=overwrite)
    place = Path(os.path.realpath(path))
    try:
        place.parent.mkdir(parents=True, exist_ok=True)
        with temporary_sibling(place) as folder:
            yield folder
            put_in_place(folder, place, overwrite=overwrite, head=head, leave_out=leave_out)
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {(error.strerror or str(error)).lower()}") from None


def check_writable(path: Path, *, overwrite: bool) -> None:
    """Refuse an output folder that cannot be used, before any work is done.

    Raises
    ------
    InputError
        When the path is a file, or a folder that is not empty and `overwrite` is false, or it cannot be written.
    """
    require_name(path)
    require_place(path)
    if path.exists() and not path.is_dir():
        raise InputError(f"{path}: is a file, expected a folder to write into")
    if path.is_dir() and any(path.iterdir()) and not overwrite:
        what = "exists and is not empty; allow overwriting to write into it"
        raise InputError(f"{path}: {what}", code=ErrorCode.EXISTS)


def require_place(path: Path) -> None:
    """Refuse a path at which this user cannot make a file, as on a disk mounted read-only, before any work is done.

    Raises
    ------
    InputError
        When the nearest folder that exists is not a folder, or cannot be written.
    """
    folder = next(each for each in Path(os.path.realpath(path)).parents if each.exists())
    if not folder.is_dir():
        reason = errno.ENOTDIR
    elif os.access(folder, os.W_OK | os.X_OK):
        return
    else:
        is_read_only = hasattr(os, "statvfs") and os.statvfs(folder).f_flag & os.ST_RDONLY
        reason = errno.EROFS if is_read_only else errno.EACCES
    what = f"{path}: cannot be written: {os.strerror(reason).lower()}; choose another place"
    raise InputError(what, code=ErrorCode.PLACE_UNWRITABLE)


def write_file(path: Path, data: str | bytes, *, overwrite: bool) -> None:
    """Write one file under a temporary name and rename it, so that a reader never finds half of it.

    The temporary name cannot be foreseen, and no link of that name is followed. The file is on the disk when this
    returns.

    Raises
    ------
    InputError
        When it exists and `overwrite` is false, or it cannot be written.
    """
    require_name(path)
    exists = InputError(f"{path}: exists; allow overwriting to replace it", code=ErrorCode.EXISTS)
    if path.exists() and not overwrite:
        raise exists
    temporary = path.with_name(f"{MARK}{secrets.token_hex(8)}.part")
    try:
        with temporary.open("xb") as file:
            file.write(data.encode("utf-8") if isinstance(data, str) else data)
        flush(temporary)
        if overwrite or not _linked(temporary, path):
            os.replace(temporary, path)
        flush(path.parent)
    except FileExistsError:
        raise exists from None
    except OSError as error:
        raise InputError(f"{path}: cannot be written: {(error.strerror or str(error)).lower()}") from None
    finally:
        with suppress(OSError):
            temporary.unlink()


def _linked(temporary: Path, path: Path) -> bool:
    """Give a file its name unless another file has it by now. False on a file system without links.

    Raises
    ------
    FileExistsError
        When another process wrote the file meanwhile.
    """
    try:
        os.link(temporary, path)
    except FileExistsError:
        raise
    except OSError:
        return False
    return True
