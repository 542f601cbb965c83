"""`wpcal fit`: the rigid transform of point pairs in a file, without any CAD."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import DETAILS_HELP, JSON_HELP, path_argument

if TYPE_CHECKING:
    from wpcal.calibrate.options import FitOptions


@command()
@path_argument("pairs_csv", metavar="PAIRS.csv")
@click.option(
    "--schedule",
    type=click.Choice(["default", "yin2003"]),
    default="default",
    show_default=True,
    help="Cooling of the annealing: ours, or that of the paper.",
)
@takes("options", "wpcal.calibrate.options:FitOptions")
@click.option("--accept-unsure", is_flag=True, help="End with code 0 if the verdict is UNSURE.")
@click.option("--details", is_flag=True, help=DETAILS_HELP)
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the record of calibration.json.")
def fit(
    *, pairs_csv: Path, schedule: str, options: FitOptions, accept_unsure: bool, details: bool, as_json: bool
) -> int:
    """Fit the rigid transform of the point pairs in PAIRS.csv.

    The criterion is minimax, the published one, if none is given.

    Columns: name, model_x_mm, model_y_mm, model_z_mm, real_x_mm, real_y_mm, real_z_mm. Optional columns: use (yes,
    check, no), and sigma_mm or instead cov_xx_mm2, cov_xy_mm2, cov_xz_mm2, cov_yy_mm2, cov_yz_mm2, cov_zz_mm2.

    The verdict is PASS if the fitted points of the model are shown to be within the tolerance with 95 % confidence,
    FAIL if the pairs contradict each other or their stated error or a point is shown to be outside, and UNSURE
    otherwise. Ends with code 1 unless the verdict is PASS.
    """
    from wpcal.calibrate import AnnealingSchedule, Criterion, Solver, calibrate
    from wpcal.cli.calibration_tables import exit_code, show_calibration
    from wpcal.cli.progress import shown_progress
    from wpcal.core.errors import blamed_on
    from wpcal.taught.pairs import read_pairs

    criterion = options.criterion or Criterion.MINIMAX
    if schedule != "default" and (options.solver, criterion) != (Solver.ANNEALING, Criterion.MINIMAX):
        raise click.UsageError(
            "--schedule belongs to the annealing: it needs --solver annealing and --criterion minimax"
        )
    pairs, check = read_pairs(pairs_csv)
    with blamed_on(str(pairs_csv)), shown_progress(f"fitting {len(pairs.names)} points"):
        result = calibrate(
            pairs,
            criterion=criterion,
            solver=options.solver,
            schedule=AnnealingSchedule.yin2003() if schedule == "yin2003" else None,
            seed=options.seed,
            tolerance_mm=options.tolerance_mm,
            teaching=options.teaching,
            check=check,
            certify=options.certify,
        )
    if as_json:
        print_json(result.to_record())
    else:
        from wpcal.cli.console import plain_console

        show_calibration(result, plain_console(), details=details)
    return exit_code(result, accept_unsure=accept_unsure)
