"""Judge touch programs: their poses are numbers, and those of the plan; the plan that lies beside them is theirs."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterator, Mapping
from pathlib import Path

from wpcal.controllers.audit.fault import Fault
from wpcal.controllers.audit.programs import (
    ReadPose,
    Surroundings,
    executed,
    pose_faults,
    read_poses_back,
    require_grammar,
    unknown_faults,
)
from wpcal.controllers.judge.asked import asked_of_touches, compare, contacts_of
from wpcal.controllers.language.grammar import ENCODING
from wpcal.controllers.program.touch_program import TouchProgram
from wpcal.controllers.run.recorder import Trace
from wpcal.core.errors import WpcalError
from wpcal.core.transform import RigidTransform
from wpcal.touch.searches import TouchPlan, read_touch_plan
from wpcal.touch.searches.record import TOUCHES_FILE

_FINGERPRINT = re.compile(r"touches\.json,\s*(?:;\s*)?(?:\d+:)?[\s!;'#]*fingerprint[\s!;'#:\d]*?\b([0-9a-f]{8})\b")
"""In the header, which may be wrapped into remarks."""
CHECKED = "finite, rotations, executed: the poses of the plan of touches beside it in their order; NOT CHECKED: the arm"
ALONE = f"finite, rotations; NOT CHECKED: where it leads (no {TOUCHES_FILE} is beside it), the arm"


def checked_near(path: Path) -> str:
    """Say what is compared in a touch program, and what is not."""
    return ALONE if _plan_near(path) is None else CHECKED


def touch_faults(raw: bytes, path: Path) -> list[Fault]:
    """Return the faults of one file of a touch program."""
    plan = _plan_near(path)
    if plan is not None:
        stated = _FINGERPRINT.search(raw.decode(ENCODING))
        if stated is not None and stated[1] != plan.fingerprint:
            what = f"is of the plan {stated[1]}; {TOUCHES_FILE} beside it is {plan.fingerprint}: export it again"
            return [Fault(what)]
    if not require_grammar(path).has_poses(path):
        return []
    T_base_part = None if plan is None else plan.T_base_part
    try:
        poses = _poses(raw, path, T_base_part)
    except WpcalError as error:
        return [Fault.of(error, str(path))]
    return list(pose_faults(poses, Surroundings(T_base_part)))


def executed_touch_faults(files: Mapping[str, bytes], own: Collection[str], path: Path) -> Iterator[tuple[str, Fault]]:
    """Yield the names of files and where touch programs that lie together lead otherwise than the plan beside them.

    `own`: Names of the touch programs; they may call the others of `files`.
    """
    plan = _plan_near(path)
    if plan is None or not plan.searches:
        return
    trace, refused = executed(files, Surroundings(plan.T_base_part), feel=contacts_of(plan))
    broken = [(name, fault) for name, faults in refused.items() if name in own for fault in faults]
    broken += [(name, fault) for name, fault in unknown_faults(trace) if name in own]
    yield from broken or _led_otherwise(trace, plan, own)


def _led_otherwise(trace: Trace, plan: TouchPlan, own: Collection[str]) -> Iterator[tuple[str, Fault]]:
    found = compare(trace, asked_of_touches(TouchProgram(plan)))
    last = max((motion.step for motion in trace.motions if motion.kind == "S"), default=0)
    welds = any(motion.step > last and motion.place.file not in own for motion in trace.motions)
    others = [each for each in found.others if each.place.file in own and not (welds and each.step > last)]
    for motion in others:
        yield motion.place.file, Fault("leads where the plan of touches has no pose", motion.place.line)
    if found.missing and not others:
        yield next(iter(own)), Fault(f"does not lead to {len(found.missing)} poses of the plan of touches")


def _plan_near(path: Path) -> TouchPlan | None:
    """Return the plan beside a program, if it can be read: its own audit lists what is wrong with it."""
    for folder in path.absolute().parents[:2]:
        if (folder / TOUCHES_FILE).is_file():
            try:
                return read_touch_plan(folder)
            except WpcalError:
                return None
    return None


def _poses(raw: bytes, path: Path, T_base_part: RigidTransform | None) -> list[ReadPose]:
    stored = require_grammar(path).results
    poses = read_poses_back(raw, path, T_base_part)
    return [pose for pose in poses if not (stored and re.match(stored, pose.name, re.IGNORECASE))]
