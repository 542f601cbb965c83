"""`wpcal sheet`: a page for the person at the robot."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cad.cli.options import LINES, PART, no_cache_option
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, path_argument, path_option

if TYPE_CHECKING:
    from cad.sheet import Sheet, SheetOptions


@click.command()
@path_argument("part_step", metavar="PART.step")
@path_argument("taught", required=False, metavar="[TAUGHT.csv|TOUCHES]")
@path_option("-o", "--out", required=True, metavar="SHEET", help="Output: .pdf, .svg, .dxf or .png.")
@click.option(
    "--touch",
    "points",
    metavar="N|V1,H3",
    help="Number of points that `wpcal advise` picks, or the features to touch, in this order.  [default: 4]",
)
@path_option(
    "--welds",
    metavar="WELDS.json",
    help="Weld data of `wpcal welds`: the sheet is the list of these welds, to be signed.",
)
@click.option("--paper", type=click.Choice(["A3", "A4"]), default="A3", show_default=True, help="Size of the drawing.")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: SHEET.")
@no_cache_option
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: what is on the sheet.")
def sheet(
    *,
    part_step: Path,
    taught: Path | None,
    out: Path,
    points: str | None,
    welds: Path | None,
    paper: str,
    force: bool,
    as_json: bool,
    no_cache: bool,
) -> int:
    """Draw PART.step with the points to touch, or its welds, numbered, and a table to fill in by hand.

    Front, left side, top and a view from above, without hidden lines. The points have the names that `wpcal features`,
    `advise` and `calibrate` use. The points are those of TAUGHT.csv, for example a table that `wpcal advise -o` wrote;
    without it they are chosen anew. Touches on faces and edges are drawn with arrows: those of a table with the column
    `kind`, or those of a plan (TOUCHES: the folder of `wpcal touches`, or its touches.json).

    With --welds it is the weld list for the shop floor: symbols (ISO 2553), sizes, lengths, positions and passes. An
    arrow runs from the start of a straight weld to its middle. A .pdf has as many pages as the welds need.
    """
    from cad.cli.kernel_work import run_on_part
    from wpcal.cli.outputs import require_new
    from wpcal.core.records import write_file

    options = _options(out, points, taught, welds, paper)
    require_new(out, overwrite=force)
    made: Sheet = run_on_part(
        "cad.sheet:make_sheet",
        part_step,
        {"options": options},
        what=f"drawing {part_step}",
        use_cache=not no_cache,
        needs=(PART, LINES),
    )
    write_file(out, made.data, overwrite=force)
    if as_json:
        print_json(made.record)
    else:
        names = " ".join(one["name"] for one in made.record["welds" if welds else "points"])
        what = "welds" if welds else "touch"
        click.echo(f"wrote {out}: {made.record['paper']}, scale {made.record['scale']}, {what} {names}")
        for issue in made.record["issues"]:
            click.echo(f"note: {issue['message']}")
    return 0


def _options(out: Path, points: str | None, taught: Path | None, welds: Path | None, paper: str) -> SheetOptions:
    from importlib.util import find_spec

    from cad.sheet import SHEET_SUFFIXES, SheetOptions
    from cad.sheet.paper import PAPERS
    from wpcal.core.errors import InputError

    suffix = out.suffix.lower()
    if suffix not in SHEET_SUFFIXES:
        raise InputError(
            f"{out}: unknown kind of sheet {suffix or '(no suffix)'!r}; known: {', '.join(SHEET_SUFFIXES)}"
        )
    needed = {".dxf": "ezdxf", ".svg": "PIL"}.get(suffix, "matplotlib")
    if find_spec(needed) is None:
        raise InputError(f"a {suffix} sheet needs {needed}: install wpcal[plots], or write .dxf")
    if welds is not None:
        from cad.sheet.welds import read_listed_welds

        if points is not None or taught is not None:
            raise InputError("give either --welds, or the points to touch")
        return SheetOptions(suffix, PAPERS[paper], welds=read_listed_welds(welds))
    if taught is not None and points is not None:
        raise InputError("give either TAUGHT.csv or --touch")
    asked = _taught(taught) if taught is not None else _named(points) if points is not None else {}
    return SheetOptions(suffix, PAPERS[paper], **asked)


def _named(points: str) -> dict[str, Any]:
    """Return what --touch says: how many features, or which."""
    from wpcal.core.errors import InputError

    names = tuple(name.strip() for name in points.split(",") if name.strip())
    if not names:
        raise InputError("--touch: expected a number or names of features, got nothing")
    if len(names) == 1 and names[0].isdecimal():
        return {"count": int(names[0])}
    if len({name.lower() for name in names}) < len(names):
        raise InputError(f"--touch: a feature is named twice in {points}")
    return {"names": names}


def _taught(taught: Path) -> dict[str, Any]:
    """Return the touches of a plan or a table, or the features that a table names."""
    from cad.sheet.touches import read_touches_to_make, touches_of_plan
    from wpcal.taught.table import read_features_to_touch
    from wpcal.touch.searches.record import read_touch_plan

    if taught.is_dir() or taught.suffix.lower() == ".json":
        return {"touches": touches_of_plan(read_touch_plan(taught))}
    touches = read_touches_to_make(taught)
    return {"names": read_features_to_touch(taught)} if touches is None else {"touches": touches}
