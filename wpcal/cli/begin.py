"""What `wpcal` alone says in a folder with a part: the next command."""

from __future__ import annotations

import shlex
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path

from wpcal.core.result_files import CALIBRATION_FILE

PARTS = (".step", ".stp")
MOST_FOLDERS = 200  #: Result folders are looked for among this many folders.


def next_here(folder: Path) -> list[str]:
    """Return lines that say the next command in a folder; none without a part and a result."""
    results = sorted(_results(folder), key=lambda path: path.stat().st_mtime)
    if results:
        return _after(results[-1])
    files = sorted(path for path in folder.iterdir() if path.is_file())
    parts = [path for path in files if path.suffix.lower() in PARTS]
    if not parts:
        return []
    part = shlex.quote(parts[0].name)
    taught = [path for path in files if path.suffix.lower() == ".csv" and _is_taught(path)]
    if taught:
        return [f"next: wpcal calibrate {part} {shlex.quote(taught[0].name)} -o out"]
    return [f"next: wpcal pick {part}", f"  or: wpcal advise {part} says which points to touch"]


def _results(folder: Path) -> Iterator[Path]:
    found = (path / CALIBRATION_FILE for path in sorted(folder.iterdir())[:MOST_FOLDERS])
    yield from filter(Path.is_file, found)


def _after(path: Path) -> list[str]:
    from wpcal.core.errors import WpcalError
    from wpcal.results.folder import read_record
    from wpcal.results.next_steps import next_steps

    name = shlex.quote(path.parent.name)
    with suppress(WpcalError):
        record = read_record(path.parent, path.name)
        steps = next_steps(record)
        if record.get("verdict") != "PASS" and steps:
            return [f"{name}: {record.get('verdict')}", *(f"next: {step}" for step in steps)]
    return [f"next: wpcal export {name} -f LANGUAGE (wpcal export --help lists them)", f"  or: open {name}/report.html"]


def _is_taught(path: Path) -> bool:
    """Whether a table has positions: a template that nobody has filled has none."""
    from wpcal.core.errors import WpcalError
    from wpcal.taught.table import read_taught

    with suppress(WpcalError):
        return bool(len(read_taught(path).names))
    return False
