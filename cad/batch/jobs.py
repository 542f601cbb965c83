"""The work of a batch of calibrations, in its processes: open a part once, then one calibration for each job.

A job runs `wpcal calibrate` with the options of its row, read by the same code, and writes the same files.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from enum import Enum
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import click

from cad.batch.job_list import OptionColumn
from cad.batch.job_record import JobInputs, files_read, job_record, put_job_in_place, sha256_at
from cad.batch.request import calibrate_arguments, read_words, request_options
from cad.batch.seams_asked import SeamsAsked
from cad.workpiece.answer_cache import NO_CACHE, AnswerCache, key_of, user_cache
from cad.workpiece.calibrate import WorkpieceCalibration, WrittenCalibration, calibrate_files, worst_seam_error_mm
from cad.workpiece.means import Means
from cad.workpiece.seams import find_seams
from cad.workpiece.step_file import StepFile, draw_part
from cad.workpiece.workpiece import Workpiece, open_workpiece
from wpcal.calibrate import CalibrationResult
from wpcal.cli.calibration_tables import exit_code
from wpcal.cli.option_groups import option_names
from wpcal.core.errors import WpcalError
from wpcal.core.input_file import noted_files
from wpcal.core.issue import Issue
from wpcal.core.result_files import JOB_FILE
from wpcal.core.transform import RigidTransform
from wpcal.core.whole_folder import flush_later
from wpcal.seam.options import SeamOptions

if TYPE_CHECKING:
    from cad.step.read import StepPart
    from cad.step.write import KnownPart

PRELOADED = (
    "cad.batch.jobs",
    "cad.step.write",
    "cad.step.open_text",
    "cad.kernel.tessellate",
    "cad.kernel.to_brep",
    "wpcal.touch.advice",
    "wpcal.controllers.taught_program",
    "wpcal.controllers.touch_run",
    "wpcal.touch.grasp",
    "wpcal.pages.report",
    "wpcal.robot.kinematics.arm_file",
    "wpcal.robot.torch.file",
    "scipy.interpolate",
    "scipy.optimize",
    "scipy.sparse.csgraph",
    "scipy.spatial",
    "scipy.stats",
)
"""What a calibration imports when it needs it: loaded once, before the first job."""
NO_ORIGINS: Mapping[str, str] = MappingProxyType({})


class Pages(Enum):
    """Of which jobs the page is written."""

    ALL = "all"
    FAIL = "fail"  #: Of jobs that end with a code other than 0: FAIL, and UNSURE unless it is accepted.
    NONE = "none"


def option_columns() -> dict[str, OptionColumn]:
    """Return the options that a column of the list may hold, by the names of their columns."""
    of_part = {*option_names(SeamOptions), *option_names(SeamsAsked)}
    return {
        column: OptionColumn(
            max(option.opts, key=len),
            is_flag=option.is_flag,
            is_optional=not option.is_flag and isinstance(option.flag_value, str),
            is_multiple=option.multiple,
            is_number=isinstance(option.type, click.types.FloatParamType),
            shapes_part=option.name in of_part,
        )
        for column, option in request_options().items()
    }


@dataclass(frozen=True, slots=True)
class _HeldAnswers(AnswerCache):
    """A cache that also keeps its answers in memory: for a part that many jobs ask about."""

    held: dict[str, object] = field(default_factory=dict)

    def answer(self, what: str, of: Sequence[object], make: Any) -> Any:
        """Return an answer that is held or kept, or find it; parameters as in `AnswerCache.answer`."""
        key = key_of(what, of)
        if key not in self.held:
            self.held[key] = AnswerCache.answer(self, what, of, make)
        return self.held[key]


@dataclass(frozen=True, slots=True, eq=False)
class OpenedPart:
    """What all jobs on one part with the same options of seams share."""

    workpiece: Workpiece
    sha256: str  #: Of the bytes of its file.
    means: Means  #: Which take what was found already.
    files: tuple[tuple[str, str], ...] = ()  #: Files of the options of seams, and their SHA-256.


def open_part(part: str, words: Sequence[str], *, use_cache: bool) -> OpenedPart:
    """Read a part, find its features and seams, draw it, and prepare writing it moved.

    Raises `WpcalError` when the part or an option cannot be used.
    """
    from cad.step.open_text import require_step_file
    from cad.step.write import know_part

    flush_later()  # a batch that continues checks the hashes of what it finds
    path = Path(part)
    require_step_file(path)
    with noted_files() as read, read_words(words) as (asked, _):
        options, choice = asked.fitting.seams, asked.choice.to_choice()
    kept = user_cache() if use_cache else NO_CACHE
    workpiece = open_workpiece(path, cache=_HeldAnswers(kept.folder, kept.most_mb))
    found = find_seams(workpiece, options, choice)
    draw_part(workpiece.file)
    _ = workpiece.trimmed  # found once, here
    step = workpiece.file.hand_over_step()
    known = know_part(step)
    means = Means(lambda *_: found, partial(_write_moved, step.without_shapes(), known))
    return OpenedPart(workpiece, workpiece.file.sha256, means, tuple(read.items()))


def _write_moved(
    step: StepPart, known: KnownPart, file: StepFile, T_base_part: RigidTransform, path: Path, **settings: Any
) -> tuple[Issue, ...]:
    from cad.step.write import write_moved_step

    settings.pop("progress")
    if settings["T_part_moved"] is not None:  # bodies are drawn apart: that takes the shapes
        step = file.hand_over_step()
    return write_moved_step(step, T_base_part, path, known=known, **settings)


def run_job(
    opened: OpenedPart,
    *,
    folder: Path,
    name: str,
    part: str,
    taught: str,
    words: Sequence[str],
    out: Path,
    pages: str,
    origins: Mapping[str, str] = NO_ORIGINS,
) -> dict[str, Any]:
    """Calibrate one part, and let the folder with its results appear as a whole. The fields of its line in the summary.

    Raises `WpcalError` when something cannot be used. Nothing is changed then.
    """
    began = time.perf_counter()
    here, new = Path(), folder / name
    folder.mkdir()
    with noted_files([(part, opened.sha256), *opened.files]) as read, read_words(words) as (asked, _):
        taught_sha256 = sha256_at(taught, here)
        arguments = calibrate_arguments(asked, part=Path(part), taught=Path(taught), out=new)
    inputs = JobInputs((part, opened.sha256), (taught, taught_sha256), tuple(words), files_read(read, taught))
    accept_unsure = asked.output.accept_unsure
    means = replace(opened.means, wants_page=lambda result: _wants_page(result, Pages(pages), accept_unsure))
    written = calibrate_files(opened.workpiece, **arguments, means=means)
    result = {**result_of(written), "exit_code": exit_code(written.result, accept_unsure=accept_unsure)}
    (new / JOB_FILE).write_text(job_record(name, inputs.called(origins), result, new), encoding="utf-8")
    put_job_in_place(new, out)
    return {**result, "seconds": time.perf_counter() - began}


def _wants_page(result: CalibrationResult, pages: Pages, accept_unsure: bool) -> bool:
    return pages is Pages.ALL or (pages is Pages.FAIL and exit_code(result, accept_unsure=accept_unsure) != 0)


def files_of_options(words: Sequence[str], part: str, taught: str) -> tuple[str, ...]:
    """Return the files that options name, and those that these name. If an option cannot be used: what was read."""
    with noted_files() as read, suppress(WpcalError), read_words(words) as (asked, _):
        calibrate_arguments(asked, part=Path(part), taught=Path(taught), out=Path())
    return tuple(name for name, _ in files_read(read, taught))


def result_of(written: WrittenCalibration | WorkpieceCalibration) -> dict[str, Any]:
    """Return the numbers of a calibration that the summary lists; lengths in mm, angles in degrees."""
    result = written.result
    return {
        "verdict": result.verdict,
        "worst_residual_mm": result.largest_mm,
        "worst_point": result.worst,
        "objective_mm": result.objective_mm,
        "bound_mm": result.lower_bound_mm,
        "worst_seam_error_mm": worst_seam_error_mm(written),
        "worst_seam": result.judgement.seam or None,
        "pose": result.T_base_part.to_record(),
    }
