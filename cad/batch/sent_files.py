"""The files of a job on their way to another machine: their contents, and the names that the list gives them.

A file is sent with those that are read together with it, a folder with the files in it. On the other machine they get a
folder of their own, whose name is the SHA-256 of names and contents: what is there is not written again.
"""

from __future__ import annotations

import os
import secrets
import shutil
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cad.batch.job_record import names_in, with_names
from cad.work.plain_data import pack, unpack
from wpcal.controllers.touch_run import files_beside
from wpcal.core.errors import InputError
from wpcal.core.input_file import MOST_STEP_MB, read_bytes, sha256_of


@dataclass(frozen=True, slots=True)
class SentFile:
    """A file or a folder that a job names."""

    name: str  #: As the list names it.
    sha256: str  #: Of `content`.


FilesOfOptions = Callable[[Sequence[str], str, str], Sequence[str]]
"""Takes options, a part and taught points; returns the files that are read with the options."""


class Reader:
    """Reads what jobs name.

    `files_of_options`: Finds files that files of options name. If they are beside these or in folders below, they are
    sent with them.
    """

    def __init__(self, folder: Path, files_of_options: FilesOfOptions) -> None:
        self._folder, self._files_of_options = folder, files_of_options
        self._known: dict[tuple[str, ...], tuple[Path, ...]] = {}

    def names(self, arguments: Mapping[str, Any]) -> tuple[str, ...]:
        """Return what a job names: its part, its taught points, and files of options."""
        options = names_in(arguments["words"], self._folder)
        return tuple(dict.fromkeys((arguments["part"], arguments["taught"], *options)))

    def read(self, name: str, arguments: Mapping[str, Any]) -> tuple[SentFile, bytes]:
        """Read a file or a folder that a job names, with what is read together with it.

        Raises `InputError` when it cannot be read.
        """
        path = self._folder / name
        try:
            if path.is_dir():
                files = {f"{path.name}/{each.name}": each for each in sorted(path.iterdir()) if each.is_file()}
            else:
                files = {each.name: each for each in (path, *files_beside(path))}
                files |= self._named_by(path, arguments) if name not in (arguments["part"], arguments["taught"]) else {}
            content = pack({to: read_bytes(each, most_mb=MOST_STEP_MB) for to, each in files.items()})
        except InputError as error:
            raise InputError(str(error).replace(f"{self._folder}{os.sep}", ""), code=error.code) from None
        return SentFile(name, sha256_of(content)), content

    def _named_by(self, path: Path, arguments: Mapping[str, Any]) -> dict[str, Path]:
        """Return the files beside a file of an option, and below, that are read with the options."""
        words = tuple(arguments["words"])
        if words not in self._known:
            names = {name: str(self._folder / name) for name in self.names(arguments)}
            part, taught = names[arguments["part"]], names[arguments["taught"]]
            self._known[words] = tuple(map(Path, self._files_of_options(with_names(words, names), part, taught)))
        home = path.parent
        return {
            str(each.relative_to(home)): each
            for each in self._known[words]
            if each.is_relative_to(home) and ".." not in each.relative_to(home).parts
        }


class Copies:
    """The copies of files on this machine."""

    def __init__(self, folder: Path, files: Sequence[SentFile], contents: Sequence[bytes]) -> None:
        self.places: dict[str, str] = {}
        self.origins: dict[str, str] = {}
        for file, content in zip(files, contents, strict=True):
            home = folder / file.sha256
            if not home.is_dir():
                _unpack(content, home)
            self.places[file.name] = str(home / Path(file.name).name)
            self.origins[f"{home}{os.sep}"] = file.name[: len(file.name) - len(Path(file.name).name)]

    def placed(self, arguments: Mapping[str, Any]) -> dict[str, Any]:
        """Return arguments of a group or of a job with the copies in place of the files."""
        placed = {**arguments, "words": with_names(arguments["words"], self.places)}
        return {
            key: self.places.get(value, value) if key in ("part", "taught") else value for key, value in placed.items()
        }


def _unpack(content: bytes, home: Path) -> None:
    """Write files so that their folder appears as a whole: other jobs may need it at the same time."""
    new = home.with_name(f"{home.name}-{secrets.token_hex(4)}")
    for name, data in unpack(content).items():
        path = new / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(data)
    with suppress(OSError):  # another job was first
        os.rename(new, home)
    shutil.rmtree(new, ignore_errors=True)
