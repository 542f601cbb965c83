"""`wpcal calibrate`: the main job."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from click.core import ParameterSource

from cad.cli.bodies_options import FitBodiesFlags
from cad.cli.holder import HolderFlags
from cad.cli.options import MESH, PART, CalibrateFlags, FitFlags, SeamChoiceFlags, no_cache_option
from wpcal.cli.option_groups import option, takes
from wpcal.cli.program_options import ProgramFlags
from wpcal.cli.shared_help import DETAILS_HELP, FORCE_HELP, JSON_HELP

if TYPE_CHECKING:
    from cad.workpiece.calibrate import WrittenCalibration
    from cad.workpiece.fit_taught import CalibrateOptions
    from wpcal.controllers.touch_run import TouchRun
    from wpcal.core.transform import RigidTransform


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputFlags:
    """How the results are written."""

    mark_seams: bool = option(
        "--mark-seams", is_flag=True, help="Write the seams as named edges into the moved STEP file."
    )
    bake: bool = option(
        "--bake", is_flag=True, help="Move the geometry itself in the STEP file: no new assembly level."
    )
    force: bool = option("--force", is_flag=True, help=f"{FORCE_HELP}: the files of this command in the folder.")
    accept_unsure: bool = option("--accept-unsure", is_flag=True, help="End with code 0 if the verdict is UNSURE.")
    details: bool = option("--details", is_flag=True, help=DETAILS_HELP)
    as_json: bool = option("--json", is_flag=True, help=f"{JSON_HELP}: calibration.json.")


@dataclass(frozen=True, slots=True, kw_only=True)
class TouchFlags:
    """How the results of a touch program are read."""

    touches: Path | None = option(
        "--touches",
        metavar="FILE",
        type=click.Path(path_type=Path),
        help="The plan (touches.json) whose program the robot ran. TAUGHT is then what the controller stored.",
    )
    setup: Path | None = option(
        "--setup",
        metavar="FILE",
        type=click.Path(path_type=Path),
        help="For a plan of touches: signal, speeds and names of the cell (TOML), as for its program.",
    )

    def read(self, part: Path, taught: Path, fit: FitFlags, reading: ProgramFlags) -> TouchRun | None:
        """Read the plan and the results; None without --touches.

        Raises
        ------
        InputError
            When they cannot be used, or an option does not go with them.
        """
        from wpcal.core.errors import InputError

        if self.touches is None:
            if self.setup is not None:
                raise InputError("--setup is for results of a touch program; give its plan with --touches")
            return None
        if reading.given:
            raise InputError(f"{', '.join(reading.given)} cannot be used with --touches")
        if fit.ball_mm:
            raise InputError("--ball-mm cannot be used with --touches: the plan says what meets each face")
        from wpcal.controllers.touch_run import read_touch_run

        return read_touch_run(self.touches, taught, self.setup, part=part.name)


@dataclass(frozen=True, slots=True)
class CalibrationFlags:
    """Everything that says how a part is calibrated, from the command line or from a request (`wpcal rpc`)."""

    touching: TouchFlags
    calibration: CalibrateFlags
    moving: FitBodiesFlags
    reading: ProgramFlags
    choice: SeamChoiceFlags

    def to_options(
        self, run: TouchRun | None, *, is_criterion_given: bool
    ) -> tuple[CalibrateOptions, RigidTransform | None]:
        """Check the flags and return the options, and ``T_nominal_part`` if it is known.

        Parameters
        ----------
        run : TouchRun or None
            A run of a touch program: it knows the nominal place, and its criterion is weighted if none is given.

        Raises
        ------
        InputError
            When a flag cannot be used, or not with another.
        """
        from wpcal.calibrate.trust.criteria import Criterion

        options, nominal = self.calibration.to_options(self.choice.to_choice()), self.calibration.fit.to_nominal()
        options = replace(options, bodies=self.moving.to_options())
        if options.bodies is not None:
            _refuse_rigid_only(options, is_criterion_given=is_criterion_given)
        if run is None:
            return options, nominal
        if not is_criterion_given:
            options = replace(options, criterion=Criterion.WEIGHTED)
        return options, nominal or run.T_nominal_part


def _refuse_rigid_only(options: CalibrateOptions, *, is_criterion_given: bool) -> None:
    """Refuse what only a part that moved in one piece has."""
    from wpcal.calibrate.trust.criteria import Criterion
    from wpcal.core.errors import InputError

    if options.certify:
        raise InputError("--certify cannot be used with --bodies: what it proves holds for a rigid part")
    if is_criterion_given and options.criterion is not Criterion.WEIGHTED:
        raise InputError(
            f"--criterion {options.criterion.value} cannot be used with --bodies: bodies are fitted by weighted squares"
        )


def run_arguments(run: TouchRun | None) -> dict[str, Any]:
    """Return the arguments of `cad.workpiece.calibrate.calibrate_files` about a run of a touch program."""
    return {
        "searches": None if run is None else run.record,
        "run_issues": () if run is None else run.issues,
        "silent": None if run is None else run.silent,
    }


@click.command()
@click.argument("part_step", metavar="PART.step", type=click.Path(path_type=Path))
@click.argument("taught", metavar="TAUGHT", type=click.Path(path_type=Path))
@click.option("-o", "--out", required=True, type=click.Path(path_type=Path), help="Output: a folder.")
@takes("touching", TouchFlags)
@takes("calibration", CalibrateFlags)
@takes("moving", FitBodiesFlags)
@takes("holder", HolderFlags)
@takes("reading", ProgramFlags)
@takes("choice", SeamChoiceFlags)
@takes("output", OutputFlags)
@no_cache_option
def calibrate(
    *,
    part_step: Path,
    taught: Path,
    out: Path,
    touching: TouchFlags,
    calibration: CalibrateFlags,
    moving: FitBodiesFlags,
    holder: HolderFlags,
    reading: ProgramFlags,
    choice: SeamChoiceFlags,
    output: OutputFlags,
    no_cache: bool,
) -> int:
    """Fit PART.step to the points in TAUGHT and write its weld seams in robot coordinates.

    TAUGHT is a table (.csv) or the controller's own program (RAPID .mod, KRL .dat, FANUC .ls, INFORM .jbi, AS .as).
    With --touches, TAUGHT is the file (or a folder with the files) in which a touch program stored its results; the
    criterion is then weighted if none is given, and the place of the part in the plan is the nominal place.

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
    from cad.cli.kernel_work import run_on_part
    from cad.cli.recorded import asked_inputs
    from wpcal.cli.calibration_tables import exit_code
    from wpcal.core.input_file import noted_files

    asked = CalibrationFlags(touching, calibration, moving, reading, choice)
    with noted_files() as read:
        arguments = file_arguments(asked, holder, output, part_step=part_step, taught=taught, out=out)
        inputs = asked_inputs(click.get_current_context(), part_step, taught, arguments["taught"].sha256, read)
    written: WrittenCalibration = run_on_part(
        "cad.cli.recorded:calibrate_recorded",
        part_step,
        {**arguments, "inputs": inputs, "accept_unsure": output.accept_unsure},
        what=f"calibrating {part_step}",
        use_cache=not no_cache,
        needs=(PART, MESH),
    )
    if output.as_json:
        from wpcal.core.records import to_json

        click.echo(to_json(written.record), nl=False)
    else:
        show_written(written, out, details=output.details)
    return exit_code(written.result, accept_unsure=output.accept_unsure)


def file_arguments(
    asked: CalibrationFlags, holder: HolderFlags, output: OutputFlags, *, part_step: Path, taught: Path, out: Path
) -> dict[str, Any]:
    """Read what the options name, and return the arguments of `calibrate_files` except `step`.

    Raises
    ------
    InputError
        When an option or one of its files cannot be used, or the results cannot be written to `out`.
    """
    from wpcal.core.records import check_writable

    run = asked.touching.read(part_step, taught, asked.calibration.fit, asked.reading)
    options, nominal = asked.to_options(run, is_criterion_given=is_given("criterion"))
    holding = holder.read()
    check_writable(out, overwrite=output.force)
    return {
        "taught": asked.reading.read_taught(taught) if run is None else run.taught,
        **run_arguments(run),
        "out": out,
        "overwrite": output.force,
        "T_nominal_part": nominal,
        "options": options,
        "mark_seams": output.mark_seams,
        "bake": output.bake,
        "holding": holding,
    }


def is_given(parameter: str) -> bool:
    """Whether the user typed an option of this command."""
    return click.get_current_context().get_parameter_source(parameter) is not ParameterSource.DEFAULT


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
        console.print(f"note: left out by hand (use no): {listed}", highlight=False, markup=False)
    show_notes(written.notes, console)
    console.print(f"wrote {', '.join(written.files)} to {out}", highlight=False, markup=False)
