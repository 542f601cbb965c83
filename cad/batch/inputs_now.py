"""Where the inputs of finished results are now: found by their names, and accepted by their hashes."""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from cad.batch.job_record import JobInputs, sha256_at
from wpcal.core.errors import InputError
from wpcal.core.input_file import STDIN, sha256_of
from wpcal.core.wording import shown

OPTION = "--inputs"  #: With which the user says where an input is, for messages.
OF_FOLDER = "--touches"  #: Option that may name the folder of its file.
CURRENT = "/0/1/2/3/4/5/6/7"
"""Stands for the folder in which the results were made: this many ``../`` of a name find their place."""


@dataclass(frozen=True, slots=True)
class FoundInputs:
    """Where all inputs of a folder are now."""

    part: Path
    taught: Path
    words: tuple[str, ...]  #: The options. Files that they name are absolute.


@dataclass(frozen=True, slots=True)
class InputsNow:
    """Finds inputs."""

    given: Sequence[Path]  #: Files, or folders with them, that the user names.
    folders: Sequence[Path]  #: Where names are looked up otherwise.
    #: A folder for copies: of files that have another name now, because results hold the names; and of files of
    #: options, in folders as they were, because one may name another one.
    copies: Path
    known: dict[Path, str] = field(default_factory=dict)

    def find(self, inputs: JobInputs, *, name_of_stdin: str) -> FoundInputs:
        """Return where the inputs are. Raises `InputError` when one is not found, or only with other contents."""
        part = self._named(self._find(inputs.part), inputs.part, name_of_stdin)
        taught = self._named(self._find(inputs.taught, may_be_folder=True), inputs.taught, STDIN)
        if not inputs.files:
            return FoundInputs(part, taught, inputs.words)
        listed = "".join(f"{name} {sha256}\n" for name, sha256 in (inputs.taught, *inputs.files))
        tree = self.copies / sha256_of(listed.encode())
        files = {name: self._copied(self._find((name, sha256)), name, tree) for name, sha256 in inputs.files}
        if taught.is_file() and inputs.taught[0] != STDIN:  # others may have been read beside it
            taught = self._copied(taught, inputs.taught[0], tree)
        return FoundInputs(part, taught, tuple(_replaced(word, files) for word in inputs.words))

    def place_of(self, file: tuple[str, str]) -> Path:
        """Return where one file is; errors as of `find`."""
        return self._find(file)

    def _find(self, file: tuple[str, str], *, may_be_folder: bool = False) -> Path:
        name, sha256 = file
        other = None
        for path, is_meant in self._places(name):
            if not _is_there(path, may_be_folder=may_be_folder):
                continue
            if path not in self.known:
                self.known[path] = sha256_at(str(path), Path())
            if self.known[path] == sha256:
                return path
            other = other or (path if is_meant else None)
        if other is not None:
            raise InputError(
                f"{other}: is not the file of which the results were made (its SHA-256 is another); give that file "
                f"with {OPTION}"
            )
        what = "standard input" if name == STDIN else shown(name)
        raise InputError(f"{what}: an input of the results is not found; give its place with {OPTION}")

    def _places(self, name: str) -> Iterator[tuple[Path, bool]]:
        """Yield where a file may be, and whether the name says so: folders may have moved, so the end of it counts."""
        parts = () if name == STDIN else Path(name).parts
        names = [Path(*parts[start:]) for start in range(len(parts))]
        for place in self.given:
            if place.is_dir():
                yield from ((place / each, True) for each in names)
            yield place, not place.is_dir() and place.name == Path(name).name
        yield from ((folder / each, each is names[0]) for each in names for folder in self.folders)

    def _named(self, path: Path, file: tuple[str, str], name_of_stdin: str) -> Path:
        name, sha256 = file
        wanted = name_of_stdin if name == STDIN else Path(name).name
        if path.name == wanted or path.is_dir():
            return path
        return _copy(path, self.copies / sha256 / wanted)

    def _copied(self, path: Path, name: str, tree: Path) -> Path:
        return _copy(
            path, tree / os.path.normpath(f"{CURRENT}/{name}" if not os.path.isabs(name) else name).lstrip("/")
        )


def _is_there(path: Path, *, may_be_folder: bool) -> bool:
    try:
        return path.is_file() or (may_be_folder and path.is_dir())
    except (OSError, ValueError):  # the name is too long, or holds what no name can hold
        return False


def _copy(path: Path, copy: Path) -> Path:
    if not copy.is_file():
        copy.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, copy)
    return copy


def _replaced(word: str, files: Mapping[str, Path]) -> str:
    """Return an option with the file that it names, or the folder with its file, as it is now."""
    flag, _, value = word.partition("=")
    if not value:
        return word
    path = Path(value)
    for name, place in files.items():
        if Path(name) == path:
            return f"{flag}={place}"
        if flag == OF_FOLDER and Path(name).parent == path:
            return f"{flag}={place.parent}"
    return word
