"""`wpcal pick`: choose features in a browser, and type what the robot shows or let it tell."""

from __future__ import annotations

import os
import sys
from contextlib import nullcontext
from typing import TYPE_CHECKING, Any

import click

from cad.cli.pick_start import PickAsked, pick_options, start
from cad.pick.address import LOCAL, NETWORK_WARNING, listen, opening_file, qr_code
from wpcal.cli.option_groups import command

if TYPE_CHECKING:
    from cad.pick.server import PickServer


@command()
@pick_options
@click.option(
    "--host",
    metavar="ADDRESS",
    default=LOCAL,
    show_default=True,
    help="Address of this machine at which a tablet in its network reaches the page.",
)
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port of the page.  [default: a free one]")
@click.option("--browser/--no-browser", default=True, help="Open the page, or only print its address.")
@click.pass_context
def pick(ctx: click.Context, /, *, host: str, port: int, browser: bool, **asked: Any) -> int:
    """Click features of PART.step in the browser and type what the robot shows.

    Residuals and the predicted error of every seam follow as you type. They are those of `wpcal calibrate` with the
    same options. A table or a controller's program can also be dropped on the page; the points of TAUGHT are there from
    the start. The page opens the table that it saves, and keeps what is not saved in a draft beside it, FILE.draft.
    Save keeps the version before as FILE.bak. The page is served until Ctrl-C (code 0), to this machine only unless
    --host gives another of its addresses.

    With --robot KIND:ADDRESS (ur:192.168.0.10, fanuc:…, kuka:…, abb:…) a button and the key F2 read the robot's
    position into the selected row. Nothing is ever written to the robot.
    """
    from cad.pick.page import build_pick_page
    from cad.pick.server import PickServer

    wanted = PickAsked(**asked)
    found = start(ctx, wanted)
    session = found.session
    page = build_pick_page(
        session.part, session.options, notes=found.notes, revision=session.seams_revision, robot=found.robot
    )
    server = PickServer(session, found.table, page, seams=found.seams, at=listen(host, port), watch=found.watch)
    try:
        serve(server, wanted.part_step.name, browser=browser and _has_screen())
    finally:
        if found.watch is not None:
            found.watch.close()
        found.say_end()
    return 0


def serve(server: PickServer, part_name: str, *, browser: bool) -> None:
    """Say where the page is, open it if there is a browser, and answer until Ctrl-C."""
    with server.ended_by_signals(), opening_file(server.url) if browser else nullcontext() as page:
        click.echo(f"The picker of {part_name} is at {server.url} until Ctrl-C")
        if not server.is_local:
            click.echo(qr_code(server.url), nl=False)
            click.echo(NETWORK_WARNING, err=True)
        if page is not None:
            click.launch(str(page))
        server.run()


def _has_screen() -> bool:
    """Whether this machine has a screen: without one a browser would start in the terminal."""
    if not sys.stdout.isatty():
        return False
    return not sys.platform.startswith("linux") or any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
