"""`wpcal welds`: what is laid into every seam, as a file that a person edits."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.export_options import SelectionFlags
from wpcal.cli.option_groups import takes
from wpcal.cli.shared_help import JSON_HELP, XMCF_HELP
from wpcal.cli.weld_options import WeldRuleFlags

if TYPE_CHECKING:
    from wpcal.weld.find import FoundWelds


@click.command()
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--out",
    "output",
    metavar="WELDS.json",
    type=click.Path(path_type=Path),
    help="Output: a file. If it exists, values that you changed in it are kept.",
)
@takes("selection", SelectionFlags)
@takes("rules", WeldRuleFlags)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="SEAMS:NAME=VALUE",
    help="State a value, for example W1-W4:leg_mm=5; an empty VALUE gives it back to the rules. Repeatable.",
)
@click.option(
    "--xmcf",
    metavar="WELDS.xml",
    type=click.Path(path_type=Path),
    help=f"{XMCF_HELP}: size, thickness, gap, angle and stitches are taken.",
)
@click.option(
    "--write-xmcf",
    metavar="WELDS.xml",
    type=click.Path(path_type=Path),
    help="Also write the seams with their welds as an xMCF file in coordinates of the part.",
)
@click.option(
    "--write-rules",
    metavar="RULES.toml",
    type=click.Path(path_type=Path),
    help="Also write the table of rules of wpcal, to be changed and used with --weld-rules.",
)
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the record.")
def welds(
    *,
    folder: Path,
    output: Path | None,
    selection: SelectionFlags,
    rules: WeldRuleFlags,
    settings: tuple[str, ...],
    xmcf: Path | None,
    write_xmcf: Path | None,
    write_rules: Path | None,
    as_json: bool,
) -> int:
    """Find the weld data of every seam in DIR (calibration.json, seams.json).

    Values come from rules by joint, thickness and position. Change them in WELDS.json and run the command again: what
    you changed is kept, and what follows from it (passes, speed) is computed anew. `wpcal export --welds` uses it.
    """
    from wpcal.cli.outputs import require_new
    from wpcal.core.records import to_json, write_file
    from wpcal.core.robot_space import RobotSpace
    from wpcal.results.folder import SEAMS_FILE, read_finished, read_record
    from wpcal.weld.find import find_welds
    from wpcal.weld.record import read_stated_welds, welds_record
    from wpcal.weld.rules import shipped_text
    from wpcal.weld.set_values import set_values
    from wpcal.weld.xmcf.match import match_xmcf, with_files
    from wpcal.weld.xmcf.read import read_xmcf
    from wpcal.weld.xmcf.write import xmcf_text

    for new in (write_rules, write_xmcf):
        if new is not None:
            require_new(new, overwrite=False)
    selection.require_one()
    table = rules.read()
    space = RobotSpace.parse(read_record(folder, SEAMS_FILE)["robot_space"])  # no pose is computed here
    finished = read_finished(folder, space=space)
    stated = read_stated_welds(output, table) if output is not None and output.exists() else ()
    names = [seam.name for seam in finished.seams]
    stated = set_values(stated, settings, names)
    T_part_base = finished.T_base_part.inverse()
    taken = None
    if xmcf is not None:
        taken = match_xmcf(finished.seams, read_xmcf(xmcf), T_part_base, file=xmcf.name)
        stated = with_files(stated, taken.stated)
    chosen = selection.select(finished)
    found = find_welds(
        finished.seams,
        finished.T_base_part,
        table,
        part_glb=finished.part_glb,
        stated=stated,
        names={seam.name for seam in chosen.seams},
        stated_in=str(output) if output is not None and output.exists() else "--set",
    )
    record = welds_record(found.welds, (*found.left, *found.not_chosen), table)
    if output is not None:
        write_file(output, to_json(record), overwrite=True)
    if write_rules is not None:
        write_file(write_rules, shipped_text(), overwrite=False)
    if write_xmcf is not None:
        write_file(write_xmcf, xmcf_text(chosen.seams, T_part_base, found.by_seam()), overwrite=False)
    notes = [*found.notes, *(() if taken is None else taken.notes)]
    what = "is not accepted or not chosen; its values are kept under without_seam"
    notes += [f"{one.name} {what}" for one in found.not_chosen]
    if as_json:
        click.echo(to_json({**record, "notes": notes}), nl=False)
    else:
        _show(found)
    for note in notes:
        click.echo(f"wpcal: {note}", err=True)
    return 0


def _show(found: FoundWelds) -> None:
    from rich.table import Table

    from wpcal.cli.console import plain_console
    from wpcal.weld.values import describe_weld

    table = Table(title="Welds")
    for title in ("seam", "weld"):
        table.add_column(title)
    for title in ("t mm", "A", "V", "wire m/min", "mm/s", "welded mm"):
        table.add_column(title, justify="right")
    table.add_column("by you")
    for weld in found.welds:
        values = weld.values
        numbers = (values.thickness_mm, values.current_a, values.voltage_v, values.wire_feed_m_min, values.speed_mm_s)
        welded = sum(end - start for start, end in weld.stretches_mm)
        cells = ["-" if number is None else f"{number:g}" for number in numbers]
        table.add_row(weld.name, describe_weld(values), *cells, f"{welded:.0f}", ", ".join(weld.by_user))
    plain_console().print(table)
