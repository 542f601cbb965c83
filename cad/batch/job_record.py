"""``job.json`` in the folder of a job or of `wpcal calibrate`: from what the results were made, and what they are."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from wpcal.core.errors import InputError
from wpcal.core.input_file import MOST_STEP_MB, holds_file, read_bytes, sha256_of, sha256_of_own
from wpcal.core.record_check import check_record
from wpcal.core.records import read_json, to_json
from wpcal.core.result_files import JOB_FILE, JOB_SCHEMA, PAGE_FILE
from wpcal.core.schemas import required_fields
from wpcal.core.version import __version__
from wpcal.core.whole_folder import put_in_place

_BEGIN = f'{{\n "schema": "{JOB_SCHEMA}"'.encode()


@dataclass(frozen=True, slots=True)
class JobInputs:
    """Everything that the results of a job depend on, besides the version of wpcal."""

    #: `part`, `taught`: The files as the list names them, and their SHA-256.
    part: tuple[str, str]
    taught: tuple[str, str]
    words: tuple[str, ...] = ()  #: The options as they are typed.
    #: The files that options name, and the files that those name, and their SHA-256.
    files: tuple[tuple[str, str], ...] = ()
    origins: tuple[tuple[str, str], ...] = ()  #: Options that the shop says, and where.

    def to_record(self) -> dict[str, Any]:
        """Return the field ``inputs`` of ``job.json``."""
        return {
            "part": _file_record(self.part),
            "taught": _file_record(self.taught),
            "options": list(self.words),
            "files": [_file_record(each) for each in self.files],
            **({"origins": dict(self.origins)} if self.origins else {}),
        }

    def called(self, origins: Mapping[str, str]) -> JobInputs:
        """Return the same inputs under the names that a list gives them."""
        return JobInputs(
            (original(self.part[0], origins), self.part[1]),
            (original(self.taught[0], origins), self.taught[1]),
            tuple(original(word, origins) for word in self.words),
            tuple((str(Path(original(name, origins))), sha256) for name, sha256 in self.files),
            self.origins,
        )

    @classmethod
    def from_record(cls, record: Mapping[str, Any]) -> JobInputs:
        """Return what the field ``inputs`` of a checked ``job.json`` says."""
        return cls(
            _file_of(record["part"]),
            _file_of(record["taught"]),
            tuple(record["options"]),
            tuple(map(_file_of, record["files"])),
            tuple(record.get("origins", {}).items()),
        )


def _file_of(record: Mapping[str, str]) -> tuple[str, str]:
    return record["file"], record["sha256"]


def _file_record(file: tuple[str, str]) -> dict[str, str]:
    return {"file": file[0], "sha256": file[1]}


def sha256_at(name: str, folder: Path) -> str:
    """Return the SHA-256 of a file that a list names; of a folder, that of the names and hashes of its files.

    Raises `InputError` when it cannot be read.
    """
    path = folder / name
    if not path.is_dir():
        return sha256_of(read_bytes(path, most_mb=MOST_STEP_MB))
    inside = sorted(each for each in path.iterdir() if each.is_file())
    return sha256_of("".join(f"{each.name} {sha256_of(read_bytes(each))}\n" for each in inside).encode())


def names_in(words: Sequence[str], folder: Path) -> tuple[str, ...]:
    """Return the files that options name, each once, in the order of the options."""
    found: dict[str, None] = {}
    for word in words:
        value = word.partition("=")[2]
        with suppress(OSError, ValueError):  # not the name of a file
            if value and (folder / value).is_file():
                found[value] = None
    return tuple(found)


def with_names(words: Sequence[str], names: Mapping[str, str]) -> tuple[str, ...]:
    """Return options with other names of the files in them."""
    parts = [word.partition("=") for word in words]
    return tuple(f"{flag}{sign}{names.get(value, value)}" for flag, sign, value in parts)


def original(text: str, origins: Mapping[str, str]) -> str:
    """Return a text with the names of the list in place of those of copies; `origins` as in `JobInputs.called`."""
    for place, origin in origins.items():
        text = text.replace(place, origin)
    return text


def files_read(noted: Mapping[str, str], taught: str) -> tuple[tuple[str, str], ...]:
    """Return the files of options, and those that they name, with their SHA-256."""
    own = Path(taught)
    return tuple((name, sha256) for name, sha256 in noted.items() if own not in (Path(name), Path(name).parent))


def job_record(name: str | None, inputs: JobInputs, result: Mapping[str, Any], folder: Path) -> str:
    """Return the text of ``job.json`` for a folder that holds all other files; `wpcal calibrate` gives no name."""
    files = {each.name: sha256_of_own(each) for each in sorted(folder.iterdir())}
    return to_json(
        {
            "schema": JOB_SCHEMA,
            **({} if name is None else {"job": name}),
            "wpcal": __version__,
            "inputs": inputs.to_record(),
            "result": dict(result),
            "files": files,
        }
    )


def read_job_record(folder: Path) -> dict[str, Any] | None:
    """Return ``job.json`` of a folder; None if there is none, or it is not a record of a job."""
    if not (folder / JOB_FILE).is_file():
        return None
    try:
        record = read_json(folder / JOB_FILE, schema=JOB_SCHEMA)
        check_record(record, JOB_SCHEMA, path=str(folder / JOB_FILE), is_complete=True)
    except InputError:
        return None
    return record if all(name in record for name in required_fields(JOB_SCHEMA)) else None


def is_torn(folder: Path) -> bool:
    """Tell whether a folder holds a ``job.json`` of which only the beginning reached the disk, as after a power cut."""
    if not holds_file(folder, JOB_FILE):
        return False
    data = (folder / JOB_FILE).read_bytes()
    try:
        json.loads(data)
    except ValueError:
        begun = data.rstrip(b"\0")  # what some file systems have in place of data that were not written
        return begun[: len(_BEGIN)] == _BEGIN[: len(begun)]
    return False


def is_made_of(record: Mapping[str, Any], inputs: JobInputs, folder: Path, *, beside: Path) -> bool:
    """Tell whether a folder holds the complete results of these inputs, made by this version of wpcal."""
    made = JobInputs.from_record(record["inputs"])
    if record.get("wpcal") != __version__ or replace(made, files=()) != replace(inputs, files=()):
        return False
    files: Mapping[str, str] = record.get("files", {})
    return all(
        holds_file(folder, name) and sha256_of_own(folder / name) == sha256 for name, sha256 in files.items()
    ) and all(is_still(name, sha256, beside) for name, sha256 in made.files)


def is_still(name: str, sha256: str, folder: Path) -> bool:
    """Tell whether a file that was read is still the same; parameters as of `sha256_at`."""
    try:
        return sha256_at(name, folder) == sha256
    except InputError:
        return False


def put_job_in_place(new: Path, out: Path) -> None:
    """Let a folder with the results of a job appear as a whole. Results of an earlier run are replaced.

    Raises `InputError` when `out` is not the folder of a job, or cannot be written.
    """
    record = read_job_record(out)
    torn = record is None and is_torn(out)
    if record is None and not torn and out.is_dir() and any(out.iterdir()):
        raise InputError(f"{out}: is not the folder of a job, and holds files; move it away")
    if record is not None and "job" not in record:
        raise InputError(f"{out}: holds other results, of wpcal calibrate; move the folder away")
    old = (PAGE_FILE,) if record is None else record["files"]  # a folder that is torn does not say what it holds
    try:
        put_in_place(new, out, overwrite=record is not None or torn, head=JOB_FILE, leave_out=(*old, JOB_FILE))
    except OSError as error:
        raise InputError(f"{out}: cannot be written: {(error.strerror or str(error)).lower()}") from error
