"""`wpcal audit`: find the faults of files, and repair what has one answer."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, ROBOT_HELP, TOOL_HELP, TOOL_METAVAR, path_argument, path_option
from wpcal.cli.torch_options import TorchOfProgramAsked
from wpcal.core.options import group, opt

if TYPE_CHECKING:
    from wpcal.controllers.audit import AuditReport
    from wpcal.controllers.audit.fault import Fault
    from wpcal.controllers.audit.programs import Surroundings


@dataclass(frozen=True, slots=True, kw_only=True)
class RobotOfProgramAsked:
    """The robot that runs the programs, its tool, and how they switch the arc."""

    robot: str | None = opt(None, f"{ROBOT_HELP} Poses must be inside its limits. Needs --tool.", metavar="ARM")
    tool: str | None = opt(None, f"{TOOL_HELP} As set in the controller.", metavar=TOOL_METAVAR)
    torch: TorchOfProgramAsked = group(TorchOfProgramAsked)
    arc_output: int | None = opt(
        None,
        "Digital output that switches the arc.  [default: that in the header of the program]",
        metavar="N",
        least=0,
    )

    def to_surroundings(self) -> Surroundings:
        """Return what programs are compared with.

        Raises `InputError` when the arm or the tool cannot be used, or one of them is missing.
        """
        from wpcal.core.errors import InputError
        from wpcal.robot.identify.poses_file import parse_tool
        from wpcal.robot.kinematics.arm_file import find_arm

        if (self.robot is None) != (self.tool is None):
            raise InputError("--robot and --tool belong together; --tool 0,0,0 if the poses are those of the flange")
        around = replace(self.torch.to_surroundings(), arc_output=self.arc_output)
        if self.robot is None or self.tool is None:
            return around
        return replace(around, arm=find_arm(self.robot), T_flange_tool=parse_tool(self.tool)[0])


@command()
@path_argument("path", metavar="FILE|DIR")
@click.option("--fix", is_flag=True, help="Repair what has one answer; the rest is listed. Needs -o.")
@path_option("-o", "--out", "output", help="Output: the repaired file, with --fix.")
@takes("robot", RobotOfProgramAsked)
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the repaired file.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the record of the audit.")
def audit(*, path: Path, fix: bool, output: Path | None, robot: RobotOfProgramAsked, force: bool, as_json: bool) -> int:
    """List every fault of a file, or of the files in a folder, with its place.

    Reads tables, programs, result folders, seams.json and the other records of wpcal, robot and cell files, part.glb.
    Programs in a result folder are read back, and each pose is compared with the part. Ends with code 1 if a fault is
    left.
    """
    from wpcal.cli.progress import shown_progress
    from wpcal.controllers.audit import audit_path
    from wpcal.core.errors import InputError

    if fix != (output is not None):
        raise InputError("--fix and -o belong together: the repaired file is written to -o, never in place")
    around = robot.to_surroundings()
    with shown_progress(f"auditing {path}") as progress:
        report = audit_path(path, around, progress=progress)
    if output is not None:
        from wpcal.controllers.audit.records import repair_file

        done = repair_file(path, output, report.files[0].faults, overwrite=force)
        report = audit_path(output, around)
        _show(report, as_json=as_json, repaired=tuple(done))
    else:
        _show(report, as_json=as_json)
    return 1 if report.fault_count else 0


def _line(fault: Fault) -> str:
    place = f"{fault.place}: " if fault.place else ""
    repair = f" [--fix writes {fault.repair}]" if fault.repair else ""
    return f"  {place}{fault.message}{repair}"


def _show(report: AuditReport, *, as_json: bool, repaired: tuple[str, ...] = ()) -> None:

    if as_json:
        print_json({**report.to_record(), "repaired": list(repaired)})
        return
    for words in repaired:
        click.echo(f"repaired: {words}")
    for file in report.files:
        click.echo("\n".join([f"{file.path}: {file.kind}: {_count(len(file.faults))}", *map(_line, file.faults)]))
    if report.not_audited:
        click.echo(f"not audited, other kinds of files: {', '.join(Path(one).name for one in report.not_audited)}")
    for checked in sorted({file.checked for file in report.files if file.checked}):
        click.echo(f"poses of programs: {checked}")
    click.echo(f"{_count(len(report.files), 'file')}, {_count(report.fault_count)}")


def _count(number: int, word: str = "fault") -> str:
    return f"no {word}" if number == 0 else f"{number} {word}{'s' if number > 1 else ''}"
