"""Compare a folder of results with the same request done once more: all bytes, or numbers of another version."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from wpcal.core.errors import InputError
from wpcal.core.input_file import holds_file, sha256_of
from wpcal.core.version import __version__
from wpcal.results.agree import JOB_FILE
from wpcal.results.diff import compare_folders
from wpcal.results.differences import Difference, differences_of, walk

OTHER_VERSION_MM = 1e-5
"""Numbers of another version: a fit ends within 1e-9 mm of its optimum, and other versions of NumPy and of the kernel
change last digits."""
MOST_OF_A_FILE = 10
"""Differences that are listed of one file."""


def compare_claim(claimed: Path, made: Path, record: Mapping[str, Any]) -> list[Difference]:
    """Return what differs between a folder and what its request gives.

    Parameters
    ----------
    record : mapping
        ``job.json`` of the folder. If another version of wpcal wrote it, the folder is compared with its own hashes,
        and its poses, residuals, bound and seam frames within `OTHER_VERSION_MM`.
    """
    found = []
    name = record.get("job")
    if name is not None and name != claimed.resolve().name:
        found.append(Difference(f"{JOB_FILE} job", name, claimed.resolve().name))
    if record["wpcal"] != __version__:
        return [*found, *_of_other_version(claimed, made, record)]
    for path in sorted(made.iterdir()):
        if not holds_file(claimed, path.name):
            found.append(Difference(path.name, "missing", "there"))
            continue
        mine, expected = (claimed / path.name).read_bytes(), path.read_bytes()
        if mine != expected:
            found += islice(differences_of(path.name, mine, expected), MOST_OF_A_FILE)
    return found


def other_bytes(claimed: Path, made: Path, record: Mapping[str, Any]) -> list[str]:
    """Return the files of which another version may have made other bytes: only some of their numbers are compared.

    Parameters are those of `compare_claim`. Files with the same bytes are checked as a whole, by whichever version.
    """
    if record["wpcal"] == __version__:
        return []
    names = [path.name for path in sorted(made.iterdir()) if path.name != JOB_FILE and holds_file(claimed, path.name)]
    return [name for name in names if (claimed / name).read_bytes() != (made / name).read_bytes()]


def _of_other_version(claimed: Path, made: Path, record: Mapping[str, Any]) -> Iterator[Difference]:
    files: Mapping[str, str] = record["files"]
    for name, sha256 in files.items():
        if not holds_file(claimed, name):
            yield Difference(name, "missing", "there")
        elif sha256_of((claimed / name).read_bytes()) != sha256:
            yield Difference(name, "changed", f"as {JOB_FILE} lists it")
    try:
        yield from compare_folders(claimed, made, atol_mm=OTHER_VERSION_MM)
    except InputError as error:
        yield Difference("folder", str(error), "records of a calibration")
    again = json.loads((made / JOB_FILE).read_bytes())["result"]
    yield from walk(record["result"], again, f"{JOB_FILE} result", OTHER_VERSION_MM)
