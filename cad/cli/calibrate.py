"""`wpcal calibrate`: the main job."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cad.cli.options import fit_options, seam_choice_options, seam_options, to_calibrate_options
from wpcal.cli.program_options import program_options, read_touched

if TYPE_CHECKING:
    from cad.workpiece.calibrate import WrittenCalibration
    from wpcal.planning.cell.grasp import Holding


@click.command()
@click.argument("part_step", metavar="PART.step", type=click.Path(path_type=Path))
@click.argument("taught", metavar="TAUGHT", type=click.Path(path_type=Path))
@click.option("-o", "--out", required=True, type=click.Path(path_type=Path), help="Folder to write into.")
@fit_options
@seam_options
@click.option(
    "--cell",
    "cell_json",
    metavar="CELL.json",
    type=click.Path(path_type=Path),
    help="With --holder-joints: the cell of two robots; cell.json with the part's place in the gripper is written.",
)
@click.option("--holder-joints", metavar="Q1,…,Q6", help="Shown angles of robot 2 while it held the part, deg.")
@program_options
@seam_choice_options
@click.option("--mark-seams", is_flag=True, help="Write the seams as named edges into the moved STEP file.")
@click.option("--bake", is_flag=True, help="Move the geometry itself in the STEP file: no new assembly level.")
@click.option("--force", is_flag=True, help="Write into a folder that exists and holds files.")
@click.option("--json", "as_json", is_flag=True, help="Print calibration.json on stdout.")
def calibrate(*, part_step: Path, taught: Path, out: Path, force: bool, as_json: bool, **values: Any) -> int:
    """Fit PART.step to the points in TAUGHT and write its weld seams in robot coordinates.

    TAUGHT is a table (.csv) or the controller's own program (RAPID .mod, KRL .dat, FANUC .ls, INFORM .jbi).

    A table has the columns name, x_mm, y_mm, z_mm, and where wanted feature (or model_x_mm, model_y_mm,
    model_z_mm) and use (yes, check, no). Without them the name is the feature's name (`wpcal features` lists them).
    Where the cell of the column feature is empty, the feature is found (see `wpcal match`). A column sigma_mm, or
    cov_xx_mm2, cov_xy_mm2, cov_xz_mm2, cov_yy_mm2, cov_yz_mm2, cov_zz_mm2, says how far each point may be off. With a
    column kind rows may be touched on planes, edges, holes, cylinders, spheres and surfaces.

    A point of a program is the feature that has its name; for names that the part does not have it is found as well.
    Coordinates in a user frame need the frame's values: those that the file carries, or --uframe.

    Ends with code 1 when a residual is larger than the tolerance.
    """
    written = run_calibration(part_step, taught, out, force=force, **values)
    if as_json:
        from wpcal.core.records import to_json

        click.echo(to_json(written.record), nl=False)
    else:
        show_written(written, out)
    return 0 if written.result.verdict == "PASS" else 1


def run_calibration(part_step: Path, taught: Path, out: Path, *, force: bool, **values: Any) -> WrittenCalibration:
    """Check what can be checked without the kernel, then calibrate in a child process."""
    from cad.cli.progress import shown_progress
    from cad.kernel.child import run_in_child
    from wpcal.core.records import check_writable

    options, nominal = to_calibrate_options(values)
    holding = read_holder(values["cell_json"], values["holder_joints"])
    check_writable(out, overwrite=force)
    points = read_touched(taught, values)
    arguments = {
        "step": part_step,
        "taught": points,
        "out": out,
        "overwrite": force,
        "T_nominal_part": nominal,
        "options": options,
        "mark_seams": values["mark_seams"],
        "bake": values["bake"],
    }
    with shown_progress() as progress:
        written: WrittenCalibration = run_in_child(
            "cad.workpiece.calibrate:calibrate_files", arguments, what=f"calibrating {part_step}", progress=progress
        )
    return written if holding is None else write_grasp(holding, written, out)


def read_holder(cell_json: Path | None, joints_deg: str | None) -> Holding | None:
    """Read the cell and the joints of robot 2 where both are given.

    Raises
    ------
    InputError
        When only one of them is.
    """
    from wpcal.core.errors import InputError
    from wpcal.planning.cell.grasp import read_holding

    if (cell_json is None) != (joints_deg is None):
        raise InputError("--cell and --holder-joints belong together: where robot 2 stands and how it held the part")
    return None if cell_json is None or joints_deg is None else read_holding(cell_json, joints_deg)


def write_grasp(holding: Holding, written: WrittenCalibration, out: Path) -> WrittenCalibration:
    """Write the cell with the part's place in the gripper beside the calibration."""
    from dataclasses import replace

    from wpcal.core.records import to_json, write_file
    from wpcal.planning.cell.grasp import cell_files, solve_grasp

    files = cell_files(holding, solve_grasp(holding, written.result.T_base_part))
    for name, record in files.items():
        write_file(out / name, to_json(record), overwrite=True)  # the folder was new, or --force was given
    return replace(written, files=(*written.files, *files))


def show_written(written: WrittenCalibration, out: Path) -> None:
    """Print the points, the seams, the verdict and what was written."""
    from cad.cli.tables import seams_table
    from wpcal.cli.calibration_tables import show_calibration
    from wpcal.cli.console import plain_console

    console = plain_console()
    console.print(seams_table(written.seams, "Seams (base frame in the files)", written.u95_mm))
    refused = sum(not seam.accepted for seam in written.seams)
    if refused:
        console.print(f"{refused} candidates were not taken as welds: wpcal seams lists them and says why")
    show_calibration(written.result, console)
    if "left_out" in written.record:
        listed = ", ".join(written.record["left_out"])
        console.print(f"note: left out by hand (use no): {listed}", highlight=False, markup=False)
    for issue in written.notes:
        console.print(f"note: {issue.message}", highlight=False, markup=False)
    console.print(f"wrote {', '.join(written.files)} to {out}", highlight=False, markup=False)
