"""The steps of a calibration that can be done once for many jobs on the same part."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from cad.workpiece.moved_file import write_moved
from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import Workpiece
from wpcal.calibrate import CalibrationResult
from wpcal.core.issue import Issue
from wpcal.seam import Seam


@dataclass(frozen=True, slots=True)
class Means:
    """The steps of a calibration that a batch does once per part instead of once per job.

    Parameters
    ----------
    find_seams : callable
        As `cad.workpiece.seams.find_seams`.
    write_moved : callable
        As `cad.workpiece.moved_file.write_moved`.
    wants_page : callable
        Tells of a result whether its page is written.
    """

    find_seams: Callable[..., tuple[tuple[Seam, ...], Workpiece]] = find_seams
    write_moved: Callable[..., tuple[Issue, ...]] = write_moved
    wants_page: Callable[[CalibrationResult], bool] = lambda _: True


USUAL_MEANS = Means()
"""Those of one calibration."""
