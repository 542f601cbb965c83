"""`wpcal demo`: the main job on a sample part; needs only the installed package."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.outputs import print_json
from wpcal.cli.shared_help import FORCE_HELP, JSON_HELP, path_option

if TYPE_CHECKING:
    from cad.workpiece.calibrate import WrittenCalibration
    from wpcal.core.progress import Progress


@click.command()
@path_option("-o", "--out", default="wpcal-demo", show_default=True, help="Output: a folder.")
@click.option("--force", is_flag=True, help=f"{FORCE_HELP}: the files of this command in the folder.")
@click.option("--json", "as_json", is_flag=True, help=f"{JSON_HELP}: calibration.json.")
def demo(*, out: Path, force: bool, as_json: bool) -> int:
    """Make a sample part with taught points and calibrate it; writes both and the results into one folder."""
    from cad.cli.calibrate import show_written
    from cad.cli.kernel_work import STARTING
    from cad.work.child import run_in_child
    from wpcal.cli.progress import shown_progress
    from wpcal.core.records import check_writable

    check_writable(out, overwrite=force)
    with shown_progress(STARTING) as progress:
        written = run_in_child(
            "cad.cli.demo:calibrate_demo",
            {"out": out, "overwrite": force},
            what="calibrating the sample",
            progress=progress,
        )
    if as_json:
        print_json(written.record)
    else:
        show_written(written, out)
        part, taught = out / "tee.step", out / "taught.csv"
        click.echo(f"The same by hand:  wpcal calibrate {part} {taught} -o RESULT")
    return 0 if written.result.verdict == "PASS" else 1


def calibrate_demo(*, out: Path, overwrite: bool, progress: Progress) -> WrittenCalibration:
    """Do the work in the kernel's process; the inputs are in the folder of the results."""
    from cad.batch.recorded import recording
    from cad.samples.parts import SAMPLE_INPUTS, calibrate_sample

    part, taught = map(Path, SAMPLE_INPUTS)
    means = recording((), part, taught, "", {})
    return calibrate_sample(out=out, overwrite=overwrite, means=means, progress=progress)
