"""`wpcal study`: the paper's error study on the points of a file."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import command, takes
from wpcal.cli.shared_help import DASK_HELP, FORCE_HELP, JSON_HELP, path_argument, path_option

if TYPE_CHECKING:
    from rich.table import Table

    from wpcal.calibrate.errors.prediction import TeachingError
    from wpcal.core.arrays import FloatArray
    from wpcal.study import ErrorStudy, StudyOptions
    from wpcal.study.teaching_error import Chunk

BAR_WIDTH = 40


@command()
@path_argument("pairs_csv", metavar="PAIRS.csv")
@takes("options", "wpcal.study.teaching_error:StudyOptions")
@takes("teaching", "wpcal.calibrate.errors.prediction:TeachingError", without=["sigma_mm", "bound_mm"])
@click.option("--dask", metavar="tcp://HOST:PORT", help=f"{DASK_HELP}: they fit, and the numbers are the same.")
@path_option("-o", "--out", "output", help="Output: the distribution as a JSON file.")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the file.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the distribution.")
def study(
    *,
    pairs_csv: Path,
    options: StudyOptions,
    teaching: TeachingError,
    dask: str | None,
    output: Path | None,
    force: bool,
    as_json: bool,
) -> int:
    """Add errors to the taught points of PAIRS.csv, calibrate again, and show how far the reference points move.

    The true points are those of the least-squares fit. Every trial adds errors to them, up to the bound.
    """
    from wpcal.calibrate import fit_least_squares
    from wpcal.cli.outputs import require_new
    from wpcal.cli.progress import counted_progress
    from wpcal.core.records import to_json, write_file
    from wpcal.study import run_error_study
    from wpcal.taught.pairs import read_pairs

    pairs, _ = read_pairs(pairs_csv)
    if output is not None:
        require_new(output, overwrite=force)
    with counted_progress("trials") as progress, _fitted_on(dask) as fitted:
        result = run_error_study(
            pairs.p_source,
            fit_least_squares(pairs),
            options,
            teaching=teaching,
            progress=lambda done: progress("trials", done, options.trials),
            fitted=fitted,
        )
    record = to_json(result.to_record())
    if output is not None:
        write_file(output, record, overwrite=force)
    if as_json:
        click.echo(record, nl=False)
    else:
        _show(result)
    return 0


@contextmanager
def _fitted_on(address: str | None) -> Iterator[Callable[[Iterator[Chunk]], Iterator[tuple[int, FloatArray]]] | None]:
    """Yield what fits chunks of trials on the workers of a scheduler; None if there is no address."""
    if address is None:
        yield None
        return
    from wpcal.core.dask.cluster import Call, CallFailed, Cluster
    from wpcal.core.errors import InputError
    from wpcal.study.teaching_error import Chunk

    with Cluster(address) as cluster:

        def fitted(chunks: Iterator[Chunk]) -> Iterator[tuple[int, FloatArray]]:
            calls = (Call(chunk.start, Chunk.errors_mm, (chunk,)) for chunk in chunks)
            for start, value in cluster.results(lambda _: next(calls, None)):
                if isinstance(value, CallFailed):
                    raise InputError(value.message)
                yield start, value

        yield fitted


def _show(result: ErrorStudy) -> None:
    from rich.table import Table

    from wpcal.cli.console import plain_console

    console, asked = plain_console(), result.options
    console.print(_histogram(result))
    table = Table(title="Largest displacement of a reference point", show_header=False)
    table.add_row("trials", f"{len(result.errors_mm)} (seed {asked.seed}, {asked.criterion.value})")
    table.add_row("errors", f"at most {asked.bound_mm:g} mm per axis, at {asked.place.value}")
    table.add_row("mean", f"{result.errors_mm.mean():.6g} mm")
    for level, value in result.quantiles_mm.items():
        table.add_row(f"{100 * level:g} % of the trials below", f"{value:.6g} mm")
    table.add_row("below 0.5 mm", f"{100 * result.share_below_usual:.2f} % (the paper: usually)")
    table.add_row("95 % below, with robot, tool and part", f"{result.budget_95_mm:.3g} mm (error budget)")
    table.add_row("extreme", f"{result.errors_mm.max():.6g} mm (the paper: 0.9 mm)")
    console.print(table)


def _histogram(result: ErrorStudy) -> Table:
    from wpcal.cli.console import new_table

    counts, edges = result.histogram()
    table = new_table("Distribution of e", "e mm|trials|<")
    for count, low, high in zip(counts, edges[:-1], edges[1:], strict=True):
        table.add_row(f"{low:.3g} to {high:.3g}", f"{count:.0f}", "█" * round(BAR_WIDTH * count / counts.max()))
    return table
