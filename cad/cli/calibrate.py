"""`wpcal calibrate`: the main job."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cad.cli.options import read_pose, seam_choice_options, seam_options, to_seam_choice, to_seam_options

if TYPE_CHECKING:
    from cad.convert import WrittenCalibration


@click.command()
@click.argument("part_step", metavar="PART.step", type=click.Path(path_type=Path))
@click.argument("taught_csv", metavar="TAUGHT.csv", type=click.Path(path_type=Path))
@click.option("-o", "--out", required=True, type=click.Path(path_type=Path), help="Folder to write into.")
@click.option("--tolerance-mm", type=float, default=0.5, show_default=True, help="A larger residual ends with code 1.")
@click.option(
    "--criterion",
    type=click.Choice(["minimax", "least_squares", "weighted", "robust"]),
    default="minimax",
    show_default=True,
)
@click.option("--solver", type=click.Choice(["annealing", "exact"]), default="annealing", show_default=True)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of every random number.")
@click.option(
    "--nominal",
    metavar="POSE",
    help="Where the cell's model has the part: x,y,z,a,b,c in mm and degrees with R = Rz(c) Ry(b) Rx(a), or a JSON "
    "file with a 4×4 matrix.",
)
@click.option("--sigma-mm", type=float, help="Teaching error: standard deviation per axis.")
@click.option("--bound-mm", type=float, help="Teaching error: greatest error per axis.")
@click.option("--tcp-bias-mm", type=float, default=0.0, show_default=True, help="Error of the tool centre point.")
@click.option("--certify", is_flag=True, help="Close a gap by branch and bound over all rotations (slow).")
@seam_options
@seam_choice_options
@click.option("--mark-seams", is_flag=True, help="Write the seams as named edges into the moved STEP file.")
@click.option("--bake", is_flag=True, help="Move the geometry itself in the STEP file: no new assembly level.")
@click.option("--force", is_flag=True, help="Write into a folder that exists and holds files.")
@click.option("--json", "as_json", is_flag=True, help="Print calibration.json on stdout.")
def calibrate(*, part_step: Path, taught_csv: Path, out: Path, force: bool, as_json: bool, **values: Any) -> int:
    """Fit PART.step to the points in TAUGHT.csv and write its weld seams in robot coordinates.

    TAUGHT.csv has the columns name, x_mm, y_mm, z_mm, and where wanted feature (or model_x_mm, model_y_mm,
    model_z_mm) and use (yes, check, no). Without them the name is the feature's name (`wpcal features` lists them).
    Where the cell of the column feature is empty, the feature is found (see `wpcal match`).
    Ends with code 1 when a residual is larger than the tolerance.
    """
    written = run_calibration(part_step, taught_csv, out, force=force, **values)
    if as_json:
        from wpcal.core.records import to_json

        click.echo(to_json(written.record), nl=False)
    else:
        show_written(written, out)
    return 0 if written.result.verdict == "PASS" else 1


def run_calibration(part_step: Path, taught_csv: Path, out: Path, *, force: bool, **values: Any) -> WrittenCalibration:
    """Check what can be checked without the kernel, then calibrate in a child process."""
    from cad.child import run_in_child
    from cad.cli.progress import shown_progress
    from cad.convert import CalibrateOptions
    from wpcal.calibrate import Criterion, Solver, TeachingError
    from wpcal.core.records import check_writable
    from wpcal.match import read_taught

    seams = to_seam_options(values)
    options = CalibrateOptions(
        criterion=Criterion(values["criterion"]),
        solver=Solver(values["solver"]),
        seed=values["seed"],
        tolerance_mm=values["tolerance_mm"],
        teaching=TeachingError(
            sigma_mm=values["sigma_mm"], bound_mm=values["bound_mm"], tcp_bias_mm=values["tcp_bias_mm"]
        ),
        seams=seams,
        certify=values["certify"],
        choice=to_seam_choice(values),
    )
    nominal = None if values["nominal"] is None else read_pose(values["nominal"])
    check_writable(out, overwrite=force)
    read_taught(taught_csv)
    arguments = {
        "step": part_step,
        "taught": taught_csv,
        "out": out,
        "overwrite": force,
        "T_nominal_part": nominal,
        "options": options,
        "mark_seams": values["mark_seams"],
        "bake": values["bake"],
    }
    with shown_progress() as progress:
        written: WrittenCalibration = run_in_child(
            "cad.convert:calibrate_files", arguments, what=f"calibrating {part_step}", progress=progress
        )
    return written


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
    for issue in written.record["issues"][len(written.result.warnings) :]:
        console.print(f"note: {issue['message']}", highlight=False, markup=False)
    console.print(f"wrote {', '.join(written.files)} to {out}", highlight=False, markup=False)
