"""What a person decides about the seams in the page: carried out on the part, judged by its rules, and kept in a file.

A page sends decisions only. Seams, frames, material and reach come from the part, as in `wpcal seams --seams FILE`.
"""

from __future__ import annotations

import shlex
import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeAlias

from cad.pick.draft import backup_of, bytes_of
from cad.session.decisions import read_decisions
from cad.session.part import PickPart
from cad.session.session import PickSession
from wpcal.core.errors import InputError
from wpcal.core.input_file import sha256_of
from wpcal.core.records import read_json, to_json, write_file
from wpcal.pages.report import seam_columns
from wpcal.seam.edit import PlacedEdit, read_edits
from wpcal.seam.options import Judging
from wpcal.seam.record import SEAMS_SCHEMA, seams_record

Search: TypeAlias = Callable[[Judging], PickPart]
"""Finds the seams of the part anew, with what a person says about its solids."""
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
        return (self._given or self.path) if self._edits else None

    @property
    def judging(self) -> Judging:
        """What is said about solids, on the command line and in the page."""
        return self._part.seam_options.judging

    def say(self, solid: str, said: bool | None, *, revision: int) -> dict[str, Any]:
        """Set whether a solid can be welded, find the seams anew, and keep that in the file.

        Returns dict. As `decide`, and ``members`` and ``options``: the options of a command that say the same.

        Raises `InputError` if there is no such solid, or decisions about seams do not fit the seams that are found
        then.
        """
        with self._lock:
            if revision != self._session.seams_revision:
                return {**self._state(), "is_stale": True}
            if self._search is None or solid not in self._part.workpiece.graph.solid_names:
                raise InputError(f"{solid}: nothing can be said about this solid here")
            before, session = self._part, self._session
            part = self._search(_with_said(self.judging, solid, said))
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
    """Return what a page shows of the solids: ``members``, and ``options`` that say what was said about them."""
    notes = part.workpiece.member_notes
    members = [] if notes is None else notes.to_record()["members"]
    return {"members": members, "options": shlex.join(seam_options_of(part.seam_options.judging))}


def seam_options_of(judging: Judging) -> list[str]:
    """Return the options of a command that say what is said about solids."""
    pairs = [("--weld", name) for name in judging.weld] + [("--not", name) for name in judging.not_welded]
    return [word for pair in pairs for word in pair]


def said_in(path: Path) -> Judging:
    """Return what a file of decisions says about solids; nothing if it cannot be read."""
    try:
        said = read_json(path, schema=SEAMS_SCHEMA).get("judging") or {}
    except InputError:
        return Judging()
    weld, not_welded = (tuple(map(str, said.get(key) or ())) for key in ("weld", "not"))
    return Judging(weld, not_welded)


def joined(judging: Judging, before: Judging) -> Judging:
    """Return what a command says about solids, and what was said before about others."""
    known = {*judging.weld, *judging.not_welded}
    weld, not_welded = (
        (*own, *(name for name in earlier if name not in known))
        for own, earlier in ((judging.weld, before.weld), (judging.not_welded, before.not_welded))
    )
    return replace(judging, weld=weld, not_welded=not_welded)


def _with_said(judging: Judging, solid: str, said: bool | None) -> Judging:
    weld, not_welded = (
        (*(name for name in names if name != solid), *([solid] if said is own else []))
        for names, own in ((judging.weld, True), (judging.not_welded, False))
    )
    return replace(judging, weld=weld, not_welded=not_welded)


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
