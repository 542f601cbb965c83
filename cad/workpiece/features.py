"""List the reference features of a part, those that are easiest to touch first."""

from __future__ import annotations

from pathlib import Path

from cad.workpiece.answer_cache import NO_CACHE, AnswerCache
from cad.workpiece.workpiece import Workpiece, open_workpiece
from wpcal.core.issue import Issue
from wpcal.core.progress import Progress, no_progress
from wpcal.core.wording import counted
from wpcal.seam.member.note import MemberNotes, take_members
from wpcal.seam.options import Judging
from wpcal.taught.features import Touchable


def list_features(
    step: Path, *, cache: AnswerCache = NO_CACHE, progress: Progress = no_progress
) -> tuple[tuple[Touchable, ...], MemberNotes, tuple[Issue, ...]]:
    """Return the reference features of a STEP file, what its solids are taken for, and what is odd in it.

    The features that are easiest to touch come first.
    """
    workpiece = open_workpiece(step, cache=cache, progress=progress)
    notes = take_members(workpiece.graph, workpiece.trimmed, Judging()).notes
    return judge_workpiece(workpiece, progress=progress), notes, workpiece.issues


def judge_workpiece(workpiece: Workpiece, *, progress: Progress = no_progress) -> tuple[Touchable, ...]:
    """Return the reference features of a workpiece, those that are easiest to touch first."""
    progress(f"judging {counted(len(workpiece.features), 'feature')}")
    return tuple(sorted(workpiece.judged, key=lambda item: item.ease))
