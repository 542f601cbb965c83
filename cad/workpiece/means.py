"""The steps of a calibration that can be done once for many jobs on the same part, and what is written about a run."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from cad.workpiece.moved_file import write_moved
from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import Workpiece
from wpcal.calibrate import CalibrationResult
from wpcal.core.issue import Issue
from wpcal.seam import Seam


def _not_sealed(_: object, __: Path) -> None:
    return


@dataclass(frozen=True, slots=True)
class Means:
    """The steps of a calibration that a batch does once per part instead of once per job, and what commands choose."""

    find_seams: Callable[..., tuple[tuple[Seam, ...], Workpiece]] = find_seams  #: As `cad.workpiece.seams.find_seams`.
    write_moved: Callable[..., tuple[Issue, ...]] = write_moved  #: As `cad.workpiece.moved_file.write_moved`.
    wants_page: Callable[[CalibrationResult], bool] = lambda _: True  #: Tells of a result whether its page is written.
    #: Gets the calibration and the folder with all its files before the folder appears, and may add a file.
    seal: Callable[..., None] = _not_sealed


USUAL_MEANS = Means()  #: Those of one calibration.
