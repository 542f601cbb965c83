"""Where the inputs of finished results are now: found by their names, and accepted by their hashes."""

from __future__ import annotations

import shutil
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from cad.batch.job_record import JobInputs, sha256_at
from wpcal.core.errors import InputError
from wpcal.core.input_file import STDIN
from wpcal.core.wording import shown

OPTION = "--inputs"
"""With which the user says where an input is, for messages."""


@dataclass(frozen=True, slots=True)
class InputsNow:
    """Finds inputs.

    Parameters
    ----------
    given : sequence of Path
        Files, or folders with them, that the user names.
    folders : sequence of Path
        Where names are looked up otherwise.
    copies : Path
        A folder for copies of files that have another name now: the results hold the names.
    """

    given: Sequence[Path]
    folders: Sequence[Path]
    copies: Path
    known: dict[Path, str] = field(default_factory=dict)

    def part(self, inputs: JobInputs, *, name_of_stdin: str) -> Path:
        """Return where the part is.

        Raises
        ------
        InputError
            When it is not found, or only with other contents.
        """
        return self._named(self._find(inputs.part), inputs.part, name_of_stdin)

    def points(self, inputs: JobInputs) -> Path:
        """Return where the taught points are; errors as of `part`."""
        return self._named(self._find(inputs.taught), inputs.taught, STDIN)

    def words(self, inputs: JobInputs) -> tuple[str, ...]:
        """Return the options with the files that they name as they are now; errors as of `part`."""
        files = dict(inputs.files)
        words = []
        for word in inputs.words:
            flag, _, value = word.partition("=")
            if value in files:
                place = self._find((value, files[value]))
                words.append(f"{flag}={place.resolve()}")
            else:
                words.append(word)
        return tuple(words)

    def _find(self, file: tuple[str, str]) -> Path:
        name, sha256 = file
        other = None
        for path in self._places(name):
            if not path.exists():
                continue
            if path not in self.known:
                self.known[path] = sha256_at(str(path), Path())
            if self.known[path] == sha256:
                return path
            other = other or path
        if other is not None:
            raise InputError(
                f"{other}: is not the file of which the results were made (its SHA-256 is another); give that file "
                f"with {OPTION}"
            )
        what = "standard input" if name == STDIN else shown(name)
        raise InputError(f"{what}: an input of the results is not found; give its place with {OPTION}")

    def _places(self, name: str) -> Iterator[Path]:
        for place in self.given:
            yield place
            if place.is_dir():
                yield place / name
                yield place / Path(name).name
        if name != STDIN:
            yield from (folder / name for folder in self.folders)

    def _named(self, path: Path, file: tuple[str, str], name_of_stdin: str) -> Path:
        name, sha256 = file
        wanted = name_of_stdin if name == STDIN else Path(name).name
        if path.name == wanted or path.is_dir():
            return path
        copy = self.copies / sha256 / wanted
        if not copy.is_file():
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, copy)
        return copy
