"""A run of a touch program, read: its plan, its results, and the touches that are fitted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from wpcal.controllers.touch_results import read_touch_results
from wpcal.core.errors import InputError
from wpcal.core.input_file import read_bytes, sha256_of
from wpcal.core.issue import Issue
from wpcal.core.transform import RigidTransform
from wpcal.taught.table import TaughtPoints
from wpcal.touch.searches import TouchSetup, read_touch_plan, read_touch_setup
from wpcal.touch.touch_results import SilentRows, nominal_place, pair_results, require_enough

OTHER_PART = "other-part"  #: Code of the issue that the plan is for a part of another name.


@dataclass(frozen=True, slots=True, eq=False)
class TouchRun:
    """Touches of a run, and what the record of a calibration says about it."""

    taught: TaughtPoints
    T_nominal_part: RigidTransform  #: Where the plan has the part.
    record: dict[str, Any]  #: `searches` of ``calibration.json``.
    issues: tuple[Issue, ...]
    silent: SilentRows | None  #: Searches that found nothing.


def read_touch_run(
    plan_file: Path, results_path: Path, setup_file: Path | None = None, *, part: str | None = None
) -> TouchRun:
    """Read a plan and the results of its program.

    Raises `InputError` when a file cannot be used, or the results are not those of the plan.
    """
    plan = read_touch_plan(plan_file)
    if plan.first_stage is not None:
        raise InputError(
            f"{plan_file}: the first of two stages does not hold the part: plan the second (wpcal touches --after)"
        )
    setup = TouchSetup() if setup_file is None else read_touch_setup(setup_file)
    results = read_touch_results(results_path, plan, setup)
    paired = pair_results(plan, results, setup)
    require_enough(plan, paired)
    record = {
        "plan": {"file": plan_file.name, "fingerprint": plan.fingerprint},
        "controller": results.controller,
        "tool": results.tool,
        "used": list(paired.taught.names),
        "left_out": [{"name": name, "outcome": outcome.value} for name, outcome in paired.left_out],
        "stick_out_error_mm": paired.stick_out_mm,
        "latency_mm": setup.latency_s * setup.search_speed_mm_s,
    }
    taught = replace(paired.taught, sha256=sha256_of(read_bytes(Path(results.path))))
    issues = paired.issues
    if part is not None and plan.part and plan.part != part:
        other = f"the touches were planned for {plan.part}, and the part is {part}; is it the same part?"
        issues = (Issue(OTHER_PART, other), *issues)
    return TouchRun(taught, nominal_place(plan), record, issues, paired.silent)
