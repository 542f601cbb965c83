"""What can be checked of results that do not say how they were asked for: scripts write no ``job.json``."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from cad.batch.job_record import JobInputs
from wpcal.core.errors import WpcalError
from wpcal.core.input_file import holds_file, read_bytes
from wpcal.core.result_files import CALIBRATION_FILE, PAGE_FILE, TABLE_FILE
from wpcal.pages.report import build_report
from wpcal.results.differences import Difference, differences_of
from wpcal.results.folder import read_record, read_result_folder
from wpcal.seam.record import seams_csv


def usual_inputs(folder: Path) -> JobInputs | None:
    """Return the inputs that ``calibration.json`` names, with the tolerance and the criterion that it states."""
    try:
        record = read_record(folder, CALIBRATION_FILE)
    except WpcalError:
        return None
    part, taught = (record["inputs"].get(name, {}) for name in ("part", "taught"))
    if not (part.get("sha256") and taught.get("sha256")):
        return None
    words = (f"--tolerance-mm={record['tolerance_mm']!r}", f"--criterion={record['criterion']}")
    return JobInputs((part["file"], part["sha256"]), (taught["file"], taught["sha256"]), words)


def disagreements(folder: Path) -> Iterator[Difference]:
    """Yield where the files of a folder do not agree with one another."""
    try:
        found = read_result_folder(folder)
    except WpcalError as error:
        yield Difference("the folder", f"not from one calibration ({error})", "from one")
        return
    made = {TABLE_FILE: seams_csv(found.seams)}
    if holds_file(folder, PAGE_FILE):
        made[PAGE_FILE] = build_report(found.calibration, found.seams, found.part_glb)
    for name, text in made.items():
        if not holds_file(folder, name):
            yield Difference(name, "missing", "there")
        elif (mine := read_bytes(folder / name)) != text.encode("utf-8"):
            yield from differences_of(name, mine, text.encode("utf-8"))
