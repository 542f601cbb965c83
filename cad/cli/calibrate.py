"""`wpcal calibrate`: the main job."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cad.cli.options import MESH, PART, REQUEST, no_cache_option
from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import path_argument, path_option

if TYPE_CHECKING:
    from cad.batch.request import Request
    from cad.workpiece.calibrate import WrittenCalibration


def _require_taught(context: click.Context, parameter: click.Parameter, value: Path | None) -> Path | None:
    """Refuse a command without points, before any other option that is missing is told; --from has them."""
    if value is None and context.params.get("results_from") is None and not context.resilient_parsing:
        raise click.MissingParameter(ctx=context, param=parameter, param_hint="'TAUGHT'")
    return value


@command()
@path_argument("part_step", metavar="PART.step")
@path_argument("taught", metavar="[TAUGHT]", required=False, callback=_require_taught)
@click.option(
    "--from",
    "results_from",
    metavar="KIND:ADDRESS",
    help="With --touches: read the results over the network (ur: of the next run) into the folder TAUGHT.  "
    "[default: results, beside the plan]",
)
@path_option("-o", "--out", required=True, help="Output: a folder.")
@takes("request", REQUEST, later=True)
@no_cache_option
def calibrate(
    *,
    part_step: Path,
    taught: Path | None,
    results_from: str | None,
    out: Path,
    request: Callable[[], Request],
    no_cache: bool,
) -> int:
    """Fit PART.step to the points in TAUGHT and write its weld seams in robot coordinates.

    TAUGHT is a table (.csv) or the controller's own program (`wpcal taught` shows what it reads).
    With --touches, TAUGHT is the file (or a folder with the files) in which a touch program stored its results; the
    criterion is then weighted if none is given, and the place of the part in the plan is the nominal place. With --from
    these files are read from the robot.

    A table has the columns name, x_mm, y_mm, z_mm. Optional columns: feature (or model_x_mm, model_y_mm, model_z_mm)
    and use (yes, check, no). Without them, name is the name of the feature (`wpcal features` lists the names). If the
    cell in the column feature is empty, wpcal identifies the feature (see `wpcal match`). A column sigma_mm, or
    cov_xx_mm2, cov_xy_mm2, cov_xz_mm2, cov_yy_mm2, cov_yz_mm2, cov_zz_mm2, states the error of each point. With a
    column kind, rows may be touched on planes, edges, holes, cylinders, spheres and surfaces.

    A point of a program is the feature with the same name. If the part has no such feature, wpcal identifies it.
    Coordinates in a user frame need the values of the frame: from the file, or from --uframe.

    The verdict is PASS if all accepted seams are shown to be within the tolerance with 95 % confidence, FAIL if the
    points contradict each other or their stated error or a seam is shown to be outside, and UNSURE otherwise. UNSURE
    names the seam and the point to touch next. Ends with code 1 unless the verdict is PASS.
    """
    from cad.batch.recorded import asked_inputs
    from cad.batch.request import calibrate_arguments
    from cad.cli.kernel_work import run_on_part
    from wpcal.cli.calibration_tables import exit_code
    from wpcal.core.input_file import noted_files

    with noted_files() as read:
        asked = request()
        if results_from is not None:
            taught = results_of_robot(results_from, asked, taught)
        assert taught is not None
        arguments = calibrate_arguments(asked, part=part_step, taught=taught, out=out)
        inputs = asked_inputs(click.get_current_context(), part_step, taught, arguments["taught"].sha256, read)
    written: WrittenCalibration = run_on_part(
        "cad.batch.recorded:calibrate_recorded",
        part_step,
        {**arguments, "inputs": inputs, "accept_unsure": asked.output.accept_unsure},
        what=f"calibrating {part_step}",
        use_cache=not no_cache,
        needs=(PART, MESH),
    )
    if asked.output.as_json:
        print_json(written.record)
    else:
        show_written(written, out, details=asked.output.details)
    return exit_code(written.result, accept_unsure=asked.output.accept_unsure)


def results_of_robot(robot: str, asked: Request, folder: Path | None) -> Path:
    """Read the results of a touch program from a controller into a folder, and return the folder.

    Raises `InputError` when no plan is given, they cannot be read, or other results are there.
    """
    from cad.cli.pick_start import credentials_asked
    from wpcal.core.errors import ErrorCode, InputError
    from wpcal.core.records import write_file
    from wpcal.robot.links.registry import link_opener

    plan = asked.touching.touches
    if plan is None:
        raise InputError("--from reads the results of a touch program; give its plan with --touches")
    folder = folder or plan.parent / "results"
    link = link_opener(robot, credentials_asked())[1]()
    try:
        files = link.results(plan)
    finally:
        link.close()
    folder.mkdir(exist_ok=True)
    for name, data in files.items():
        path = folder / Path(name).name
        if path.exists() and path.read_bytes() != data and not asked.output.force:
            raise InputError(f"{path}: holds other results; --force replaces them", code=ErrorCode.EXISTS)
        write_file(path, data, overwrite=True)
    click.echo(f"read {', '.join(sorted(files))} from {robot.partition(',')[0]} into {folder}", err=True)
    return folder


def show_written(written: WrittenCalibration, out: Path, *, details: bool = False) -> None:
    """Print the seams, the bodies that moved, the points, the verdict and what was written."""
    from cad.cli.tables import seams_table
    from wpcal.cli.bodies_tables import show_bodies, show_sentence
    from wpcal.cli.calibration_tables import show_calibration
    from wpcal.cli.console import plain_console, show_notes

    console = plain_console()
    bodies = written.record.get("bodies")
    if bodies is not None:
        show_sentence(bodies, console)
    title = "Seams (base frame in the files)"
    console.print(seams_table(written.seams, title, written.u95_mm, with_gaps=bodies is None))
    refused = sum(not seam.accepted for seam in written.seams)
    if refused:
        console.print(f"{refused} candidates were not accepted as welds; wpcal seams lists them with the reasons")
    if bodies is not None:
        show_bodies(bodies, console, details=details)
    show_calibration(written.result, console, details=details, record=written.record)
    if "left_out" in written.record:
        listed = ", ".join(written.record["left_out"])
        console.print(f"note: left out by hand (use no): {listed}")
    show_notes(written.notes, console)
    console.print(f"wrote {', '.join(written.files)} to {out}")
