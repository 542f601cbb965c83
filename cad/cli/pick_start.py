"""How `wpcal pick` and `wpcal teach` start: the part, its seams, the rows, and the robot that tells positions."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cad.cli.options import BODIES, CHOICE, FITTING, MESH, PART, POINTS, no_cache_option
from wpcal.cli.option_groups import option_names, takes
from wpcal.cli.outputs import typed_options
from wpcal.cli.shared_help import path_argument, path_option

if TYPE_CHECKING:
    from cad.batch.bodies_asked import BodiesAsked
    from cad.batch.request import NominalAsked
    from cad.batch.seams_asked import SeamsAsked
    from cad.pick.shared_seams import SharedSeams
    from cad.pick.shared_table import SharedTable
    from cad.session.part import PickPart
    from cad.session.session import PickSession
    from cad.workpiece.fit_taught import CalibrateOptions
    from wpcal.controllers.taught_program import PointsAsked
    from wpcal.robot.links.watch import Watch
    from wpcal.seam.options import Judging

NOT_CALIBRATE = ("part_step", "taught", "out", "seams", "host", "port", "browser", "other_part")
"""Arguments that are not copied to `wpcal calibrate`: it has others, the page has its own, or the table needs none."""

OF_SOLIDS = ("weld", "not", "member")  #: What is said about them is said in the page, too.

OF_RIGID_PARTS = ("criterion", "certify", "rigid")  #: Options that `wpcal calibrate` refuses if bodies may have moved.

DEFAULT_TABLE = Path("taught.csv")


@dataclass(frozen=True, slots=True, kw_only=True)
class PickAsked:
    """What both commands are asked."""

    part_step: Path
    taught: Path | None
    out: Path | None
    other_part: bool
    options: CalibrateOptions
    place: NominalAsked
    moving: BodiesAsked
    choice: SeamsAsked
    reading: PointsAsked
    no_cache: bool


@dataclass(frozen=True, slots=True, eq=False)
class Started:
    """A session with its shared table and seams."""

    session: PickSession
    table: SharedTable
    seams: SharedSeams
    command: Callable[[Path], str]  #: The line that calibrates from a table.
    notes: tuple[str, ...]
    watch: Watch | None  #: Reads the robot.
    robot: str  #: As it was typed; empty without one.

    def say_end(self) -> None:
        """Say what was saved, and where other rows are."""
        table = self.table
        click.echo(f"saved {table.out}; now: {self.command(table.out)}" if table.is_saved else "nothing was saved")
        if table.kept:
            click.echo(f"rows that are not in {table.out} are kept in {table.kept}; wpcal pick shows them again")


def pick_options(callback: Callable[..., int]) -> Callable[..., int]:
    """Add the arguments of both commands; the command gets them as one `PickAsked` by `asked_of`."""
    decorators: list[Callable[..., Any]] = [
        path_argument("part_step", metavar="PART.step"),
        path_argument("taught", metavar="[TAUGHT]", required=False),
        path_option(
            "-o",
            "--out",
            metavar="FILE",
            help="Output: the table that is saved.  [default: TAUGHT if it is a table, otherwise taught.csv]",
        ),
        click.option("--other-part", is_flag=True, help="Take rows that were taught on another part."),
        takes("options", FITTING),
        takes("place", "cad.batch.request:NominalAsked"),
        takes("moving", BODIES),
        takes("choice", CHOICE),
        takes("reading", POINTS),
        no_cache_option,
    ]
    for decorate in reversed(decorators):
        callback = decorate(callback)
    return callback


def start(ctx: click.Context, asked: PickAsked) -> Started:
    """Read the part and the rows, and reach the robot if `--robot` is KIND:ADDRESS.

    Raises `InputError` when one of them cannot be used.
    """
    from cad.pick.draft import draft_of
    from cad.pick.opening import find_table, start_table
    from cad.pick.shared_seams import seams_file_of, start_seams
    from cad.session.session import PickSession
    from cad.step.open_text import require_step_file
    from wpcal.core.input_file import STDIN, read_bytes

    watching, reading = watch_robot(asked.reading)
    part_step, taught, options = asked.part_step, asked.taught, replace(asked.options, choice=asked.choice.to_choice())
    is_asked = asked.out is not None
    out = asked.out or table_of(taught)
    program = reading.to_reading()
    chosen = asked.moving.to_choice()
    if str(part_step) != STDIN:
        require_step_file(part_step)
    require_table(out, part_step, is_asked=is_asked)
    found = find_table(out)
    is_other = taught is not None and not _is_same(taught, out) and taught != draft_of(out)
    if taught is not None and not is_other and found.raw is None and found.draft is None:
        read_bytes(taught)  # says why not
    initial = read_bytes(taught) if taught is not None and is_other else None
    search = partial(_read_part, part_step, options, use_cache=not asked.no_cache)
    before = asked.choice.seams_file or seams_file_of(part_step, out)
    part, said_notes = _first_part(search, options.seams.judging, before)
    session = PickSession(part, options, asked.place.nominal, program, groups=asked.moving.groups())
    session.choose(chosen or found.moving)
    again = None if str(part_step) == STDIN else search  # standard input was read to its end
    seams, seam_notes = start_seams(session, part_step, out, given=asked.choice.seams_file, search=again)
    command = partial(calibrate_command, ctx, part_step, seams=seams, session=session, bodies=asked.moving.file)
    given, left_out = (None, ()) if initial is None else session.read(initial, name=str(taught))
    table, notes = start_table(
        found,
        part,
        part_step=part_step,
        given=given,
        given_name=str(taught),
        force=asked.other_part,
        command=command,
        moving=session.moving,
    )
    notes = (*notes, *said_notes, *seam_notes)
    for note in (*(f"left out {point}" for point in left_out), *notes):
        click.echo(f"note: {note}", err=True)
    watch, robot = (None, "") if watching is None else (watching(), asked.reading.robot or "")
    return Started(session, table, seams, command, notes, watch, robot)


def watch_robot(reading: PointsAsked) -> tuple[Callable[[], Watch] | None, PointsAsked]:
    """Return what starts to read the robot, and the options without it; None if `--robot` is an arm.

    Raises `LinkError` when the robot does not answer now.
    """
    from wpcal.robot.links.registry import kind_of

    if reading.robot is None or kind_of(reading.robot) is None:
        return None, reading
    from wpcal.robot.identify.poses_file import parse_tool
    from wpcal.robot.kinematics.arm_file import find_arm
    from wpcal.robot.links.judge import RowJudge
    from wpcal.robot.links.registry import link_opener
    from wpcal.robot.links.watch import Watch

    address, opened = link_opener(reading.robot, credentials_asked())
    link = opened()  # here, where a person can be asked for a password
    try:
        link.read()
    finally:
        link.close()
    tool = None if reading.tool is None else parse_tool(reading.tool)[0]
    arm = None if address.arm is None else find_arm(address.arm)
    judge = RowJudge(address.tool, address.frame, tool, arm)
    return lambda: Watch(opened, judge), replace(reading, robot=None)


def credentials_asked() -> Callable[[str], tuple[str, str]]:
    """Return what finds user and password in the environment or asks for them once; they are kept in memory only."""
    from wpcal.robot.links.reading import LinkError, credentials_of_environment

    known: dict[str, tuple[str, str]] = {}

    def found(host: str) -> tuple[str, str]:
        try:
            return credentials_of_environment(host)
        except LinkError:
            if host not in known and not sys.stdin.isatty():
                raise
        if host not in known:
            user = click.prompt(f"user of {host}", err=True)
            known[host] = user, click.prompt("password", hide_input=True, err=True)
        return known[host]

    return found


def _read_part(part_step: Path, options: CalibrateOptions, judging: Judging, *, use_cache: bool) -> PickPart:
    """Read the part and find its seams, with what a person says about its solids."""
    from cad.cli.kernel_work import run_on_part
    from wpcal.seam.options import Judging

    choice = replace(options.choice, edits=(), judging=Judging())
    asked = {"options": replace(options.seams, judging=judging), "choice": choice}
    what, needs = f"reading {part_step}", (PART, MESH)
    part: PickPart = run_on_part(
        "cad.session.part:read_pick_part", part_step, asked, what=what, use_cache=use_cache, needs=needs
    )
    return part


def _first_part(
    search: Callable[[Judging], PickPart], judging: Judging, path: Path
) -> tuple[PickPart, tuple[str, ...]]:
    """Read the part with what is said about solids, also in a file of an earlier session, if it still has them."""
    from wpcal.core.errors import ErrorCode, InputError
    from wpcal.seam.edit import read_judging

    try:
        return search(judging.after(read_judging(path))), ()
    except InputError as error:  # if that is not about the file, the search tells it again
        note = f"{error}; what was said about solids in an earlier session is not used"
        return search(judging), (note,) if error.code is ErrorCode.SOLID_UNKNOWN else ()


def table_of(taught: Path | None) -> Path:
    """Return the table to save to when no name is given: TAUGHT itself, unless it is a robot program.

    Of a draft or a backup it is the table to which it belongs.
    """
    from cad.pick.draft import KEPT_ENDINGS
    from wpcal.controllers.taught_program import is_program

    if taught is None:
        return DEFAULT_TABLE
    while taught.suffix in KEPT_ENDINGS:
        taught = taught.with_suffix("")
    return DEFAULT_TABLE if is_program(taught) else taught


def _is_same(one: Path, other: Path) -> bool:
    from wpcal.core.input_file import is_same_file

    return one == other or is_same_file(one, other)


def require_table(out: Path, part_step: Path, *, is_asked: bool) -> None:
    """Refuse a name under which the page could not save its table, before the part is read.

    `is_asked`: Whether a person gave the name for saving. A table that was only opened may be read-only: the page saves
    it under another name.

    Raises `InputError` if the table, its draft or its last version would be a folder or the part itself, it is named
    like a draft, or it cannot be written.
    """
    from cad.pick.draft import KEPT_ENDINGS, backup_of, draft_of, is_read_only, require_table_name, require_table_room
    from wpcal.core.errors import InputError
    from wpcal.core.input_file import is_same_file

    require_table_name(out)
    if out.is_dir():
        raise InputError(f"{out}: is a directory; expected the name of a table to save")
    for path in (out, draft_of(out), backup_of(out)):
        if path.is_dir():
            raise InputError(f"{path}: is a directory; remove it, or give -o and another name")
        if is_same_file(path, part_step):
            raise InputError(f"{path}: is the part itself; give -o and another name")
    if out.suffix in KEPT_ENDINGS:
        raise InputError(f"{out}: is the name of a draft or a backup; give -o and another name")
    if not out.parent.is_dir():
        raise InputError(f"{out.parent}: no such folder to save into")
    if is_asked and is_read_only(out):
        raise InputError(f"{out}: is read-only; give -o and another name")
    require_table_room(out)


def calibrate_command(
    ctx: click.Context,
    part_step: Path,
    taught: Path,
    *,
    seams: SharedSeams,
    session: PickSession,
    bodies: Path | None = None,
) -> str:
    """Return the line that calibrates from the saved table with the options and the decisions that were given here."""
    given = [] if seams.used_file is None else ["--seams", str(seams.used_file)]
    given += session.moving.words(bodies)
    typed = session.options.seams.judging
    is_withdrawn = typed.after(seams.judging) != seams.judging
    left_out = {*NOT_CALIBRATE, *(OF_SOLIDS if is_withdrawn else ()), *option_names(POINTS), *option_names(BODIES)}
    left_out |= set(OF_RIGID_PARTS if session.moving.is_on else ())
    given += typed_options(ctx, without=left_out)
    return shlex.join(["wpcal", "calibrate", str(part_step), str(taught), *given, "-o", "RESULT"])
