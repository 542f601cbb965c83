"""`wpcal bases`: the place of robot 2 relative to robot 1, from points that both touched."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import command, takes
from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, path_argument, path_option

if TYPE_CHECKING:
    from wpcal.calibrate.options import FitOptions


@command()
@path_argument("cell_json", metavar="CELL.json")
@path_argument("touched_csv", metavar="TOUCHED.csv")
@path_option("-o", "--out", "output", metavar="DIR", required=True, help="Output: a folder.")
@takes("fitting", "wpcal.calibrate.options:FitOptions", only=["tolerance_mm"])
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the files of this command in the folder.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: the record of the fit.")
def bases(*, cell_json: Path, touched_csv: Path, output: Path, fitting: FitOptions, force: bool, as_json: bool) -> int:
    """Put the place of robot 2 into a cell, from points that both robots touched with known tools.

    TOUCHED.csv has the columns name, base1_x_mm, base1_y_mm, base1_z_mm, base2_x_mm, base2_y_mm, base2_z_mm. Writes
    cell.json and copies of the arm files beside CELL.json. Ends with code 1 if a residual is larger than the tolerance.
    """
    from wpcal.core.errors import blamed_on
    from wpcal.core.records import check_writable, new_directory, to_json, write_file
    from wpcal.touch.grasp import measure_bases, read_base_points

    check_writable(output, overwrite=force)
    touched = read_base_points(touched_csv)
    with blamed_on(str(touched_csv)):
        found = measure_bases(cell_json, touched, tolerance_mm=fitting.tolerance_mm)
    with new_directory(output, overwrite=force) as folder:
        for name, record in found.files.items():
            write_file(folder / name, to_json(record), overwrite=True)
    if as_json:
        print_json({**found.result.to_record(), "robot2_moved_mm": found.moved_mm})
    else:
        from wpcal.cli.calibration_tables import show_calibration
        from wpcal.cli.console import plain_console

        console = plain_console()
        show_calibration(found.result, console)
        console.print(f"robot 2 is {found.moved_mm:.3f} mm from its place in the old cell")
        console.print(f"wrote {', '.join(found.files)} to {output}")
    return 0 if found.result.verdict == "PASS" else 1
