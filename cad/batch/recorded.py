"""A calibration whose folder holds its own request (``job.json``), and the same request once more (`wpcal verify`)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import click

from cad.batch.compare import compare_claim, other_bytes, other_versions
from cad.batch.inputs_now import FoundInputs
from cad.batch.job_record import JobInputs, files_read, job_record, sha256_at
from cad.batch.jobs import OpenedPart, result_of
from cad.batch.request import calibrate_arguments, given_words, read_words
from cad.workpiece.answer_cache import NO_CACHE, AnswerCache
from cad.workpiece.calibrate import WorkpieceCalibration, WrittenCalibration, calibrate_files
from cad.workpiece.means import USUAL_MEANS, Means
from cad.workpiece.workpiece import Workpiece
from wpcal.cli.calibration_tables import exit_code
from wpcal.cli.command_group import origins_of
from wpcal.core.input_file import noted_files, sha256_of_own
from wpcal.core.progress import Progress, no_progress
from wpcal.core.result_files import JOB_FILE, PAGE_FILE, SEAMS_FILE


def asked_inputs(
    context: click.Context, part: Path, taught: Path, taught_sha256: str, noted: Mapping[str, str]
) -> JobInputs:
    """Return what a command depends on; the hash of the part is added when the part is read."""
    sha256 = sha256_at(str(taught), Path()) if taught.is_dir() else taught_sha256
    said = tuple(origins_of(context).items())
    return JobInputs((str(part), ""), (str(taught), sha256), given_words(context), files_read(noted, str(taught)), said)


def recording(words: Sequence[str], part: Path, taught: Path, taught_sha256: str, noted: Mapping[str, str]) -> Means:
    """Return the means that write ``job.json`` for a request that `wpcal calibrate` would take as these words.

    `taught_sha256`, `noted`: As of `asked_inputs`. Decisions that are written into the folder with its seams have no
    hash yet.
    """
    with read_words(words) as (asked, context):
        inputs = asked_inputs(context, part, taught, taught_sha256, noted)
        seal = partial(_seal, name=None, inputs=inputs, accept_unsure=asked.output.accept_unsure)
    return replace(USUAL_MEANS, seal=seal)


def calibrate_recorded(*, inputs: JobInputs, accept_unsure: bool, **arguments: Any) -> WrittenCalibration:
    """Run `calibrate_files`, and write ``job.json`` beside its files."""
    seal = partial(_seal, name=None, inputs=inputs, accept_unsure=accept_unsure)
    return calibrate_files(**arguments, means=replace(USUAL_MEANS, seal=seal))


def _seal(
    found: WorkpieceCalibration, folder: Path, *, name: str | None, inputs: JobInputs, accept_unsure: bool
) -> None:
    """Write ``job.json``. Inputs without a hash get that of the bytes that were read, decisions that of seams.json."""
    if not inputs.part[1]:
        inputs = replace(inputs, part=(inputs.part[0], found.workpiece.file.sha256))
    if not inputs.taught[1]:
        inputs = replace(inputs, taught=(inputs.taught[0], found.taught.sha256 or ""))
    inputs = replace(
        inputs, files=tuple((file, sha256 or sha256_of_own(folder / SEAMS_FILE)) for file, sha256 in inputs.files)
    )
    result = {**result_of(found), "exit_code": exit_code(found.result, accept_unsure=accept_unsure)}
    (folder / JOB_FILE).write_text(job_record(name, inputs, result, folder), encoding="utf-8")


@dataclass(frozen=True, slots=True)
class Claim:
    """A folder that says what it was made of, and where these inputs are now."""

    folder: Path
    record: dict[str, Any]  #: Its ``job.json``.
    now: FoundInputs  #: Files with the hashes of the record.
    is_asked: bool = True  #: Whether the folder holds the record. Otherwise it is a guess.


def check_claim(
    *,
    step: Path | Workpiece,
    claim: Claim,
    means: Means = USUAL_MEANS,
    cache: AnswerCache = NO_CACHE,
    progress: Progress = no_progress,
) -> dict[str, list[Any]]:
    """Do the request of a folder once more.

    Returns: ``differences``: records of `wpcal.results.differences.Difference`. ``unchecked``: the files of other
    versions of which only some numbers are compared. ``versions``: of which programs: name, version that wrote them,
    and that here.
    """
    now = claim.now
    with TemporaryDirectory() as temporary:
        new = Path(temporary, "new")
        wants_page = PAGE_FILE in claim.record["files"] or (claim.folder / PAGE_FILE).exists()
        name, inputs = claim.record.get("job"), JobInputs.from_record(claim.record["inputs"])
        with noted_files() as noted, read_words(now.words) as (asked, _):
            arguments = calibrate_arguments(asked, part=now.part, taught=now.taught, out=new)
            accept_unsure = asked.output.accept_unsure
        read = set(noted.values())
        inputs = replace(inputs, files=tuple(file for file in inputs.files if file[1] in read))
        seal = partial(_seal, name=name, inputs=inputs, accept_unsure=accept_unsure)
        means = replace(means, wants_page=lambda _: wants_page)
        means = replace(means, seal=seal) if claim.is_asked else means
        calibrate_files(step, **arguments, means=means, cache=cache, progress=progress)
        compared = (claim.folder, new, claim.record)
        differences = [each.to_record() for each in compare_claim(*compared)]
        others = [[name, *both] for name, both in other_versions(*compared).items()]
        return {"differences": differences, "unchecked": other_bytes(*compared), "versions": others}


def check_job(opened: OpenedPart, *, folder: Path, claim: Claim) -> dict[str, list[Any]]:
    """Check one folder of a batch in its process; `folder` is for unfinished work."""
    del folder
    return check_claim(step=opened.workpiece, claim=claim, means=opened.means)
