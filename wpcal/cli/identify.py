"""`wpcal identify`: a robot's real parameters from measured poses, and which poses to measure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import option, takes
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP

if TYPE_CHECKING:
    from wpcal.robot.identify.identifiability import Noise
    from wpcal.robot.identify.identification import Identification, IdentifyOptions
    from wpcal.robot.kinematics.arm import Arm


@dataclass(frozen=True, slots=True, kw_only=True)
class FitFlags:
    """What is identified, by which solver, and how it is judged."""

    solver: str = option(
        "--method",
        type=click.Choice(["least-squares", "ga-tabu"]),
        default="least-squares",
        show_default=True,
        help="How the parameters are found: least squares, or the published genetic and tabu search, to compare.",
    )
    unknown_base: bool = option(
        "--unknown-base", is_flag=True, help="The frame of the measurement is not the robot's base: identify it, too."
    )
    unknown_tool: bool = option(
        "--unknown-tool",
        is_flag=True,
        help="The measured point is at an unknown place on the flange: identify it, too.",
    )
    parameters: str | None = option(
        "--parameters", metavar="NAMES", help="Link parameters to identify, as theta1,d1,…; all by default."
    )
    folds: int | None = option(
        "--folds", type=click.IntRange(min=2), help="Number of folds to judge by, instead of one set of test poses."
    )
    leave_out: str | None = option(
        "--leave-out",
        metavar="ROWS",
        help="Lines of the file that are not used, as 57,58: outliers that you agree to drop.",
    )
    noise_mm: float | None = option(
        "--noise-mm", type=click.FloatRange(min=0, min_open=True), help="Noise of a measured coordinate (one sigma)."
    )
    noise_deg: float | None = option(
        "--noise-deg", type=click.FloatRange(min=0, min_open=True), help="Noise of a measured angle (one sigma)."
    )
    expected_mm: float = option(
        "--expected-mm",
        type=click.FloatRange(min=0, min_open=True),
        default=2.0,
        show_default=True,
        help="Expected error of a length; ga-tabu searches three times as far.",
    )
    expected_deg: float = option(
        "--expected-deg",
        type=click.FloatRange(min=0, min_open=True),
        default=0.2,
        show_default=True,
        help="Expected error of an angle; ga-tabu searches three times as far.",
    )
    seed: int = option(
        "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of all random numbers."
    )

    def to_noise(self) -> Noise | None:
        """Return the stated noise of a measurement, in millimetres and radians.

        Raises
        ------
        InputError
            If only one of the two is given.
        """
        from wpcal.core.errors import InputError
        from wpcal.robot.identify.identifiability import Noise

        if self.noise_mm is not None and self.noise_deg is not None:
            return Noise(self.noise_mm, math.radians(self.noise_deg))
        if self.noise_mm is not None or self.noise_deg is not None:
            raise InputError("give --noise-mm and --noise-deg together, or neither")
        return None

    def to_options(self) -> IdentifyOptions:
        """Return the options as the identification takes them, in millimetres and radians."""
        from wpcal.robot.identify.identification import IdentificationSolver, IdentifyOptions

        names = self.parameters
        return IdentifyOptions(
            solver=IdentificationSolver(self.solver),
            free_base=self.unknown_base,
            free_tool=self.unknown_tool,
            parameters=None if names is None else tuple(name.strip() for name in names.split(",")),
            noise=self.to_noise(),
            folds=self.folds,
            seed=self.seed,
            expected_mm=self.expected_mm,
            expected_rad=math.radians(self.expected_deg),
            leave_out=self.to_rows(),
        )

    def to_rows(self) -> tuple[int, ...]:
        """Return the lines of the file to leave out.

        Raises
        ------
        InputError
            When one of them is not a whole number.
        """
        from wpcal.core.errors import InputError
        from wpcal.core.numbers import parse_whole_number

        cells = [] if self.leave_out is None else self.leave_out.split(",")
        try:
            return tuple(parse_whole_number(cell) for cell in cells)
        except ValueError:
            raise InputError(f"rows to leave out: expected line numbers as 57,58, got {self.leave_out!r}") from None


@dataclass(frozen=True, slots=True, kw_only=True)
class PosePlanFlags:
    """How many poses to choose for a measurement, and where they may be."""

    count: int | None = option(
        "--plan", metavar="N", type=click.IntRange(min=1), help="Choose N poses to measure, identify nothing."
    )
    positions_only: bool = option(
        "--positions-only", is_flag=True, help="With --plan: the instrument gives no orientations."
    )
    above_mm: float | None = option(
        "--above-mm", type=float, help="With --plan: least height of the flange in the base."
    )


@click.command()
@click.argument("robot", metavar="ROBOT")
@click.argument("poses_csv", metavar="[POSES.csv]", type=click.Path(path_type=Path), required=False)
@click.option(
    "-o", "--out", "output", metavar="DIR", type=click.Path(path_type=Path), required=True, help="Output: a folder."
)
@takes("fit", FitFlags)
@takes("plan", PosePlanFlags)
@click.option("--charts/--no-charts", default=True, show_default=True, help="Draw charts; needs matplotlib.")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the files of this command in the folder.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: identification.json, or the poses of --plan.")
def identify(
    *,
    robot: str,
    poses_csv: Path | None,
    output: Path,
    fit: FitFlags,
    plan: PosePlanFlags,
    charts: bool,
    force: bool,
    as_json: bool,
) -> int:
    """Identify the parameters of ROBOT from measured poses, and test them on poses that were not fitted.

    ROBOT is an arm file or the name of a shipped arm (mh6, m10ia, …). POSES.csv has the columns q1_deg…q6_deg, x_mm,
    y_mm, z_mm. Optional columns: the measured orientation as qx, qy, qz, qw or rx_deg, ry_deg, rz_deg; reflector, if
    the tool has several; set (train, test) to choose the test poses.

    Writes identified.json (an arm file), identification.json and charts. Ends with code 1, without identified.json,
    if the test poses show no improvement.
    """
    from wpcal.core.errors import InputError
    from wpcal.core.records import check_writable
    from wpcal.robot.kinematics.arm_file import find_arm

    options = fit.to_options()
    check_writable(output, overwrite=force)
    arm = find_arm(robot)
    if plan.count is not None:
        if poses_csv is not None:
            raise InputError("--plan chooses poses to measure; leave out POSES.csv")
        return _plan(arm, plan.count, options, plan, output, force=force, as_json=as_json)
    if poses_csv is None:
        raise InputError("POSES.csv is missing; give the measured poses, or --plan N to choose some")
    return _identify(arm, poses_csv, options, output, charts=charts, force=force, as_json=as_json)


def _identify(
    arm: Arm, poses_csv: Path, options: IdentifyOptions, output: Path, *, charts: bool, force: bool, as_json: bool
) -> int:
    from importlib.util import find_spec

    from wpcal.cli.progress import shown_progress
    from wpcal.core.errors import InputError
    from wpcal.core.records import to_json
    from wpcal.robot.identify.identification import identify_arm
    from wpcal.robot.identify.identification_record import identification_record
    from wpcal.robot.identify.poses_file import read_poses

    if charts and find_spec("matplotlib") is None:
        raise InputError("the charts need matplotlib: install wpcal[plots], or give --no-charts")
    observations, test = read_poses(poses_csv, arm.as_nominal())
    with shown_progress(f"identifying {arm.name} from {len(observations)} poses"):
        result = identify_arm(arm, observations, options=options, test=test)
    record = identification_record(result)
    _write(result, to_json(record), output, charts=charts, force=force)
    if as_json:
        click.echo(to_json(record), nl=False)
    else:
        from wpcal.cli.console import plain_console
        from wpcal.cli.identification_tables import show_identification

        show_identification(result, plain_console())
    return 0 if result.verdict.improved else 1


def _write(result: Identification, record: str, output: Path, *, charts: bool, force: bool) -> None:
    from wpcal.core.records import new_directory, to_json, write_file
    from wpcal.robot.kinematics.arm_file import arm_record

    with new_directory(output, overwrite=force) as folder:
        write_file(folder / "identification.json", record, overwrite=True)
        if result.verdict.improved:
            write_file(folder / "identified.json", to_json(arm_record(result.arm)), overwrite=True)
        if charts:
            from wpcal.robot.identify.charts import write_charts

            write_charts(result, folder)


def _plan(
    arm: Arm, count: int, options: IdentifyOptions, flags: PosePlanFlags, output: Path, *, force: bool, as_json: bool
) -> int:
    import numpy as np

    from wpcal.cli.console import plain_console
    from wpcal.cli.identification_tables import show_plan
    from wpcal.cli.progress import shown_progress
    from wpcal.core.records import new_directory, to_json, write_file
    from wpcal.robot.identify.observability import plan_poses
    from wpcal.robot.identify.parameters import last_link_first, surrounding_parameters
    from wpcal.robot.identify.poses_file import plan_table

    nominal = arm.as_nominal()
    surroundings = surrounding_parameters(
        free_base=options.free_base, free_tool=options.free_tool, reflectors=("",) if flags.positions_only else None
    )
    with shown_progress(f"choosing {count} poses for {arm.name}"):
        plan = plan_poses(
            nominal,
            count,
            parameters=(*surroundings, *last_link_first(nominal.chain, options.parameters)),
            rng=np.random.default_rng(options.seed),
            positions_only=flags.positions_only,
            above_mm=flags.above_mm,
        )
    with new_directory(output, overwrite=force) as folder:
        write_file(folder / "plan.csv", plan_table(nominal, plan.joints), overwrite=True)
    if as_json:
        click.echo(to_json(plan.to_record(nominal)), nl=False)
    else:
        show_plan(plan, plain_console())
    return 0
