"""List the reference features of a part, those that are easiest to touch first."""

from __future__ import annotations

from pathlib import Path

from cad.workpiece.answer_cache import NO_CACHE, AnswerCache
from cad.workpiece.workpiece import Workpiece, open_workpiece
from wpcal.core.issue import Issue
from wpcal.core.progress import Progress, no_progress
from wpcal.core.wording import counted
from wpcal.taught.features import Touchable


def list_features(
    step: Path, *, cache: AnswerCache = NO_CACHE, progress: Progress = no_progress
) -> tuple[tuple[Touchable, ...], tuple[Issue, ...]]:
    """Return the reference features of a STEP file, those that are easiest to touch first, and what is odd in it."""
    workpiece = open_workpiece(step, cache=cache, progress=progress)
    return judge_workpiece(workpiece, progress=progress), workpiece.issues


def judge_workpiece(workpiece: Workpiece, *, progress: Progress = no_progress) -> tuple[Touchable, ...]:
    """Return the reference features of a workpiece, those that are easiest to touch first."""
    progress(f"judging {counted(len(workpiece.features), 'feature')}")
    return tuple(sorted(workpiece.judged, key=lambda item: item.ease))
