"""The fit of touches on faces and edges, relative to what a picker can wait for, and to one evaluation of the rows."""

from __future__ import annotations

from pathlib import Path

from rich.table import Table

from cad.workpiece.fit_taught import prepare_fit
from cad.workpiece.workpiece import open_workpiece
from tests.benchmarks.timing import least_seconds
from wpcal.calibrate import TeachingError, Touches, calibrate
from wpcal.taught.table import read_taught

TEE = Path(__file__).parents[2] / "fixtures" / "tee"


def main() -> Table:
    table = Table(title="Fit of touches")
    for heading in ("what", "asked", "measured"):
        table.add_column(heading)
    touches = prepare_fit(read_taught(TEE / "touches_321.csv"), open_workpiece(TEE / "tee.step")).fitted
    assert isinstance(touches, Touches)
    pose = calibrate(touches, teaching=TeachingError(sigma_mm=0.1)).T_base_part
    seconds = least_seconds(lambda: calibrate(touches, teaching=TeachingError(sigma_mm=0.1)), 5)
    once = least_seconds(lambda: touches.linearised(pose.R, pose.t_mm), 200)
    table.add_row(f"{len(touches)} touches on planes: warm time", "≤ 300 ms", f"{1e3 * seconds:.0f} ms")
    table.add_row("… relative to one evaluation of the rows", "-", f"{seconds / once:.0f}")
    return table
