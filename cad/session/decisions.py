"""Decisions about seams that a page or another program sends."""

from __future__ import annotations

from typing import Any

from wpcal.core.errors import InputError
from wpcal.seam.edit import PlacedEdit, candidate_from_record, edit_from_record

MOST_DECISIONS = 10_000  #: More are no work of a person.


def read_decisions(decisions: Any, *, path: str) -> tuple[PlacedEdit, ...]:
    """Return the decisions that a page or another program sends.

    Raises `InputError` when a decision has a wrong form.
    """
    if not isinstance(decisions, list) or len(decisions) > MOST_DECISIONS:
        raise InputError(f"expected a list of at most {MOST_DECISIONS} decisions about seams")
    edits = []
    for decision in decisions:
        if not isinstance(decision, dict) or not isinstance(decision.get("candidate"), dict):
            raise InputError("expected a candidate and an edit for every decision about a seam")
        label = str(decision["candidate"].get("name", "?"))
        candidate = candidate_from_record(decision["candidate"], label, path=path)
        edits.append(PlacedEdit(candidate, edit_from_record(decision.get("edit"), label, path=path), path))
    return tuple(edits)
