"""`wpcal fit`: the rigid transform of point pairs in a file, without any CAD."""

from __future__ import annotations

from pathlib import Path

import click

from wpcal.cli.option_groups import takes
from wpcal.cli.shared_help import CRITERION_HELP, DETAILS_HELP, JSON_HELP, SOLVER_HELP, TOLERANCE_HELP
from wpcal.cli.teaching_options import TeachingFlags


@click.command()
@click.argument("pairs_csv", metavar="PAIRS.csv", type=click.Path(path_type=Path))
@click.option(
    "--criterion",
    type=click.Choice(["minimax", "least_squares", "weighted", "robust"]),
    default="minimax",
    show_default=True,
    help=CRITERION_HELP,
)
@click.option(
    "--solver", type=click.Choice(["annealing", "exact"]), default="annealing", show_default=True, help=SOLVER_HELP
)
@click.option(
    "--schedule",
    type=click.Choice(["default", "yin2003"]),
    default="default",
    show_default=True,
    help="Cooling of the annealing: ours, or that of the paper.",
)
@click.option("--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of all random numbers.")
@click.option(
    "--tolerance-mm",
    type=float,
    default=0.5,
    show_default=True,
    help=TOLERANCE_HELP,
)
@takes("teaching", TeachingFlags)
@click.option("--certify", is_flag=True, help="Close the gap to the lower bound by branch and bound (slow).")
@click.option("--accept-unsure", is_flag=True, help="End with code 0 if the verdict is UNSURE.")
@click.option("--details", is_flag=True, help=DETAILS_HELP)
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the record of calibration.json.")
def fit(
    *,
    pairs_csv: Path,
    criterion: str,
    solver: str,
    schedule: str,
    seed: int,
    tolerance_mm: float,
    teaching: TeachingFlags,
    certify: bool,
    accept_unsure: bool,
    details: bool,
    as_json: bool,
) -> int:
    """Fit the rigid transform of the point pairs in PAIRS.csv.

    Columns: name, model_x_mm, model_y_mm, model_z_mm, real_x_mm, real_y_mm, real_z_mm. Optional columns: use (yes,
    check, no), and sigma_mm or instead cov_xx_mm2, cov_xy_mm2, cov_xz_mm2, cov_yy_mm2, cov_yz_mm2, cov_zz_mm2.

    The verdict is PASS if the fitted points of the model are shown to be within the tolerance with 95 % confidence,
    FAIL if the pairs contradict each other or their stated error or a point is shown to be outside, and UNSURE
    otherwise. Ends with code 1 unless the verdict is PASS.
    """
    from wpcal.calibrate import Criterion, Solver, calibrate
    from wpcal.cli.calibration_tables import exit_code, show_calibration
    from wpcal.cli.progress import shown_progress
    from wpcal.core.errors import blamed_on
    from wpcal.core.records import to_json
    from wpcal.optim import AnnealingSchedule
    from wpcal.taught.pairs import read_pairs

    if schedule != "default" and (solver, criterion) != ("annealing", "minimax"):
        raise click.UsageError(
            "--schedule belongs to the annealing: it needs --solver annealing and --criterion minimax"
        )
    error = teaching.to_error()
    pairs, check = read_pairs(pairs_csv)
    with blamed_on(str(pairs_csv)), shown_progress(f"fitting {len(pairs.names)} points"):
        result = calibrate(
            pairs,
            criterion=Criterion(criterion),
            solver=Solver(solver),
            schedule=AnnealingSchedule.yin2003() if schedule == "yin2003" else None,
            seed=seed,
            tolerance_mm=tolerance_mm,
            teaching=error,
            check=check,
            certify=certify,
        )
    if as_json:
        click.echo(to_json(result.to_record()), nl=False)
    else:
        from wpcal.cli.console import plain_console

        show_calibration(result, plain_console(), details=details)
    return exit_code(result, accept_unsure=accept_unsure)
