"""What `wpcal rpc` costs: the first features of a part, with a cold and a warm process, and a refit after an edit.

The bare fit is `cad.workpiece.fit_taught.run_fit` on what is prepared; a refit is a whole request, from the line of the
client to its answer.
"""

import json
import os
import subprocess
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any

from rich.table import Table

from cad.session.part import read_pick_part
from cad.session.rows import Rows
from cad.step.new_file import new_step_text
from cad.workpiece.answer_cache import FOLDER_VARIABLE
from cad.workpiece.fit_taught import CalibrateOptions, name_taught, next_points, prepare_fit, run_fit
from cad.workpiece.seams import SeamChoice
from tests.benchmarks.bench_pick import touched
from tests.benchmarks.timing import least_seconds
from tests.samples.steel_structure import steel_structure
from wpcal.seam import SeamOptions

BAYS = (1, 10)
REPEATS = 8


class Client:
    """One process of `wpcal rpc`."""

    def __init__(self, environment: dict[str, str]) -> None:
        command = [sys.executable, "-m", "wpcal", "rpc"]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment)
        self._number = 0

    def ask(self, method: str, /, **params: Any) -> dict[str, Any]:
        """Return the result of a request."""
        self._number += 1
        line = json.dumps({"id": self._number, "method": method, "params": params})
        self._process.stdin.write(line.encode() + b"\n")
        self._process.stdin.flush()
        while "progress" in (answer := json.loads(self._process.stdout.readline())):
            pass
        found: dict[str, Any] = answer["result"]
        return found

    def close(self) -> None:
        """End the process."""
        self.ask("shutdown")
        self._process.communicate()


def bare_fit_s(step: Path, rows: Rows) -> float:
    """Return the time of the fit itself."""
    part = read_pick_part(step, options=SeamOptions(), choice=SeamChoice())
    options = CalibrateOptions()
    named = name_taught(rows.to_taught(), part.workpiece.features, options=options)
    observed = prepare_fit(named.taught, part.workpiece)
    suggest = partial(
        next_points, taught=named.taught, workpiece=part.workpiece, seams=part.seams, teaching=options.teaching
    )
    return least_seconds(lambda: run_fit(observed, part.seams, options=options, suggest=suggest), REPEATS)


def measure(bays: int, folder: Path, environment: dict[str, str]) -> tuple[str, ...]:
    """Return the row of one part."""
    step = folder / f"{bays}.step"
    step.write_bytes(new_step_text(steel_structure(bays), "structure", pcurves=False))
    start = time.perf_counter()
    client = Client(environment)
    opened = client.ask("open", path=str(step))
    cold_s = time.perf_counter() - start
    other = folder / f"{bays}-again.step"
    other.write_bytes(step.read_bytes())
    start = time.perf_counter()
    client.ask("open", path=str(other))
    warm_s = time.perf_counter() - start
    start = time.perf_counter()
    seams = client.ask("seams", handle=opened["handle"])["seams"]
    seams_s = time.perf_counter() - start
    _, rows = touched(read_pick_part(step, options=SeamOptions(), choice=SeamChoice()))
    bare_s = bare_fit_s(step, rows)
    refit_s = least_seconds(lambda: client.ask("calibrate", handle=opened["handle"], taught=rows.to_record()), REPEATS)
    client.close()
    frames = sum(len(seam["frames"]["s"]) for seam in seams)
    times = (cold_s, warm_s, seams_s, bare_s, refit_s, refit_s - bare_s)
    return opened["size"], str(frames), *(f"{value:.3f}" for value in times)


def main() -> Table:
    """Measure and return the table."""
    table = Table(title="wpcal rpc: open with a cold and a warm process, seams, and a refit beside the bare fit")
    for heading in ("part", "frames", "cold s", "warm s", "seams s", "bare fit s", "refit s", "above the fit s"):
        table.add_column(heading, justify="right")
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, FOLDER_VARIABLE: str(Path(folder) / "cache")}
        for bays in BAYS:
            table.add_row(*measure(bays, Path(folder), environment))
    return table
