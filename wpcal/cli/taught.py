"""`wpcal taught`: the taught points of a controller's program as the table that `wpcal calibrate` reads."""

from __future__ import annotations

from pathlib import Path

import click


@click.command()
@click.argument("program", metavar="PROGRAM", type=click.Path(path_type=Path))
@click.option("-o", "--out", metavar="TAUGHT.csv", type=click.Path(path_type=Path), help="[default: stdout]")
@click.option(
    "--uframe",
    "uframes",
    multiple=True,
    metavar="[NAME=]VALUES",
    help="User frame in the base, as on the pendant: X,Y,Z,A,B,C (KUKA), X,Y,Z,W,P,R (FANUC), X,Y,Z,Rx,Ry,Rz "
    "(Yaskawa), X,Y,Z,Q1,Q2,Q3,Q4 (ABB); or `base`, or a frame that the file carries. NAME is the program's name or "
    "number of it; without, it holds for every point whose frame is not known. Repeatable.",
)
@click.option("--tool", metavar="X,Y,Z", help="Tool centre point in the flange, mm, for points taught without a tool.")
@click.option("--points", metavar="P1,P2", help="Only these.")
@click.option("--force", is_flag=True, help="Overwrite TAUGHT.csv.")
@click.option("--json", "as_json", is_flag=True, help="Print JSON on stdout.")
def taught(
    *,
    program: Path,
    out: Path | None,
    uframes: tuple[str, ...],
    tool: str | None,
    points: str | None,
    force: bool,
    as_json: bool,
) -> int:
    """Read taught points from PROGRAM (RAPID .mod, KRL .dat, FANUC .ls, INFORM .jbi) in base coordinates.

    The column feature repeats the point's name: put the name of the feature there that was touched.
    """
    from wpcal.core.records import to_json, write_file
    from wpcal.export.taught_program import parse_uframes, read_taught_program, taught_csv

    read = read_taught_program(
        program,
        uframes=parse_uframes(uframes),
        tool=_numbers(tool) if tool is not None else None,
        points=None if points is None else [name.strip() for name in points.split(",")],
    )
    if out is not None:
        write_file(out, taught_csv(read), overwrite=force)
    if as_json:
        rows = zip(read.names, read.p_base.tolist(), strict=True)
        record = {"schema": "wpcal/taught/1", "points": [{"name": name, "p_base_mm": p} for name, p in rows]}
        click.echo(to_json(record), nl=False)
    elif out is None:
        click.echo(taught_csv(read), nl=False)
    else:
        click.echo(f"wrote {len(read.names)} points to {out}")
    return 0


def _numbers(text: str) -> list[float]:
    from wpcal.core.errors import InputError

    try:
        return [float(value) for value in text.split(",")]
    except ValueError:
        raise InputError(f"--tool: expected X,Y,Z in mm, got {text!r}") from None
