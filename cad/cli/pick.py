"""`wpcal pick`: choose features in a browser and type what the robot shows."""

from __future__ import annotations

import os
import shlex
import sys
from pathlib import Path
from typing import Any

import click

from cad.cli.options import CalibrateFlags, SeamChoiceFlags
from wpcal.cli.option_groups import option_names, takes
from wpcal.cli.program_options import ProgramFlags

NOT_CALIBRATE = ("part_step", "taught", "out", "port", "browser", "force", *option_names(ProgramFlags))
"""Arguments that are not copied to `wpcal calibrate`: it has others, or the saved table no longer needs them."""


@click.command()
@click.argument("part_step", metavar="PART.step", type=click.Path(path_type=Path))
@click.argument("taught", metavar="[TAUGHT]", required=False, type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--out",
    metavar="FILE",
    type=click.Path(path_type=Path),
    default=Path("taught.csv"),
    show_default=True,
    help="Table that the page saves.",
)
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port of the page.  [default: a free one]")
@click.option("--browser/--no-browser", default=True, help="Open the page, or only print its address.")
@click.option("--force", is_flag=True, help="Overwrite FILE.")
@takes("calibration", CalibrateFlags)
@takes("choice", SeamChoiceFlags)
@takes("reading", ProgramFlags)
@click.pass_context
def pick(
    ctx: click.Context,
    /,
    *,
    part_step: Path,
    taught: Path | None,
    out: Path,
    port: int,
    browser: bool,
    force: bool,
    calibration: CalibrateFlags,
    choice: SeamChoiceFlags,
    reading: ProgramFlags,
) -> int:
    """Click features of PART.step in the browser and type what the robot shows.

    Residuals and the predicted error of every seam follow as you type. They are those of `wpcal calibrate` with the
    same options. A table or a controller's program can also be dropped on the page; the points of TAUGHT are there from
    the start. The page saves the table that `wpcal calibrate` reads. It is served to this machine only, until Ctrl-C.
    """
    from cad.cli.kernel_work import run_on_part
    from cad.pick.page import build_pick_page
    from cad.pick.rows import Rows
    from cad.pick.server import PickServer
    from cad.pick.session import PickSession
    from wpcal.core.records import read_bytes

    command = calibrate_command(ctx, part_step, out)
    options, nominal = calibration.to_options(choice.to_choice()), calibration.fit.to_nominal()
    program = reading.to_reading()
    require_table(out, part_step, overwrite=force)
    initial = None if taught is None else read_bytes(taught)
    arguments = {"options": options.seams, "choice": options.choice}
    part = run_on_part("cad.pick.part:read_pick_part", part_step, arguments, what=f"reading {part_step}")
    session = PickSession(part, out, options, nominal, program, overwrite=force)
    rows, left_out = (Rows(), ()) if initial is None else session.read(initial, name=str(taught))
    for point in left_out:
        click.echo(f"note: left out {point}", err=True)
    page = build_pick_page(session.part, rows, session.options, saves_to=str(out), command=command)
    server = PickServer(session, page, port=port)
    click.echo(f"The picker of {part_step.name} is at {server.url} until Ctrl-C")
    if browser and _has_screen():
        click.launch(server.url)
    server.run()
    click.echo("nothing was saved" if session.saved is None else f"saved {out}; now: {command}")
    return 0


def require_table(out: Path, part_step: Path, *, overwrite: bool) -> None:
    """Refuse a name under which the page could not save its table, before the part is read.

    Raises
    ------
    InputError
        If it is a folder, the part itself, in a folder that does not exist, or a file that must not be overwritten.
    """
    from wpcal.core.errors import InputError

    if out.is_dir():
        raise InputError(f"{out}: is a directory; expected the name of a table to save")
    if out.exists() and part_step.exists() and out.samefile(part_step):
        raise InputError(f"{out}: is the part itself; give -o and another name")
    if out.exists() and not overwrite:
        raise InputError(f"{out}: exists; give --force to overwrite it, or -o and another name")
    if not out.parent.is_dir():
        raise InputError(f"{out.parent}: no such folder to save into")


def calibrate_command(ctx: click.Context, part_step: Path, taught: Path) -> str:
    """Return the line that calibrates from the saved table with the options that were given here."""
    given: list[str] = []
    for parameter in ctx.command.params:
        name = parameter.name or ""
        is_given = ctx.get_parameter_source(name) is click.core.ParameterSource.COMMANDLINE
        if isinstance(parameter, click.Option) and is_given and name not in NOT_CALIBRATE:
            given += _as_typed(parameter, ctx.params[name])
    return shlex.join(["wpcal", "calibrate", str(part_step), str(taught), *given, "-o", "RESULT"])


def _as_typed(option: click.Option, value: Any) -> list[str]:
    if option.is_flag:
        return [option.opts[0]]
    values = value if option.multiple else (value,)
    return [word for one in values for word in (option.opts[0], str(one))]


def _has_screen() -> bool:
    """Whether this machine has a screen: without one a browser would start in the terminal."""
    if not sys.stdout.isatty():
        return False
    return not sys.platform.startswith("linux") or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
