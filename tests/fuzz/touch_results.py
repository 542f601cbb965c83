"""Results of touch programs, and the plan of touches, as readers of bytes."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

from tests.fuzz.target import Target, of_path
from tests.touch_plans import TEE_PLAN, tee_plan
from tests.touch_results_files import WRITERS
from wpcal.controllers.touch_run import read_touch_results
from wpcal.touch.searches import Outcome, read_touch_plan
from wpcal.touch.touch_results import pair_results

PLAN = tee_plan()
STORED = {search.name: search.planned for search in PLAN.searches}
MISSED = {**STORED, "T2": Outcome.MISSED, "T5": Outcome.NOT_RUN}


def results_in(files: dict[str, str], name: str) -> Callable[[bytes, Path], object]:
    """Return a reader of results in which one file is the input."""

    def read(data: bytes, path: Path) -> object:
        folder = path.with_suffix(".results")
        folder.mkdir(exist_ok=True)
        for each, text in files.items():
            (folder / each).write_bytes(data if each == name else text.encode())
        paired = pair_results(PLAN, read_touch_results(folder / name, PLAN))
        assert np.isfinite(paired.taught.p_base).all()
        assert paired.taught.covariances is None or np.isfinite(paired.taught.covariances).all()
        return paired

    return read


def plan(path: Path) -> object:
    found = read_touch_plan(path)
    assert all(np.isfinite(search.planned).all() for search in found.searches)
    return found.fingerprint


def touch_results_targets() -> dict[str, Target]:
    """Return the readers by name."""
    found = {"touches-plan": Target(of_path(plan), ((TEE_PLAN / "touches.json").read_bytes(),))}
    for brand, write in WRITERS.items():
        files = write(PLAN, STORED)
        for name in files:
            seeds = [files[name].encode()]
            if len(files) == 1:  # files that belong together are of one run
                seeds.append(write(PLAN, MISSED)[name].encode())
            found[f"results-{name}"] = Target(results_in(files, name), tuple(seeds), f"{brand}.{name}")
    return found
