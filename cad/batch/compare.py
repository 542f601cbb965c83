"""Compare a folder of results with the same request done once more: all bytes, or numbers of another version."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

from wpcal.core.errors import InputError
from wpcal.core.input_file import holds_file, sha256_of_own
from wpcal.core.result_files import CALIBRATION_FILE, JOB_FILE
from wpcal.core.version import __version__
from wpcal.results.agree import twice_stated
from wpcal.results.diff import compare_folders
from wpcal.results.differences import Difference, differences_of, walk_records
from wpcal.results.folder import read_record

OTHER_VERSION_MM = 1e-5
"""Numbers of another version: a fit ends within 1e-9 mm of its optimum, and other versions of NumPy and of the kernel
change last digits."""
OF_VERSIONS = ("versions", "files")
"""Fields of records that say the versions, and hashes of files whose bytes they change."""
MOST_OF_A_FILE = 10  #: Differences that are listed of one file.


def other_versions(claimed: Path, made: Path, record: Mapping[str, Any]) -> dict[str, tuple[str, str]]:
    """Return of which programs another version wrote a folder than did its request again: that, and the one here.

    Parameters are those of `compare_claim`. Empty within one set of versions, and where the folder does not say it.
    """
    theirs, ours = {**_versions(claimed), "wpcal": record["wpcal"]}, {**_versions(made), "wpcal": __version__}
    return {name: (theirs[name], ours[name]) for name in ours if theirs.get(name, ours[name]) != ours[name]}


def _versions(folder: Path) -> dict[str, str]:
    try:
        found = read_record(folder, CALIBRATION_FILE)["versions"]
    except InputError:
        return {}
    return {str(name): str(version) for name, version in found.items()}


def compare_claim(claimed: Path, made: Path, record: Mapping[str, Any]) -> list[Difference]:
    """Return what differs between a folder and what its request gives.

    `record`: ``job.json`` of the folder. Within one set of versions all bytes are compared. If another version of NumPy
    or SciPy wrote the folder, it is compared with its own hashes, and its records within `OTHER_VERSION_MM`. If another
    version of wpcal did, only its poses, residuals, bound and seam frames are.
    """
    found = []
    name = record.get("job")
    if name is not None and name != claimed.resolve().name:
        found.append(Difference(f"{JOB_FILE} job", name, claimed.resolve().name))
    others = other_versions(claimed, made, record)
    if "wpcal" in others:
        return [*found, *_of_other_version(claimed, made, record)]
    for path in sorted(made.iterdir()):
        if not holds_file(claimed, path.name):
            found.append(Difference(path.name, "missing", "there"))
            continue
        mine, expected = (claimed / path.name).read_bytes(), path.read_bytes()
        if mine != expected:
            differences = _by_numbers(claimed, path, record) if others else differences_of(path.name, mine, expected)
            found += islice(differences, MOST_OF_A_FILE)
    return found


def other_bytes(claimed: Path, made: Path, record: Mapping[str, Any]) -> list[str]:
    """Return the files of which other versions may have made other bytes: only some of their numbers are compared.

    Parameters are those of `compare_claim`. Files with the same bytes are checked as a whole, by whichever version.
    """
    others = other_versions(claimed, made, record)
    names = [path.name for path in sorted(made.iterdir()) if path.name != JOB_FILE and holds_file(claimed, path.name)]
    differ = [name for name in names if others and (claimed / name).read_bytes() != (made / name).read_bytes()]
    return differ if "wpcal" in others else [name for name in differ if not name.endswith((".json", ".csv"))]


def _changed(claimed: Path, name: str, record: Mapping[str, Any]) -> bool:
    return name in record["files"] and sha256_of_own(claimed / name) != record["files"][name]


def _by_numbers(claimed: Path, path: Path, record: Mapping[str, Any]) -> Iterator[Difference]:
    """Yield how a file differs of which other versions of the libraries may have made other last digits."""
    name = path.name
    mine, expected = (claimed / name).read_bytes(), path.read_bytes()
    if _changed(claimed, name, record):
        yield Difference(name, "changed", f"as {JOB_FILE} lists it")
    elif name.endswith(".json"):
        try:
            records = [json.loads(each) for each in (mine, expected)]
            one, other = ({key: each[key] for key in each if key not in OF_VERSIONS} for each in records)
        except (ValueError, TypeError):
            yield from differences_of(name, mine, expected)
            return
        yield from walk_records(one, other, name, OTHER_VERSION_MM)
    else:  # made of the records of the same folder
        yield from walk_records(*twice_stated(claimed, name), name)


def _of_other_version(claimed: Path, made: Path, record: Mapping[str, Any]) -> Iterator[Difference]:
    for name in record["files"]:
        if not holds_file(claimed, name):
            yield Difference(name, "missing", "there")
        elif _changed(claimed, name, record):
            yield Difference(name, "changed", f"as {JOB_FILE} lists it")
    try:
        yield from compare_folders(claimed, made, atol_mm=OTHER_VERSION_MM)
    except InputError as error:
        yield Difference("folder", str(error), "records of a calibration")
    again = json.loads((made / JOB_FILE).read_bytes())["result"]
    yield from walk_records(record["result"], again, f"{JOB_FILE} result", OTHER_VERSION_MM)
