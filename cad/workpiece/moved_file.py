"""Write the moved STEP file of a part, in this process or, if it must not load the kernel, in a child process."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from cad.workpiece.step_file import StepFile
from wpcal.brep.mesh import Rgb
from wpcal.core.arrays import FloatArray
from wpcal.core.issue import Issue
from wpcal.core.progress import Progress, no_progress
from wpcal.core.transform import RigidTransform

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
