"""The parts that a client opened: as they were read, in memory while there is room for them."""

from __future__ import annotations

import os
from collections import OrderedDict
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import TypeAlias

from cad.batch.bodies_asked import BodiesAsked
from cad.rpc.warm_answers import WarmAnswers
from cad.session.part import PickPart
from cad.session.session import PickSession
from cad.workpiece.answer_cache import key_of, user_cache
from cad.workpiece.features import judge_workpiece
from cad.workpiece.fit_taught import CalibrateOptions
from cad.workpiece.seams import SeamChoice, find_seams
from cad.workpiece.workpiece import Workpiece, open_workpiece
from wpcal.controllers.user_frames import ProgramReading
from wpcal.core.errors import ErrorCode, InputError
from wpcal.core.progress import Progress
from wpcal.seam import Seam, SeamOptions
from wpcal.taught.features import Touchable

Found: TypeAlias = tuple[tuple[Seam, ...], Workpiece]
MOST_FOUND = 4  #: Seams with other options or decisions.
MOST_PARTS = 4  #: In memory; others are read again when they are asked for.


@dataclass(eq=False)
class OpenPart:
    """A part with what is known of it."""

    path: Path  #: As the client named it.
    workpiece: Workpiece
    signature: tuple[int, ...]  #: Size, time and number of the file when it was read.
    _found: OrderedDict[str, Found] = field(default_factory=OrderedDict)

    @property
    def sha256(self) -> str:
        """Hash of the file."""
        return self.workpiece.file.sha256

    @property
    def answers(self) -> WarmAnswers:
        """What was found, for commands on the same file."""
        found = self.workpiece.file.cache
        assert isinstance(found, WarmAnswers)
        return found

    @cached_property
    def touchables(self) -> tuple[Touchable, ...]:
        """The reference features, the easiest to touch first."""
        return judge_workpiece(self.workpiece)

    def seams(self, options: SeamOptions, choice: SeamChoice) -> tuple[tuple[Seam, ...], Workpiece]:
        """Return the seams and the part with what its solids are taken for, as `find_seams` does.

        Those of the last questions are kept, after the decisions: a fit after an edit of a row finds nothing anew.
        """
        key = key_of("decided", (options, choice))
        if key not in self._found:
            self._found[key] = find_seams(self.workpiece, options, choice)
            if len(self._found) > MOST_FOUND:
                self._found.popitem(last=False)
        self._found.move_to_end(key)
        return self._found[key]

    def session(self, options: CalibrateOptions, moving: BodiesAsked) -> PickSession:
        """Return what the picker knows of the part, with seams and bodies as the options say."""
        seams, with_seams = self.seams(options.seams, options.choice)
        session = PickSession(self._pick_part(options.seams, seams, with_seams), options, groups=moving.groups())
        session.choose(moving.to_choice() or session.moving)
        return session

    def reader(self, reading: ProgramReading) -> PickSession:
        """Return what reads taught rows: it needs no seams."""
        return PickSession(self._pick_part(SeamOptions(), (), self.workpiece), program=reading)

    def _pick_part(self, options: SeamOptions, seams: tuple[Seam, ...], with_seams: Workpiece) -> PickPart:
        file, plain = self.workpiece.file, with_seams.without_kernel()
        return PickPart(file.file_name, file.sha256, plain, self.touchables, seams, (), options, None, ())


def read_part(path: Path, progress: Progress) -> OpenPart:
    """Read a STEP file. Raises `InputError` if it cannot be read, or is not a STEP file."""
    from cad.step.open_text import require_step_file

    require_step_file(path)
    signature = signature_of(path)
    return OpenPart(path, open_workpiece(path, cache=WarmAnswers.before(user_cache()), progress=progress), signature)


def signature_of(path: Path) -> tuple[int, ...]:
    """Return what changes when a file is replaced. Raises `InputError` if the file is gone."""
    try:
        found = os.stat(path)
    except OSError as error:
        what = f"is gone since it was opened ({(error.strerror or str(error)).lower()}); put it back, or open another"
        raise InputError(f"{path}: {what}", code=ErrorCode.INPUT) from None
    return found.st_size, found.st_mtime_ns, found.st_ino


@dataclass(eq=False)
class OpenParts:
    """The parts in memory, the last used ones."""

    _parts: OrderedDict[str, OpenPart] = field(default_factory=OrderedDict)

    def put(self, handle: str, part: OpenPart) -> None:
        """Keep a part, in place of the one that was not used for the longest time if there are too many."""
        self._parts[handle] = part
        self._parts.move_to_end(handle)
        while len(self._parts) > MOST_PARTS:
            self._parts.popitem(last=False)

    def get(self, handle: str, path: Path, progress: Progress) -> OpenPart:
        """Return a part; it is read if it is not in memory, or its file changed.

        Raises `InputError` if the file is gone or cannot be read.
        """
        part = self._parts.get(handle)
        if part is None or part.signature != signature_of(path):
            part = read_part(path, progress)
        self.put(handle, part)
        return part

    def drop(self, handles: Sequence[str]) -> None:
        """Forget parts."""
        for handle in handles:
            self._parts.pop(handle, None)
