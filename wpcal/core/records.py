"""Versioned JSON records and files that appear whole or not at all."""

from __future__ import annotations

import errno
import json
import math
import os
from collections.abc import Callable, Collection, Hashable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from itertools import chain, islice
from json.encoder import encode_basestring, encode_basestring_ascii
from pathlib import Path
from types import NoneType
from typing import Any

import numpy as np

from wpcal.core.errors import ErrorCode, FormatError, InputError
from wpcal.core.input_file import read_bytes, require_name
from wpcal.core.record_check import check_record
from wpcal.core.whole_folder import flush, put_in_place, temporary_name, temporary_sibling

MOST_AT_ONCE = 16  #: Lists of at most this many items are written by one format for all of them.
MOST_TOGETHER = 512  #: Items of lists that are written together: the texts of all numbers of 4000 seams are 250 MB.


def to_json(record: Mapping[str, Any]) -> str:
    """Write a record as JSON: keys in the order given, arrays as lists, no NaN, one newline at the end.

    Numbers are written with all their digits (the shortest text that reads back to the same float64).
    """
    return "".join(json_parts(record))


def json_parts(record: Mapping[str, Any]) -> Iterator[str]:
    """Yield the text of `to_json` in parts: that of a large part is 100 MB, which a file can take piece by piece."""
    head = "{"
    for name, value in record.items():
        yield f"{head}\n {_key(name, is_ascii=False)}: "
        head = ","
        if isinstance(value, list) and len(value) > MOST_TOGETHER:
            for row in range(0, len(value), MOST_TOGETHER):
                texts = _texts(value[row : row + MOST_TOGETHER], "\n  ")
                yield ("," if row else "[") + ",".join([f"\n  {text}" for text in texts])
            yield "\n ]"
        else:
            yield _texts([value], "\n ")[0]
    yield "\n}\n" if record else "{}\n"


def to_compact_json(value: Any) -> str:
    """Write a value as JSON in ASCII without blanks and line ends; the rest as in `to_json`."""
    return _texts([value], "")[0]


def _texts(values: Sequence[Any], line: str) -> list[str]:
    """Return each of some values as ``json.dumps(value, indent=1)`` does; `line` begins a line at their depth.

    If `line` is empty, the texts are compact and in ASCII.

    With an indent, the standard library passes every number up through as many generators as it is deep. Here all
    values at the same place of a record are written together, which takes a fifth of that time. That counts for the
    seams of a large part.
    """
    kinds = set(map(type, values))
    if len(kinds) > 1:
        return _sorted_out(values, list(map(type, values)), line)
    return _WRITERS.get(kinds.pop(), _other_texts)(values, line) if kinds else []


def _sorted_out(values: Sequence[Any], sorts: Sequence[Hashable], line: str) -> list[str]:
    """Return the texts of values of several sorts: those of each sort are written together."""
    rows: dict[Hashable, list[int]] = {}
    for row, sort in enumerate(sorts):
        rows.setdefault(sort, []).append(row)
    texts = [""] * len(values)
    for same in rows.values():
        for row, text in zip(same, _texts([values[row] for row in same], line), strict=True):
            texts[row] = text
    return texts


def _dict_texts(values: Sequence[dict[str, Any]], line: str) -> list[str]:
    names = list(map(tuple, values))
    if len(set(names)) > 1:
        return _sorted_out(values, names, line)
    if not names[0]:
        return ["{}"] * len(values)
    within, colon = (f"{line} ", ": ") if line else ("", ":")
    columns = zip(*map(dict.values, values), strict=True)
    heads = (f"{_key(name, is_ascii=not line)}{colon}".replace("%", "%%") for name in names[0])
    form = f"{{{within}{f',{within}'.join([f'{head}%s' for head in heads])}{line}}}"
    return [form % row for row in zip(*(_texts(column, within) for column in columns), strict=True)]


def _list_texts(values: Sequence[Sequence[Any]], line: str) -> list[str]:
    within, lengths = f"{line} " if line else "", list(map(len, values))
    every = list(chain.from_iterable(values))
    rounds = (every[row : row + MOST_TOGETHER] for row in range(0, len(every), MOST_TOGETHER))
    items = chain.from_iterable(_texts(some, within) for some in rounds)
    if len(set(lengths)) == 1 and 0 < lengths[0] <= MOST_AT_ONCE:
        form = f"[{within}{f',{within}'.join(['%s'] * lengths[0])}{line}]"
        return [form % row for row in zip(*[items] * lengths[0], strict=True)]
    return [f"[{within}{f',{within}'.join(islice(items, n))}{line}]" if n else "[]" for n in lengths]


def _float_texts(values: Sequence[float], _line: str) -> list[str]:
    if not math.isfinite(sum(values)) and not all(map(math.isfinite, values)):
        raise ValueError("a number that is not finite is not JSON compliant")
    distinct = set(values)
    if 2 * len(distinct) > len(values):
        return list(map(repr, values))
    texts = dict(zip(distinct, map(repr, distinct), strict=True))  # along a straight seam axes and angles are the same
    return [texts[value] if value else repr(value) for value in values]  # 0.0 equals -0.0, which has another text


def _other_texts(values: Sequence[Any], line: str) -> list[str]:
    """Return the texts of values of another type than those that JSON has."""
    value = values[0]
    if isinstance(value, np.ndarray | np.generic):
        return _texts([each.tolist() for each in values], line)
    if isinstance(value, str | int | float):
        return [json.dumps(each, ensure_ascii=not line, allow_nan=False) for each in values]
    if isinstance(value, Mapping):
        return _texts(list(map(dict, values)), line)
    raise TypeError(f"a record cannot hold a {type(value).__name__}")


_WRITERS: dict[type, Callable[[Sequence[Any], str], list[str]]] = {
    float: _float_texts,
    int: lambda values, _: list(map(repr, values)),
    str: lambda values, line: list(map(encode_basestring if line else encode_basestring_ascii, values)),
    bool: lambda values, _: ["true" if value else "false" for value in values],
    NoneType: lambda values, _: ["null"] * len(values),
    dict: _dict_texts,
    list: _list_texts,
    tuple: _list_texts,
}
"""What writes values of one type."""


@cache
def _key(key: str, *, is_ascii: bool) -> str:
    return json.dumps(key, ensure_ascii=is_ascii)


def read_json(path: Path, *, schema: str) -> dict[str, Any]:
    """Read a record and check it against its schema (`wpcal.core.record_check`).

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when it is not a JSON object, is of another schema, or a value is not what the schema says.
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

    Raises `FormatError` when it is not JSON.
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

    Raises `InputError` when the folder is not empty and `overwrite` is false, or it cannot be written, or has a folder
    under the name of a file to write. In all these cases nothing is replaced.
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

    Raises `InputError` when the path is a file, or a folder that is not empty and `overwrite` is false, or it cannot be
    written.
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

    Raises `InputError` when the nearest folder that exists is not a folder, or cannot be written.
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

    Raises `InputError` when it exists and `overwrite` is false, or it cannot be written.
    """
    require_name(path)
    exists = InputError(f"{path}: exists; allow overwriting to replace it", code=ErrorCode.EXISTS)
    if path.exists() and not overwrite:
        raise exists
    temporary = path.with_name(f"{temporary_name()}.part")
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

    Raises `FileExistsError` when another process wrote the file meanwhile.
    """
    try:
        os.link(temporary, path)
    except FileExistsError:
        raise
    except OSError:
        return False
    return True
