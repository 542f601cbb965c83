"""The table that all windows of one picker share: changed, kept as a draft, saved.

A window states the revision on which its change is based. A change that is based on an older revision is refused with
the present table; the window merges both and sends the result. So no window takes back what another one typed.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from cad.pick.draft import (
    KEPT_ENDINGS,
    Draft,
    Keyed,
    alone_in,
    backup_of,
    bytes_of,
    draft_of,
    is_read_only,
    read_draft,
    set_aside,
)
from cad.session.part import PickPart
from cad.session.rows import Rows, is_shown, read_rows
from cad.workpiece.moving import MovingChoice
from wpcal.core.errors import ErrorCode, FormatError, InputError
from wpcal.core.input_file import is_same_file, sha256_of
from wpcal.core.records import write_file

FILE_CHANGED = "file-changed"  #: Code of the fault that the file is not the one that the page shows.
CONFLICT = "conflict"  #: Code of the fault that two windows changed a cell and nobody has chosen between the two texts.
FILE_READ_ONLY = "file-read-only"  #: Code of the fault that the file may not be written.


class FileChangedError(InputError):
    """The file to save is not the one from which the table was made."""

    code = FILE_CHANGED

    def __init__(self, message: str, *, sha256: str) -> None:
        super().__init__(message)
        self.sha256 = sha256


class ConflictError(InputError):
    """Two windows changed a cell, and the Save does not state that the person saw both texts."""

    code = CONFLICT


class SharedTable:
    """One table, its file and its draft. Its methods may be called from several threads."""

    def __init__(
        self,
        out: Path,
        part: PickPart,
        *,
        start: Keyed,
        file_sha256: str | None = None,
        draft: bytes | None = None,
        part_step: Path | None = None,
        command: Callable[[Path], str] = str,
        moving: MovingChoice | None = None,
    ) -> None:
        self.out = out
        self.moving = moving or MovingChoice()
        self.is_saved = False
        self._command = command
        self._part_name, self._part_sha256, self._part_step = part.file_name, part.sha256, part_step
        self._table, self._file_sha256, self._on_disk = start, file_sha256, draft
        self._revision = 1
        self._writer, self._alone_since = "", 1
        self._numbers: dict[str, int] = {}
        self._conflicts: dict[str, tuple[str, ...]] = {}
        self._lock = threading.Lock()

    def changes_since(self, revision: object) -> dict[str, Any]:
        """Return the revision, and the table if the window has an older one."""
        with self._lock, alone_in(self.out.parent):
            self._adopt()
            return {"revision": self._revision} if revision == self._revision else self._state()

    def keep(
        self, table: Keyed, *, revision: int, window: str, number: int, conflicts: Sequence[str] = ()
    ) -> dict[str, Any]:
        """Take a changed table and write the draft.

        `conflicts`: The cells in which the window put its own text in place of another window's, with both texts, as
        long as nobody has chosen between them. A Save of this window must name them.

        Returns: ``revision``; ``warning``: why the draft could not be written, or empty. For a stale change the present
        ``table`` and ``is_stale``.
        """
        with self._lock, alone_in(self.out.parent):
            self._adopt()
            if number <= self._numbers.get(window, -1):
                return {"revision": self._revision, "warning": ""}
            if not self._is_known(revision, window):
                return {**self._state(), "is_stale": True}
            self._numbers[window] = number
            self._conflicts[window] = tuple(conflicts)
            self._change(table, window)
            return {"revision": self._revision, "warning": self._store()}

    def save(
        self,
        *,
        revision: int,
        shown: int | None = None,
        window: str = "",
        consent: Sequence[str] = (),
        name: str = "",
        replaces: str = "",
    ) -> dict[str, Any]:
        """Write the complete rows as the file that `wpcal calibrate` reads, and keep the version before.

        Returns: ``file``; ``command`` that calibrates from it; ``rows``: how many were written; ``left_out``: names of
        the rows that lack a coordinate; ``backup``: where the version before is, or empty; ``warning``; ``revision``.
        ``has_news``: another window changed the table after `shown`. For an older revision than the present one the
        present ``table`` and ``is_stale``; then nothing is written.

        Raises `FileChangedError` when the file is not the one from which the table was made.
        Raises `ConflictError` when a conflict of the window is not in `consent`.
        Raises `InputError` when no row is complete, a cell cannot be read, or the file cannot be written. Nothing is
        written.
        """
        with self._lock, alone_in(self.out.parent):
            self._adopt()
            if revision != self._revision:
                return {**self._state(), "is_stale": True}
            if not set(self._conflicts.get(window, ())) <= set(consent):
                raise ConflictError("another window changed the same cells; choose between the texts first")
            has_news = shown is not None and not self._is_known(shown, window)
            rows = self._table.rows
            if not rows.complete():
                raise InputError("nothing to save: no row has all three coordinates")
            rows.to_taught()
            out = self._new_name(name) if name else self.out
            data = rows.to_csv().encode("utf-8")
            backup = self._write(out, data, replaces=replaces)
            before = self._draft()
            self._file_sha256, self.is_saved = sha256_of(data), True
            self._conflicts.pop(window, None)
            warning = self._move_to(out, before) if name else self._store()
            said = {"file": str(out), "command": self._command(out), "backup": backup, "warning": warning}
            return {**said, "has_news": has_news, "revision": self._revision, **_counts(rows)}

    def open_file(self) -> dict[str, Any]:
        """Take the rows of the file as it is now. The rows before are kept beside the draft, and in the page's Undo."""
        with self._lock, alone_in(self.out.parent):
            self._adopt()
            raw = bytes_of(self.out)
            if raw is None:
                raise InputError(f"{self.out}: no such file")
            found = Keyed.of_rows(read_rows(raw, path=str(self.out)))
            write_file(backup_of(draft_of(self.out)), self._draft().to_json(), overwrite=True)
            self._file_sha256 = sha256_of(raw)
            self._change(found, "")
            return {**self._state(), "warning": self._store()}

    def choose(self, moving: MovingChoice) -> dict[str, Any]:
        """Take whether bodies may have moved, and keep it in the draft. Return why that failed as ``warning``."""
        with self._lock, alone_in(self.out.parent):
            self._adopt()
            self.moving = moving
            return {"moving": moving.to_record(), "warning": self._store()}

    @property
    def rows(self) -> Rows:
        """The rows as they are now."""
        return self._table.rows

    @property
    def kept(self) -> str:
        """The draft's name if it holds rows that are not in the file, otherwise empty."""
        path = draft_of(self.out)
        return str(path) if path.exists() and not self._is_in_file() else ""

    def _is_known(self, revision: int, window: str) -> bool:
        """Tell whether nobody but this window has changed the table since a revision."""
        return revision == self._revision or (window == self._writer and revision >= self._alone_since)

    def _state(self) -> dict[str, Any]:
        state = {"revision": self._revision, "table": self._table.to_record(), "saves_to": str(self.out)}
        return {**state, "moving": self.moving.to_record()}

    def _change(self, table: Keyed, window: str) -> None:
        if window != self._writer:
            self._writer, self._alone_since = window, self._revision
        self._table, self._revision = table, self._revision + 1

    def _is_in_file(self) -> bool:
        """Tell whether the file holds every row."""
        rows = self._table.rows
        is_complete = len(rows.complete()) == len(rows.cells)
        return is_complete and sha256_of(rows.to_csv().encode("utf-8")) == self._file_sha256

    def _draft(self) -> Draft:
        return Draft(self._table, self._part_name, self._part_sha256, self._file_sha256, self.moving)

    def _adopt(self) -> None:
        """Take the draft of another picker for the same part and table, which is newer than ours."""
        path = draft_of(self.out)
        try:
            raw = bytes_of(path)
        except InputError:
            return  # `_store` says why, and the rows stay in memory
        if raw is None or raw == self._on_disk:
            return
        try:
            found = read_draft(path)
        except FormatError:
            with suppress(InputError):
                set_aside(path)
            self._on_disk = None
            self._store()
            return
        if found.part_name == self._part_name and found.table.rows.cells:
            self._file_sha256, self._on_disk = found.file_sha256, raw
            self._change(found.table, "")
        elif found.part_name == self._part_name:
            self._on_disk = raw  # all its rows are in the file; the next Save compares with that

    def _store(self) -> str:
        """Write the draft; if the file holds all rows, the draft only names their part. Return why not, or nothing."""
        path, draft = draft_of(self.out), self._draft()
        try:
            raw = bytes_of(path)
            if raw is not None and raw != self._on_disk:
                return f"{path}: belongs to another part, so changes are not kept; use Save as"
            data = (draft.without_rows() if self._is_in_file() else draft).to_json().encode("utf-8")
            write_file(path, data, overwrite=True)
            self._on_disk = data
        except InputError as error:
            return str(error)
        return ""

    def _write(self, out: Path, data: bytes, *, replaces: str) -> str:
        """Write the file and return where the version before is kept, if it was another one."""
        part = self._part_step
        if part is not None and is_same_file(out, part):
            raise InputError(f"{out}: is the part itself; save under another name")
        found = bytes_of(out)
        if found == data:
            return ""
        if found is not None:
            sha256 = sha256_of(found)
            if sha256 not in (self._file_sha256, replaces):
                what = (
                    "was changed by another program" if self._file_sha256 else "exists, and its rows are not shown here"
                )
                raise FileChangedError(f"{out}: {what}", sha256=sha256)
            if is_read_only(out):
                raise InputError(f"{out}: is read-only", code=FILE_READ_ONLY)
            write_file(backup_of(out), found, overwrite=True)
        write_file(out.resolve(), data, overwrite=True)
        return "" if found is None else str(backup_of(out))

    def _new_name(self, name: str) -> Path:
        """Return the path of a new table beside the present one."""
        if name != Path(name).name or name in (".", "..") or name.endswith(KEPT_ENDINGS) or not is_shown(name):
            raise InputError(f"{name}: expected the name of a table in the folder of {self.out.name}")
        out = self.out.with_name(name)
        for path in (out, draft_of(out)):
            if os.path.lexists(path):
                raise InputError(f"{path}: exists; give another name", code=ErrorCode.EXISTS)
        return out

    def _move_to(self, out: Path, before: Draft) -> str:
        """Let the table belong to another file, and its draft with it. The file before keeps the name of its part."""
        old, old_bytes = draft_of(self.out), self._on_disk
        self.out, self._on_disk = out, None
        self._change(self._table, "")
        warning = self._store()
        if not warning and old_bytes is not None and bytes_of(old) == old_bytes:
            if before.file_sha256 is None:
                old.unlink(missing_ok=True)
            else:
                write_file(old, before.without_rows().to_json(), overwrite=True)
        return warning


def _counts(rows: Rows) -> dict[str, Any]:
    complete = set(rows.complete())
    names = [row[rows.columns.index("name")] for row in rows.cells]
    return {"rows": len(complete), "left_out": [name for i, name in enumerate(names) if i not in complete]}
