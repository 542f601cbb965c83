"""`wpcal welds`: what is laid into every seam, as a file that a person edits."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.export_options import SelectionAsked
from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, XMCF_HELP, path_argument, path_option
from wpcal.cli.weld_options import WeldRulesAsked
from wpcal.core.options import opt

if TYPE_CHECKING:
    from wpcal.results.folder import FinishedCalibration
    from wpcal.weld.find import FoundWelds
    from wpcal.weld.place import StatedWeld
    from wpcal.weld.rules import RuleTable


@dataclass(frozen=True, slots=True, kw_only=True)
class StatingAsked:
    """What states values of welds, beside the rules."""

    values: Path | None = opt(
        None,
        "Take the values that FILE states: of the page (--html), or any WELDS.json. All others of -o stay.",
        metavar="FILE",
    )
    settings: tuple[str, ...] = opt(
        (),
        "State a value, for example W1-W4:leg_mm=5; an empty VALUE gives it back to the rules. Repeatable.",
        "--set",
        many=True,
        metavar="SEAMS:NAME=VALUE",
    )
    xmcf: Path | None = opt(
        None, f"{XMCF_HELP}: size, thickness, gap, angle and stitches are taken.", metavar="WELDS.xml"
    )

    def read(
        self, output: Path | None, table: RuleTable, finished: FinishedCalibration, chosen: FinishedCalibration
    ) -> Stated:
        """Return what is stated: by the file that is written again, by FILE, by options, by an xMCF file.

        `chosen`: The seams that are welded.
        Raises `InputError` when a file or an option cannot be used.
        """
        from wpcal.weld.find import seam_places
        from wpcal.weld.merge import merge_stated
        from wpcal.weld.record import read_stated_welds
        from wpcal.weld.set_values import set_values
        from wpcal.weld.xmcf.match import match_xmcf, with_files
        from wpcal.weld.xmcf.read import read_xmcf

        sources = [str(path) for path in (self.values, output) if path is not None and path.exists()]
        stated = read_stated_welds(output, table) if output is not None and output.exists() else ()
        notes: tuple[str, ...] = ()
        dropped: tuple[str, ...] = ()
        if self.values is not None:
            new = read_stated_welds(self.values, table)
            stated, notes = merge_stated(stated, new, seam_places(finished.seams, finished.T_base_part))
        stated = set_values(stated, self.settings, [seam.name for seam in finished.seams])
        if self.xmcf is not None:
            T_part_base = finished.T_base_part.inverse()
            taken = match_xmcf(chosen.seams, read_xmcf(self.xmcf), T_part_base, file=self.xmcf.name)
            stated = with_files(stated, taken.stated)
            notes, dropped = (*notes, *taken.notes), taken.dropped
        return Stated(tuple(stated), notes, sources[0] if sources else "--set", dropped)


@dataclass(frozen=True, slots=True)
class Stated:
    """What people and files state: the welds, what is worth telling, and the file that messages name."""

    welds: tuple[StatedWeld, ...]
    notes: tuple[str, ...]
    source: str
    dropped: tuple[str, ...]  #: Welds of a file at which nothing is welded.


@command()
@path_argument("folder", metavar="DIR")
@path_option(
    "-o",
    "--out",
    "output",
    metavar="WELDS.json",
    help="Output: a file. If it exists, values that you changed in it are kept.",
)
@takes("selection", SelectionAsked)
@takes("rules", WeldRulesAsked)
@takes("stating", StatingAsked)
@path_option("--html", metavar="FILE", help="Write a page: the part, its seams and all values, which you edit there.")
@path_option(
    "--write-xmcf",
    metavar="WELDS.xml",
    help="Also write the seams with their welds as an xMCF file in coordinates of the part.",
)
@path_option(
    "--write-rules",
    metavar="RULES.toml",
    help="Also write the table of rules of wpcal, to be changed and used with --weld-rules.",
)
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the page, and the files of --write-xmcf and --write-rules.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the record.")
def welds(
    *,
    folder: Path,
    output: Path | None,
    selection: SelectionAsked,
    rules: WeldRulesAsked,
    stating: StatingAsked,
    html: Path | None,
    write_xmcf: Path | None,
    write_rules: Path | None,
    force: bool,
    as_json: bool,
) -> int:
    """Find the weld data of every seam in DIR (calibration.json, seams.json).

    Values come from rules by joint, thickness and position. Change them in the page (--html) or in WELDS.json and run
    the command again: what you changed is kept, and what follows from it (passes, speed) is computed anew.
    `wpcal export --welds` uses it. Ends with code 1 if a weld of --xmcf is at no seam that is welded.
    """
    from wpcal.cli.outputs import require_new, say_note
    from wpcal.core.records import to_json, write_file
    from wpcal.core.result_files import SEAMS_FILE
    from wpcal.core.robot_space import RobotSpace
    from wpcal.core.wording import listed
    from wpcal.results.folder import read_finished, read_record
    from wpcal.weld.find import find_welds
    from wpcal.weld.record import OWN_FILES, welds_record
    from wpcal.weld.rules import shipped_text
    from wpcal.weld.xmcf.write import xmcf_text

    for new in (write_rules, write_xmcf, html):
        if new is not None:
            require_new(new, overwrite=force)
    selection.require_one()
    table = rules.read()
    space = RobotSpace.parse(read_record(folder, SEAMS_FILE)["robot_space"])  # no pose is computed here
    finished = read_finished(folder, space=space)
    say_note(finished.note)
    chosen = selection.select(finished)
    stated = stating.read(output, table, finished, chosen)
    names = {seam.name for seam in chosen.seams}
    of = (finished.seams, finished.T_base_part, table)
    find = partial(find_welds, *of, part_glb=finished.part_glb, names=names, stated_in=stated.source)
    found = find(stated=stated.welds)
    record = welds_record(found.welds, (*found.left, *found.not_chosen), table)
    written: list[tuple[Path, str]] = []
    if html is not None:
        from wpcal.pages.welds import build_welds_page

        command = ["wpcal", "welds", str(folder), "-o", str(output or "welds.json"), *rules.words(), *selection.words()]
        plain = find(stated=[replace(one, user={}) for one in stated.welds])
        ruled = welds_record(plain.welds, (), table)
        page = build_welds_page(
            record, ruled, chosen, folder=folder.name or str(folder), found_again=OWN_FILES, command=command
        )
        written.append((html, page))
    if write_rules is not None:
        written.append((write_rules, shipped_text()))
    if write_xmcf is not None:
        written.append((write_xmcf, xmcf_text(chosen.seams, finished.T_base_part.inverse(), found.by_seam())))
    if output is not None:
        write_file(output, to_json(record), overwrite=True)
    for path, text in written:
        write_file(path, text, overwrite=force)
    notes = [*found.notes, *stated.notes]
    if found.not_chosen:
        what = "not accepted or not chosen; values are kept under without_seam"
        notes.append(f"{listed(one.name for one in found.not_chosen)}: {what}")
    if as_json:
        print_json({**record, "notes": notes})
    else:
        _show(found)
    for note in notes:
        click.echo(f"wpcal: {note}", err=True)
    return int(bool(stated.dropped))


def _show(found: FoundWelds) -> None:

    from wpcal.cli.console import new_table, plain_console
    from wpcal.weld.values import describe_weld

    table = new_table("Welds", "<seam|<weld|t mm|A|V|wire m/min|mm/s|welded mm|<by you")
    for weld in found.welds:
        values = weld.values
        numbers = (values.thickness_mm, values.current_a, values.voltage_v, values.wire_feed_m_min, values.speed_mm_s)
        welded = sum(end - start for start, end in weld.stretches_mm)
        cells = ["-" if number is None else f"{number:g}" for number in numbers]
        table.add_row(weld.name, describe_weld(values), *cells, f"{welded:.0f}", ", ".join(weld.by_user))
    plain_console().print(table)
