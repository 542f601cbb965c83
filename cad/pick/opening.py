"""The rows at the start of the picker: from the draft, from the table to save to, or from another file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cad.pick.draft import Draft, Keyed, bytes_of, draft_of, read_draft, set_aside
from cad.pick.shared_table import SharedTable
from cad.session.part import PickPart
from cad.session.rows import Rows, read_rows
from cad.workpiece.moving import MovingChoice
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import sha256_of


@dataclass(frozen=True, slots=True)
class Found:
    """The table to save to and its draft, as they were found before the part is read."""

    out: Path
    raw: bytes | None  #: The table's file.
    rows: Rows  #: Its rows.
    draft: Draft | None  #: The draft, if it has rows.
    draft_raw: bytes | None  #: The draft's file.
    damage: str = ""  #: Why the draft cannot be read, or empty.
    #: A draft without rows: it names the part on which the rows of the table were taught.
    part_of_table: Draft | None = None

    @property
    def moving(self) -> MovingChoice:
        """Whether bodies may have moved, as it was chosen before."""
        draft = self.draft or self.part_of_table
        return MovingChoice() if draft is None else draft.moving


def find_table(out: Path) -> Found:
    """Read the table to save to, if there is one, and its draft. A damaged draft is left to `start_table`.

    Raises `InputError` when a file cannot be read, or the table is not one of taught points and there is no draft.
    """
    draft, damage = None, ""
    draft_raw = bytes_of(draft_of(out))
    if draft_raw is not None:
        try:
            draft = read_draft(draft_of(out))
        except FormatError as error:
            damage = str(error)
    named = None
    if draft is not None and not draft.table.rows.cells:
        draft, named = None, draft
    raw = bytes_of(out)
    rows = Rows() if raw is None or draft is not None else _rows_of(raw, out)
    return Found(out, raw, rows, draft, draft_raw, damage, named)


def _rows_of(raw: bytes, out: Path) -> Rows:
    try:
        return read_rows(raw, path=str(out))
    except FormatError as error:
        what = f"{error.what}; give -o and another name to save under"
        raise FormatError(what, path=error.path, line=error.line, column=error.column, code=error.code) from None


def start_table(
    found: Found,
    part: PickPart,
    *,
    part_step: Path,
    given: Rows | None = None,
    given_name: str = "",
    force: bool = False,
    command: Callable[[Path], str] = str,
    moving: MovingChoice | None = None,
) -> tuple[SharedTable, tuple[str, ...]]:
    """Choose the rows at the start: those of the draft, otherwise those given, otherwise those of the table.

    Returns `notes`: tuple of str. What a person must know about these rows.
    Raises `InputError` when the rows belong to another part and `force` is false.
    """
    notes = []
    draft_raw = found.draft_raw
    if found.damage:
        notes.append(f"{found.damage}; the damaged draft was renamed to {set_aside(draft_of(found.out))}")
        draft_raw = None
    file_sha256 = None if found.raw is None else sha256_of(found.raw)
    if found.draft is not None:
        start = found.draft.table
        notes += _check_part(found.draft, draft_of(found.out), part, force=force)
        file_sha256, changes = _compare(found.draft, found)
        notes += changes
        if given is not None:
            notes.append(
                f"{given_name} was not read, because there is a draft; open the file on the page to add its rows"
            )
    elif given is not None:
        start, file_sha256 = Keyed.of_rows(given), None
        if found.raw is not None:
            notes.append(f"{found.out} exists and is not shown here; Save asks before it is replaced")
    else:
        start = Keyed.of_rows(found.rows)
        if found.part_of_table is not None and found.raw is not None:
            notes += _check_part(found.part_of_table, found.out, part, force=force)
    table = SharedTable(
        found.out,
        part,
        start=start,
        file_sha256=file_sha256,
        draft=draft_raw,
        part_step=part_step,
        command=command,
        moving=moving or found.moving,
    )
    return table, tuple(notes)


def _check_part(draft: Draft, path: Path, part: PickPart, *, force: bool) -> list[str]:
    if draft.part_sha256 == part.sha256:
        return []
    if draft.part_name == part.file_name:
        return [f"{part.file_name} was changed after these rows were typed; check their features"]
    if not force:
        what = f"holds rows for another part, {draft.part_name}"
        raise InputError(f"{path}: {what}; give -o and another table, or --other-part to take these rows for this part")
    return [f"the rows were taught on another part, {draft.part_name}"]


def _compare(draft: Draft, found: Found) -> tuple[str | None, list[str]]:
    """Return the hash of the file that the draft's rows are based on, and what a person must know."""
    complete = draft.table.rows.to_csv().encode("utf-8")
    if found.raw == complete:  # the picker ended after Save and before the draft was brought up to date
        return sha256_of(complete), []
    notes = [f"{draft_of(found.out)}: the page shows its rows, which were not all saved"]
    if draft.file_sha256 is not None and found.raw is None:
        notes.append(f"{found.out} was removed after the draft was made; Save writes it again")
    elif found.raw is not None and sha256_of(found.raw) != draft.file_sha256:
        notes.append(
            f"{found.out} was changed by another program after the draft was made; Save asks before it is replaced"
        )
    return draft.file_sha256, notes
