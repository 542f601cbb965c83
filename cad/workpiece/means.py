"""The steps of a calibration that can be done once for many jobs on the same part, and what is written about a run."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from cad.workpiece.seams import find_seams
from cad.workpiece.step_file import StepFile
from cad.workpiece.workpiece import Workpiece
from wpcal.brep.mesh import Rgb
from wpcal.calibrate import CalibrationResult
from wpcal.core.arrays import FloatArray
from wpcal.core.issue import Issue
from wpcal.core.progress import Progress, no_progress
from wpcal.core.transform import RigidTransform
from wpcal.seam import Seam

SeamLine = tuple[str, FloatArray, Rgb]  #: Name, points, shape (m, 3), in `part`, mm, and sRGB colour.


def write_moved(
    file: StepFile,
    T_base_part: RigidTransform,
    path: Path,
    *,
    seams: Sequence[SeamLine],
    bake: bool,
    T_part_moved: FloatArray | None = None,
    progress: Progress = no_progress,
) -> tuple[Issue, ...]:
    """Write a moved STEP file; parameters, result and errors as in `write_moved_step`.

    `T_part_moved`: shape (solids, 4, 4).
    """
    if file.cache.kernel:
        from cad.step.write import write_moved_step

        return write_moved_step(
            file.hand_over_step(), T_base_part, path, bake=bake, seams=seams, T_part_moved=T_part_moved
        )
    from cad.work.child import run_in_child

    arguments = {"name": file.file_name, "data": file.data, "T_base_part": T_base_part, "path": path}
    issues: tuple[Issue, ...] = run_in_child(
        "cad.step.write:write_moved_data",
        {**arguments, "seams": list(seams), "bake": bake, "T_part_moved": T_part_moved},
        what=f"moving {file.path}",
        progress=progress,
    )
    return issues


def _not_sealed(_: object, __: Path) -> None:
    return


@dataclass(frozen=True, slots=True)
class Means:
    """The steps of a calibration that a batch does once per part instead of once per job, and what commands choose."""

    find_seams: Callable[..., tuple[tuple[Seam, ...], Workpiece]] = find_seams  #: As `cad.workpiece.seams.find_seams`.
    write_moved: Callable[..., tuple[Issue, ...]] = write_moved  #: As `write_moved`.
    wants_page: Callable[[CalibrationResult], bool] = lambda _: True  #: Tells of a result whether its page is written.
    #: Gets the calibration and the folder with all its files before the folder appears, and may add a file.
    seal: Callable[..., None] = _not_sealed


USUAL_MEANS = Means()  #: Those of one calibration.
