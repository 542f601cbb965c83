"""`wpcal seams`: what can be welded on a part."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from cad.cli.options import CHOICE, FINDING, MESH, PART, no_cache_option
from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, path_argument, path_option

if TYPE_CHECKING:
    from collections.abc import Sequence

    from cad.batch.seams_asked import SeamsAsked
    from wpcal.core.issue import Issue
    from wpcal.seam import Seam, SeamOptions
    from wpcal.seam.member.note import MemberNotes


@command()
@path_argument("part_step", metavar="PART.step")
@takes("options", FINDING)
@takes("choice", CHOICE)
@path_option("--png", metavar="FILE", help="Write a picture of the part and its seams.")
@path_option("--html", metavar="FILE", help="Write a page: the part with its seams in 3-D.")
@click.option(
    "--explain",
    metavar="SEAM",
    help="Say everything that decided about this seam, and draw it into PART.SEAM.svg in the current folder.",
)
@click.option(
    "--all",
    "show_all",
    is_flag=True,
    help="Leave nothing out: also candidates that are not taken, the members, and what the solids are taken for.",
)
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the pictures and the page.")
@no_cache_option
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: in the form of seams.json, frame part.")
def seams(
    *,
    part_step: Path,
    options: SeamOptions,
    choice: SeamsAsked,
    png: Path | None,
    html: Path | None,
    explain: str | None,
    force: bool,
    show_all: bool,
    as_json: bool,
    no_cache: bool,
) -> int:
    """List the weld seams of PART.step: contacts between solids, and concave edges inside one.

    Every candidate has a confidence; those of 80 % and more (--strict: 90 %, --generous: 5 %) are accepted. --all also
    lists the others with the reasons, and the members; --member, --weld and --not set these right.
    """
    from cad.cli.kernel_work import run_on_part
    from wpcal.core.records import write_file
    from wpcal.seam.record import seams_record

    arguments = {
        "options": options,
        "choice": choice.to_choice(),
        "picture": png is not None,
        "mesh": html is not None,
        "members": any((as_json, show_all, html)),
        "explain": explain,
    }
    _check_drawings(png, html, overwrite=force)
    found, notes, issues, picture, part_glb, told = run_on_part(
        "cad.workpiece.seams:list_seams",
        part_step,
        arguments,
        what=f"finding the seams of {part_step}",
        use_cache=not no_cache,
        needs=(PART, MESH) if html is not None else (PART,),
    )
    if told is not None:
        drawn = Path(f"{part_step.stem}.{told.record['seam']}.svg".replace("/", "_").replace(chr(92), "_"))
        write_file(drawn, told.svg.encode("utf-8"), overwrite=force)
    if png is not None:
        write_file(png, picture, overwrite=force)
    record = seams_record(found, notes=notes, join_mm=options.most_join_mm, torch=options.reach.torch)
    if html is not None:
        from wpcal.pages.seams import build_seams_page

        page = build_seams_page(record, part_glb, file_name=part_step.name)
        write_file(html, page.encode("utf-8"), overwrite=force)
    if as_json:
        explained = {} if told is None else {"explained": {**told.record, "picture": drawn.name}}
        odd = {"issues": [issue.to_record() for issue in issues]}
        print_json({**record, **odd, **explained})
    elif told is not None:
        from cad.cli.tables import explained_table
        from wpcal.cli.console import plain_console

        console = plain_console()
        console.print(explained_table(told.record))
        console.print(f"{drawn}: picture of the seam, written")
    else:
        _show(found, notes, issues, f"Seams of {part_step.name} (part frame)", show_all=show_all)
    return 0


def _show(found: Sequence[Seam], notes: MemberNotes, issues: Sequence[Issue], title: str, *, show_all: bool) -> None:
    """Print the accepted seams, and the others or how many they are."""
    from cad.cli.tables import members_table, refused_table, rest_words, seams_table
    from wpcal.cli.console import plain_console, show_notes

    console = plain_console()
    console.print(seams_table(found, title))
    if show_all:
        console.print(refused_table(found))
        console.print(members_table(notes, found))
    else:
        console.print(rest_words(found))
    for one in notes.play:
        console.print(f"play {one.gap_mm:.2g} mm in {one.joints} joints")
    show_notes(issues, console)


def _check_drawings(png: Path | None, html: Path | None, *, overwrite: bool) -> None:
    """Refuse what cannot be drawn or written, before any work is done."""
    from importlib.util import find_spec

    from wpcal.cli.outputs import require_new
    from wpcal.core.errors import InputError

    if png is not None and find_spec("matplotlib") is None:
        raise InputError("--png needs matplotlib: install wpcal[plots]")
    for file in (png, html):
        if file is not None:
            require_new(file, overwrite=overwrite)
