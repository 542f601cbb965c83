"""`wpcal identify`: a robot's real parameters from measured poses, and which poses to measure."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, path_argument, path_option
from wpcal.core.options import opt

if TYPE_CHECKING:
    from wpcal.robot.identify.identifiability import Noise
    from wpcal.robot.identify.identification import Identification, IdentifyOptions
    from wpcal.robot.identify.observability import PosePlan
    from wpcal.robot.kinematics.arm import Arm


@dataclass(frozen=True, slots=True, kw_only=True)
class NoiseAsked:
    """The noise of a measurement, as a person states it."""

    noise_mm: float | None = opt(None, "Noise of a measured coordinate (one sigma).", above=0)
    noise_deg: float | None = opt(None, "Noise of a measured angle (one sigma).", above=0)

    def to_noise(self) -> Noise | None:
        """Return it in millimetres and radians. Raises `InputError` if only one of the two is given."""
        from wpcal.core.errors import InputError
        from wpcal.robot.identify.identifiability import Noise

        if self.noise_mm is not None and self.noise_deg is not None:
            return Noise(self.noise_mm, math.radians(self.noise_deg))
        if self.noise_mm is not None or self.noise_deg is not None:
            raise InputError("give --noise-mm and --noise-deg together, or neither")
        return None


@dataclass(frozen=True, slots=True, kw_only=True)
class PosesAsked:
    """How many poses to choose for a measurement, and where they may be."""

    count: int | None = opt(None, "Choose N poses to measure, identify nothing.", "--plan", metavar="N", least=1)
    positions_only: bool = opt(False, "With --plan: the instrument gives no orientations.")
    above_mm: float | None = opt(None, "With --plan: least height of the flange in the base.")


@command()
@click.argument("robot", metavar="ROBOT")
@path_argument("poses_csv", metavar="[POSES.csv]", required=False)
@path_option("-o", "--out", "output", metavar="DIR", required=True, help="Output: a folder.")
@takes("options", "wpcal.robot.identify.identification:IdentifyOptions")
@takes("noise", NoiseAsked)
@takes("plan", PosesAsked)
@click.option("--charts/--no-charts", default=True, show_default=True, help="Draw charts; needs matplotlib.")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the files of this command in the folder.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: identification.json, or the poses of --plan.")
def identify(
    *,
    robot: str,
    poses_csv: Path | None,
    output: Path,
    options: IdentifyOptions,
    noise: NoiseAsked,
    plan: PosesAsked,
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
    from importlib.util import find_spec

    from wpcal.core.errors import InputError
    from wpcal.core.records import check_writable, to_json
    from wpcal.robot.identify.identification_record import identification_record
    from wpcal.robot.kinematics.arm_file import find_arm

    options = replace(options, noise=noise.to_noise())
    check_writable(output, overwrite=force)
    arm = find_arm(robot)
    if plan.count is not None:
        if poses_csv is not None:
            raise InputError("--plan chooses poses to measure; leave out POSES.csv")
        return _write_plan(arm, _planned(arm, plan.count, options, plan), output, force=force, as_json=as_json)
    if poses_csv is None:
        raise InputError("POSES.csv is missing; give the measured poses, or --plan N to choose some")
    if charts and find_spec("matplotlib") is None:
        raise InputError("the charts need matplotlib: install wpcal[plots], or give --no-charts")
    result = _identified(arm, poses_csv, options)
    record = to_json(identification_record(result))
    _write(result, record, output, charts=charts, force=force)
    if as_json:
        click.echo(record, nl=False)
    else:
        from wpcal.cli.console import plain_console
        from wpcal.cli.identification_tables import show_identification

        show_identification(result, plain_console())
    return 0 if result.verdict.improved else 1


def _identified(arm: Arm, poses_csv: Path, options: IdentifyOptions) -> Identification:
    from wpcal.cli.progress import shown_progress
    from wpcal.robot.identify.identification import identify_arm
    from wpcal.robot.identify.poses_file import read_poses

    observations, test = read_poses(poses_csv, arm.as_nominal())
    with shown_progress(f"identifying {arm.name} from {len(observations)} poses"):
        return identify_arm(arm, observations, options=options, test=test)


def _write(result: Identification, record: str, output: Path, *, charts: bool, force: bool) -> None:
    from wpcal.core.records import new_directory, to_json, write_file
    from wpcal.robot.kinematics.arm_file import arm_record

    with new_directory(output, overwrite=force) as folder:
        write_file(folder / "identification.json", record, overwrite=True)
        if result.verdict.improved:
            write_file(folder / "identified.json", to_json(arm_record(result.arm)), overwrite=True)
        if charts:
            from wpcal.robot.identify.identification_record import write_charts

            write_charts(result, folder)


def _planned(arm: Arm, count: int, options: IdentifyOptions, asked: PosesAsked) -> PosePlan:
    import numpy as np

    from wpcal.cli.progress import shown_progress
    from wpcal.robot.identify.observability import plan_poses
    from wpcal.robot.identify.parameters import last_link_first, surrounding_parameters

    nominal = arm.as_nominal()
    surroundings = surrounding_parameters(
        free_base=options.free_base, free_tool=options.free_tool, reflectors=("",) if asked.positions_only else None
    )
    with shown_progress(f"choosing {count} poses for {arm.name}"):
        return plan_poses(
            nominal,
            count,
            parameters=(*surroundings, *last_link_first(nominal.chain, options.parameters)),
            rng=np.random.default_rng(options.seed),
            positions_only=asked.positions_only,
            above_mm=asked.above_mm,
        )


def _write_plan(arm: Arm, plan: PosePlan, output: Path, *, force: bool, as_json: bool) -> int:
    from wpcal.cli.console import plain_console
    from wpcal.cli.identification_tables import show_plan
    from wpcal.core.records import new_directory, write_file
    from wpcal.robot.identify.poses_file import plan_table

    nominal = arm.as_nominal()
    with new_directory(output, overwrite=force) as folder:
        write_file(folder / "plan.csv", plan_table(nominal, plan.joints), overwrite=True)
    if as_json:
        print_json(plan.to_record(nominal))
    else:
        show_plan(plan, plain_console())
    return 0
