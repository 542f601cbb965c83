"""`wpcal torches`: the torches that come with wpcal, as a table and as a picture."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, path_option

if TYPE_CHECKING:
    from wpcal.robot.torch.shape import TorchShape


@click.command()
@click.argument("torches", metavar="[TORCH]...", nargs=-1)
@path_option("-o", "--out", metavar="FILE.svg", help="Output: a picture of the torches.")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the picture.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the torches.")
def torches(*, torches: tuple[str, ...], out: Path | None, force: bool, as_json: bool) -> int:
    """List the torches that --torch takes, with their sizes, or those named: shipped ones and torch files.

    The first one is assumed unless another one is stated. -o draws them to one scale.
    """
    from wpcal.core.records import write_file
    from wpcal.pages.draw.torches import torches_svg
    from wpcal.robot.torch.file import find_torch, shipped_torches, torches_record

    shapes = [find_torch(name) for name in torches] or [torch.shape for torch in shipped_torches()]
    if out is not None:
        write_file(out, torches_svg(shapes).encode("utf-8"), overwrite=force)
    if as_json:
        print_json(torches_record(shapes))
    else:
        _show(shapes, out)
    return 0


def _row(shape: TorchShape) -> tuple[str, ...]:
    nozzle = f"{2 * shape.nozzle_radius_mm:g}"
    if shape.mouth_radius_mm is not None:
        nozzle = f"{2 * shape.mouth_radius_mm:g} to {nozzle} in {shape.taper_mm:g}"
    neck, body = "straight", "-"
    if shape.neck is not None:
        own = shape.neck
        bend = f", {own.angle_deg:g} deg on radius {own.bend_mm:g}" if own.angle_deg else ", straight"
        neck = f"{2 * own.radius_mm:g}{bend}, {own.from_mm:g} behind the mouth"
        body = f"{2 * own.body_radius_mm:g} from {own.body_from_mm:g} on"
    wire = f"{shape.wire_mm:g}, at most {shape.wires_mm[-1]:g}"
    return shape.name, wire, nozzle, neck, body, f"{shape.length_mm:g}"


def _show(shapes: list[TorchShape], out: Path | None) -> None:
    from wpcal.cli.console import new_table, plain_console
    from wpcal.robot.torch.file import shipped_torches

    table = new_table("Torches: outer diameters and lengths in mm", "<=torch|<wire|<nozzle|<neck|<body|length")
    for shape in shapes:
        table.add_row(*_row(shape))
    console = plain_console()
    console.print(table)
    shown = [torch for torch in shipped_torches() if torch.shape in shapes]
    for torch in shown:
        console.print(f"{torch.shape.name}: {torch.title}")
    for source in dict.fromkeys(torch.source for torch in shown):
        names = ", ".join(torch.shape.name for torch in shown if torch.source == source)
        console.print(f"sizes of {names}: {source}")
    if out is not None:
        console.print(f"wrote {out}")
