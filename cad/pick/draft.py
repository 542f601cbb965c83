"""The draft beside the table: every change of the page, on disk before the page hears that it is kept.

The file ``taught.csv.draft`` holds the rows of ``taught.csv`` that were typed and not saved yet, and those that still
lack coordinates. When the table holds every row, the draft holds none; it still names the part on which they were
taught. It is replaced as a whole, so that a killed server leaves the draft before or after a change.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from cad.session.rows import Rows
from cad.workpiece.moving import MovingChoice
from wpcal.core.errors import FormatError, InputError, WpcalError
from wpcal.core.input_file import read_bytes
from wpcal.core.records import read_json, to_json

DRAFT_SCHEMA = "wpcal/pick-draft/1"
KEPT_ENDINGS = (".draft", ".bak")
"""A table with such a name could take the place of another table's draft or last version."""


@dataclass(frozen=True, slots=True)
class Keyed:
    """Rows with an identity, so that the edits of two windows can be merged."""

    rows: Rows
    keys: tuple[str, ...]  #: One per row, all different. A row keeps its key when its cells change.

    @classmethod
    def from_record(cls, record: Any) -> Keyed:
        """Return what a page or a draft holds.

        Raises `InputError` when it is not a table of taught points, or its keys do not fit.
        """
        rows = Rows.from_record(record)
        keys = record.get("keys")
        if not isinstance(keys, list) or not all(isinstance(key, str) and key for key in keys):
            raise InputError("expected a key of text for every row")
        if len(keys) != len(rows.cells) or len(set(keys)) < len(keys):
            raise InputError(f"expected {len(rows.cells)} different keys, one per row, got {len(keys)}")
        return cls(rows, tuple(keys))

    @classmethod
    def of_rows(cls, rows: Rows) -> Keyed:
        """Give new keys to rows that come from a file."""
        batch = os.urandom(4).hex()
        return cls(rows, tuple(f"{batch}-{index}" for index in range(len(rows.cells))))

    def to_record(self) -> dict[str, Any]:
        """Return plain values."""
        return {**self.rows.to_record(), "keys": list(self.keys)}


@dataclass(frozen=True, slots=True)
class Draft:
    """A table that is being edited."""

    table: Keyed
    part_name: str  #: File name of the part.
    part_sha256: str  #: Hash of the part's file.
    #: Hash of the saved table from which the draft was made; None if there was no saved table.
    file_sha256: str | None = None
    moving: MovingChoice = field(default_factory=MovingChoice)  #: Whether bodies may have moved.

    def without_rows(self) -> Draft:
        """Return the draft of a table that is saved completely: it names the part."""
        return replace(self, table=Keyed(replace(self.table.rows, cells=()), ()))

    def to_json(self) -> str:
        """Return the text of the draft's file."""
        part = {"file": self.part_name, "sha256": self.part_sha256}
        table = self.table.to_record()
        moving = {} if self.moving == MovingChoice() else {"bodies": self.moving.to_record()}
        head = {"schema": DRAFT_SCHEMA, "part": part, "file_sha256": self.file_sha256, **moving}
        return to_json({**head, "table": table})


def draft_of(out: Path) -> Path:
    """Return where the draft of a table is."""
    return out.with_name(f"{out.name}.draft")


def backup_of(out: Path) -> Path:
    """Return where the version before the last Save is kept."""
    return out.with_name(f"{out.name}.bak")


def read_draft(path: Path) -> Draft:
    """Read a draft. Raises `InputError` when it cannot be opened. Raises `FormatError` when it is damaged."""
    record = read_json(path, schema=DRAFT_SCHEMA)
    try:
        texts = (record["part"]["file"], record["part"]["sha256"], record["file_sha256"] or "")
        file, part_sha256, file_sha256 = (_text(text) for text in texts)
        moving = MovingChoice.from_record(record["bodies"]) if "bodies" in record else MovingChoice()
        return Draft(Keyed.from_record(record["table"]), file, part_sha256, file_sha256 or None, moving)
    except (KeyError, TypeError, InputError) as error:
        what = str(error) if isinstance(error, WpcalError) else f"lacks {error}"
        raise FormatError(f"is not a draft of the picker: {what}", path=str(path)) from None


def _text(value: object) -> str:
    if not isinstance(value, str):
        raise InputError("expected names and hashes as text")
    return value


def set_aside(path: Path) -> Path:
    """Rename a file to the first free name with ``.damaged`` and a number, and return that name."""
    names = (path.with_name(f"{path.name}.damaged{count or ''}") for count in range(10_000))
    free = next(name for name in names if not os.path.lexists(name))
    try:
        os.replace(path, free)
    except OSError as error:
        raise InputError(f"{path}: cannot be renamed: {(error.strerror or str(error)).lower()}") from None
    return free


def is_read_only(path: Path) -> bool:
    """Tell whether a file is there and must not be replaced; renaming another file over it would not ask."""
    return path.exists() and (not path.stat().st_mode & 0o222 or not os.access(path, os.W_OK))


def require_table_name(out: Path) -> None:
    """Refuse a name that the file system cannot give to the table, its draft and its last version.

    Raises `InputError` when it is too long, or contains NUL.
    """
    try:
        os.stat(_beside(out), follow_symlinks=False)
    except FileNotFoundError:
        pass
    except (OSError, ValueError) as error:
        raise _unwritable(out, error) from None


def _beside(out: Path) -> Path:
    """Return a new name, as long as that of any file beside the table."""
    return out.with_name(f"{draft_of(out).name}.{os.urandom(4).hex()}")


def _unwritable(out: Path, error: Exception) -> InputError:
    reason = (getattr(error, "strerror", None) or str(error)).lower()
    return InputError(f"{out}: cannot be written: {reason}; give -o and another table")


def require_table_room(out: Path) -> None:
    """Refuse a table beside which no draft can be written, before a person types anything.

    Raises `InputError` when no file can be made there, or none with such a name.
    """
    probe = _beside(out)
    try:
        probe.open("xb").close()
        probe.unlink()
    except OSError as error:
        raise _unwritable(out, error) from None


def bytes_of(path: Path) -> bytes | None:
    """Return the bytes of a file, or None if there is no such file. Raises `InputError` when it cannot be read."""
    return read_bytes(path) if os.path.lexists(path) else None


@contextmanager
def alone_in(folder: Path) -> Iterator[None]:
    """Keep other pickers waiting while a draft is compared and replaced, where the system has locks on folders."""
    try:
        import fcntl

        handle = os.open(folder, os.O_RDONLY)
    except (ImportError, OSError):
        yield
        return
    try:
        with suppress(OSError):
            fcntl.flock(handle, fcntl.LOCK_EX)
        yield
    finally:
        os.close(handle)
