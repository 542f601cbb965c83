"""What a person decides about the seams in the page: carried out on the part, judged by its rules, and kept in a file.

A page sends decisions only. Seams, frames, material and reach come from the part, as in `wpcal seams --seams FILE`.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from cad.pick.draft import backup_of, bytes_of
from cad.pick.part import PickPart
from cad.pick.session import PickSession
from wpcal.core.errors import InputError
from wpcal.core.input_file import sha256_of
from wpcal.core.records import to_json, write_file
from wpcal.pages.report import seam_columns
from wpcal.seam.edit import PlacedEdit, apply_edits, candidate_from_record, edit_from_record, read_edits
from wpcal.seam.record import seams_record

SHOWN = (
    "name",
    "accepted",
    "joint",
    "weld",
    "solids",
    "length_mm",
    "closed",
    "confidence",
    "against",
    "inside",
    "candidate",
    "edit",
)
"""What the page shows of a seam and needs for decisions about it."""
MOST_DECISIONS = 10_000
"""More are no work of a person."""


def seams_file_of(part_step: Path, out: Path) -> Path:
    """Return where decisions are kept when no file is given: beside the table, named after the part."""
    return out.with_name(f"{part_step.stem}.seams.json")


class SharedSeams:
    """The decisions that all windows of one picker share. Its methods may be called from several threads.

    Parameters
    ----------
    session : PickSession
        Gets the seams that follow from the decisions.
    path : Path or None
        The file that keeps them; None to keep them in memory.
    edits : sequence of PlacedEdit
        The decisions at the start.
    given : Path or None
        The file from which they were read, if it is another one. It is never written: it may be a result.

    Raises
    ------
    InputError
        When a decision does not fit the part.
    """

    def __init__(
        self,
        session: PickSession,
        path: Path | None = None,
        *,
        edits: Sequence[PlacedEdit] = (),
        given: Path | None = None,
    ) -> None:
        self.path, self._given = path, given
        self._session = session
        self._part: PickPart = session.part
        self._edits = tuple(edits)
        self._on_disk = None if path is None else bytes_of(path)
        self._has_backup = False
        self._lock = threading.Lock()
        if self._edits:
            self._take(self._edits)

    @property
    def used_file(self) -> Path | None:
        """The file, if there are decisions that a calibration must know."""
        return (self._given or self.path) if self._edits else None

    def changes_since(self, revision: int) -> dict[str, Any]:
        """Return the revision, and the seams if the window has other ones."""
        with self._lock:
            now = self._session.seams_revision
            return {"revision": now} if revision == now else self._state()

    def decide(self, decisions: Any, *, revision: int) -> dict[str, Any]:
        """Carry out decisions, in place of those before, and keep them in the file.

        Parameters
        ----------
        decisions : list of dict
            Each with a ``candidate`` and an ``edit``, as in ``seams.json``.
        revision : int
            The revision that the window shows. If it is not the present one, nothing is done.

        Returns
        -------
        dict
            As `seams_of`, with ``revision``, ``file``, ``is_stale``, and ``warning``: why they are not kept, or empty.

        Raises
        ------
        InputError
            When a decision has a wrong form, or does not fit the part. Then nothing is changed.
        """
        edits = self._read(decisions)
        with self._lock:
            if revision != self._session.seams_revision:
                return {**self._state(), "is_stale": True}
            self._take(edits)
            return {**self._state(), "warning": self._store()}

    def _read(self, decisions: Any) -> tuple[PlacedEdit, ...]:
        if not isinstance(decisions, list) or len(decisions) > MOST_DECISIONS:
            raise InputError(f"expected a list of at most {MOST_DECISIONS} decisions about seams")
        path = "seams" if self.path is None else str(self.path)
        edits = []
        for decision in decisions:
            if not isinstance(decision, dict) or not isinstance(decision.get("candidate"), dict):
                raise InputError("expected a candidate and an edit for every decision about a seam")
            label = str(decision["candidate"].get("name", "?"))
            candidate = candidate_from_record(decision["candidate"], label, path=path)
            edits.append(PlacedEdit(candidate, edit_from_record(decision.get("edit"), label, path=path), path))
        return tuple(edits)

    def _take(self, edits: tuple[PlacedEdit, ...]) -> None:
        part, options = self._part, self._part.seam_options
        seams = apply_edits(part.graph, part.trimmed, part.candidates, edits, options)
        self._edits = edits
        self._session.use_seams(seams)

    def _state(self) -> dict[str, Any]:
        name = "" if self.path is None else str(self.path)
        return {"revision": self._session.seams_revision, "file": name, **seams_of(self._session.part)}

    def _store(self) -> str:
        """Write the file. Return why that failed, or nothing."""
        if self.path is None:
            return ""
        part = self._session.part
        notes, join_mm = part.workpiece.member_notes, part.seam_options.most_join_mm
        torch = part.seam_options.reach.torch
        data = to_json(seams_record(part.seams, notes=notes, join_mm=join_mm, torch=torch)).encode("utf-8")
        try:
            found = bytes_of(self.path)
            if found is not None and (self._on_disk is None or sha256_of(found) != sha256_of(self._on_disk)):
                return f"{self.path}: was changed by another program, and is left alone; rename it to keep both"
            if found is not None and not self._has_backup:
                write_file(backup_of(self.path), found, overwrite=True)
            write_file(self.path, data, overwrite=True)
            self._has_backup, self._on_disk, self._given = True, data, None
        except InputError as error:
            return str(error)
        return ""


def seams_of(part: PickPart) -> dict[str, Any]:
    """Return what a page shows of the seams: ``seams``, and ``frames`` as columns, both in the order of the part."""
    record = seams_record(part.seams)
    return {
        "seams": [{key: seam[key] for key in SHOWN if key in seam} for seam in record["seams"]],
        "frames": [seam_columns(seam["frames"]) for seam in record["seams"]],
    }


def start_seams(
    session: PickSession, part_step: Path, out: Path, *, given: Path | None = None
) -> tuple[SharedSeams, tuple[str, ...]]:
    """Return the shared seams of a picker, with the decisions of its file, and what a person must know about them.

    Parameters
    ----------
    session : PickSession
    part_step, out : Path
        The part and the table.
    given : Path, optional
        A file with decisions that the user named. Decisions in it that do not fit the part are an error; those of an
        earlier session are only left out.

    Raises
    ------
    InputError
        When the given file cannot be read, or does not fit the part.
    """
    path = seams_file_of(part_step, out)
    if given is not None and given != path:
        is_hidden = f"{path}: its decisions about seams are not shown; the first change keeps it as {backup_of(path)}"
        shared = SharedSeams(session, path, edits=read_edits(given), given=given)
        return shared, (is_hidden,) if bytes_of(path) is not None else ()
    if bytes_of(path) is None:
        return SharedSeams(session, path), ()
    try:
        edits = read_edits(path)
        shared = SharedSeams(session, path, edits=edits)
    except InputError as error:
        if given is not None:
            raise
        return SharedSeams(session, path), (f"{error}; its decisions about seams are not used",)
    return shared, (f"{path}: the seams are shown with the decisions in it",) if edits else ()
