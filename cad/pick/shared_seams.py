"""What a person decides about the seams in the page: carried out on the part, judged by its rules, and kept in a file.

A page sends decisions only. Seams, frames, material and reach come from the part, as in `wpcal seams --seams FILE`.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np

from cad.pick.draft import backup_of, bytes_of
from cad.session.decisions import read_decisions
from cad.session.part import PickPart
from cad.session.session import PickSession
from wpcal.core.errors import InputError
from wpcal.core.input_file import sha256_of
from wpcal.core.records import to_json, write_file
from wpcal.pages.report import seam_columns
from wpcal.seam.edit import PlacedEdit, read_edits
from wpcal.seam.options import Judging, SaidMember
from wpcal.seam.record import seams_record

Search: TypeAlias = Callable[[Judging], PickPart]
"""Finds the seams of the part anew, with what a person says about its solids."""
SHOWN = (
    *("name", "accepted", "joint", "weld", "solids", "length_mm", "closed"),
    *("confidence", "against", "inside", "candidate", "edit"),
)
"""What the page shows of a seam and needs for decisions about it."""
OUTLINE_DIGITS = 3  #: Decimals of a line on the screen, mm.


def seams_file_of(part_step: Path, out: Path) -> Path:
    """Return where decisions are kept when no file is given: beside the table, named after the part."""
    return out.with_name(f"{part_step.stem}.seams.json")


class SharedSeams:
    """The decisions that all windows of one picker share. Its methods may be called from several threads.

    Raises `InputError` when a decision does not fit the part.
    """

    def __init__(
        self,
        session: PickSession,
        path: Path | None = None,
        *,
        edits: Sequence[PlacedEdit] = (),
        given: Path | None = None,
        search: Search | None = None,
    ) -> None:
        self.path, self._given, self._search = path, given, search
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
        is_said = self.judging != self._session.options.seams.judging
        return (self._given or self.path) if self._edits or is_said else None

    @property
    def judging(self) -> Judging:
        """What is said about solids, on the command line and in the page."""
        return self._part.seam_options.judging

    def say(self, name: str, word: str, *, revision: int) -> dict[str, Any]:
        """Say what a solid or a member is, find the seams anew, and keep that in the file.

        `word`: As in `SaidMember`, or ``weld`` or ``not`` for a solid, or ``rules``: nothing is said about it any more.
        Returns: As `decide`, and ``members`` and ``judging``.

        Raises `InputError` if there is no such member, or decisions about seams do not fit the seams that are found
        then.
        """
        with self._lock:
            if revision != self._session.seams_revision:
                return {**self._state(), "is_stale": True}
            if self._search is None:
                raise InputError(f"{name}: nothing can be said about members here")
            before, session, level = self._part, self._session, self.judging.level
            said = {"weld": Judging((name,)), "not": Judging((), (name,))}
            new = said.get(word, Judging(members=(SaidMember(name, word),))).after(self.judging)
            part = self._search(replace(new, members=new.members[word == "rules" :], level=level))
            try:
                self._part = part
                session.use_part(part)
                self._take(self._edits)
            except InputError:
                self._part = before
                session.use_part(before)
                self._take(self._edits)
                raise
            return {**self._state(), "warning": self._store()}

    def outline(self, name: str) -> dict[str, Any]:
        """Return the borders of the faces of a member: ``p_mm``, pairs of points in `part`."""
        listed = getattr(self._part.workpiece.member_notes, "listed", ())
        faces = [face for one in listed if one.name == name for face in sorted(one.faces)]
        trimmed = self._part.workpiece.trimmed
        rows = [row for face in faces for row in range(*trimmed.start[[face, face + 1]])]
        return {"p_mm": np.round(np.stack([trimmed.p0[rows], trimmed.p1[rows]], axis=1), OUTLINE_DIGITS).tolist()}

    def changes_since(self, revision: int) -> dict[str, Any]:
        """Return the revision, and the seams if the window has other ones."""
        with self._lock:
            now = self._session.seams_revision
            return {"revision": now} if revision == now else self._state()

    def decide(self, decisions: Any, *, revision: int) -> dict[str, Any]:
        """Carry out decisions, in place of those before, and keep them in the file.

        Raises `InputError` when a decision has a wrong form, or does not fit the part. Then nothing is changed.

        Returns: As `seams_of`, with ``revision``, ``file``, ``is_stale``, and ``warning``: why they are not kept, or
        empty.
        """
        edits = read_decisions(decisions, path="seams" if self.path is None else str(self.path))
        with self._lock:
            if revision != self._session.seams_revision:
                return {**self._state(), "is_stale": True}
            self._take(edits)
            return {**self._state(), "warning": self._store()}

    def _take(self, edits: tuple[PlacedEdit, ...]) -> None:
        seams = self._part.decided(edits)
        self._edits = edits
        self._session.use_seams(seams)

    def _state(self) -> dict[str, Any]:
        name = "" if self.path is None else str(self.path)
        state = {"revision": self._session.seams_revision, "file": name, **seams_of(self._session.part)}
        return state if self._search is None else {**state, **solids_record(self._session.part)}

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
        "frames": seam_columns([seam["frames"] for seam in record["seams"]]),
    }


def solids_record(part: PickPart) -> dict[str, Any]:
    """Return what a page shows of the solids and their members, and what was said about them."""
    notes = part.workpiece.member_notes
    record = {"members": [], "judging": None} if notes is None else notes.to_record(part.seams)
    return {key: record[key] for key in ("members", "judging")}


def start_seams(
    session: PickSession, part_step: Path, out: Path, *, given: Path | None = None, search: Search | None = None
) -> tuple[SharedSeams, tuple[str, ...]]:
    """Return the shared seams of a picker, with the decisions of its file, and what a person must know about them.

    Raises `InputError` when the given file cannot be read, or does not fit the part.

    `given`: Path, optional. A file with decisions that the user named. Decisions in it that do not fit the part are an
    error; those of an earlier session are only left out.
    """
    path = seams_file_of(part_step, out)
    if given is not None and given != path:
        is_hidden = f"{path}: its decisions about seams are not shown; the first change keeps it as {backup_of(path)}"
        shared = SharedSeams(session, path, edits=read_edits(given), given=given, search=search)
        return shared, (is_hidden,) if bytes_of(path) is not None else ()
    if bytes_of(path) is None:
        return SharedSeams(session, path, search=search), ()
    try:
        edits = read_edits(path)
        shared = SharedSeams(session, path, edits=edits, search=search)
    except InputError as error:
        if given is not None:
            raise
        return SharedSeams(session, path, search=search), (f"{error}; its decisions about seams are not used",)
    return shared, (f"{path}: the seams are shown with the decisions in it",) if edits else ()
