"""A run of a touch program, read: its plan, its results, and the touches that are fitted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any

from wpcal.controllers.language.grammar import ENCODING
from wpcal.controllers.registry import Controller, controllers
from wpcal.core.errors import InputError
from wpcal.core.input_file import read_bytes, sha256_of
from wpcal.core.issue import Issue
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed
from wpcal.taught.table import TaughtPoints
from wpcal.touch.searches import ResultsFile, SearchResults, TouchPlan, TouchSetup, read_touch_plan, read_touch_setup
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


def read_touch_results(path: Path, plan: TouchPlan, setup: TouchSetup | None = None) -> SearchResults:
    """Read what a controller stored when it ran the searches of a plan.

    Raises `InputError` when no controller stores results in such files, or they cannot be used.

    `path`: A file of the controller, or a folder with its files. Of files that belong together (``posreg.va`` and
    ``numreg.va``) one is named, and the other is beside it.
    """
    known = [each for each in controllers() if each.touch_results_reader is not None]
    chosen = _claiming(path, known)
    if not chosen:
        patterns = listed(sorted({name for each in known for name in each.touch_results}))
        raise InputError(f"{path}: is not a file in which a touch program stores its results; expected {patterns}")
    if len(chosen) > 1:
        names = listed(each.name for each in chosen)
        raise InputError(f"{path}: holds files of {names}; name the file with the results")
    files = [ResultsFile(str(each), read_bytes(each).decode(ENCODING)) for each in _files(path, chosen[0])]
    return chosen[0].read_touches(files, plan, setup or TouchSetup())


def files_beside(path: Path) -> list[Path]:
    """Return the files in the folder of a file that are read together with it, whichever controller wrote it."""
    known = [each for each in controllers() if each.touch_results_reader is not None]
    return sorted({other for each in known for other in _files(path, each)} - {path})


def _files(path: Path, controller: Controller) -> list[Path]:
    """Return the files to read: those of a folder, or the named one with those that belong to it."""
    if path.is_dir():
        own = controller.touch_results
        files = [each for each in sorted(path.iterdir()) if each.is_file()]
        return [each for each in files if any(fnmatchcase(each.name.lower(), pattern) for pattern in own)]
    if path.name.lower() not in controller.touch_results or not path.is_file():
        return [path]
    others = {*controller.touch_results} - {path.name.lower()}
    return [path, *(each for each in sorted(path.parent.iterdir()) if each.name.lower() in others)]


def _claiming(path: Path, known: list[Controller]) -> list[Controller]:
    """Return the controllers whose results are in a file or a folder; a whole name outranks a suffix."""
    names = [each.name.lower() for each in path.iterdir()] if path.is_dir() else [path.name.lower()]
    whole = [each for each in known if any(pattern in names for pattern in each.touch_results)]
    if whole:
        return whole
    return [each for each in known if any(fnmatchcase(name, p) for name in names for p in each.touch_results)]
