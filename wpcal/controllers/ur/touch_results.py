"""Results of a touch program in URScript: its lines in the log, or what the socket received."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from wpcal.core.errors import FormatError, InputError
from wpcal.core.numbers import parse_number
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import ResultsFile, SearchResults, StoredValues
from wpcal.touch.searches.setup import TouchSetup

LINE = re.compile(r"\bwpcal\s++(?P<plan>[0-9a-fA-F]{8})\s++(?P<what>\w++)(?P<rest>.*)$")
POSE = re.compile(r"p?\[(?P<values>[^\[\]]*+)\]")
WORDS = {"found": 1.0, "missed": 2.0, "active": 3.0}  #: Outcomes, as numbers of other controllers.
MM = 1000.0


def read_urscript_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the last run of a log; see `TouchResultsReader`."""
    file = files[0]
    stored: StoredValues | None = None
    for number, line in enumerate(file.text.splitlines(), start=1):
        match = LINE.search(line)
        if match is None:
            continue
        what, rest = match["what"], match["rest"]
        if what == "begin":
            stored = StoredValues(fingerprint=match["plan"], count=_count(rest, file.path, number))
        elif stored is not None and match["plan"].lower() == stored.fingerprint.lower():
            _note(stored, what, rest, file.path, number)
    if stored is None:
        raise FormatError('has no line "wpcal … begin" of a touch program', path=file.path)
    for search in plan.searches:  # a search without a line was not run
        stored.outcomes.setdefault(search.name.upper(), 0.0)
    return stored.results("urscript", file.path)


def _note(stored: StoredValues, what: str, rest: str, path: str, line: int) -> None:
    if what == "tool":
        stored.tool = rest.strip()
    elif what == "part":
        stored.T_base_part = _pose(rest, "part", path, line)
    elif what != "end":
        word = rest.split(maxsplit=1)[0] if rest.split() else ""
        if word not in WORDS:
            raise FormatError(f"search {what}: expected {', '.join(WORDS)}, got {word!r}", path=path, line=line)
        stored.outcomes[what.upper()] = WORDS[word]
        if word == "found":
            stored.places[what.upper()] = _pose(rest, f"search {what}", path, line)


def _count(text: str, path: str, line: int) -> float:
    try:
        return parse_number(text.strip())
    except InputError as error:
        raise FormatError(f"number of searches: {error}", path=path, line=line) from None


def _pose(text: str, what: str, path: str, line: int) -> RigidTransform:
    match = POSE.search(text)
    try:
        values = np.array([parse_number(cell) for cell in ("" if match is None else match["values"]).split(",")])
    except InputError as error:
        raise FormatError(f"{what}: {error}", path=path, line=line) from None
    if len(values) != 6:
        raise FormatError(f"{what}: expected six numbers, got {len(values)}", path=path, line=line)
    if not np.linalg.norm(values[3:]) <= 4.0 * np.pi:
        raise FormatError(f"{what}: its rotation vector is longer than two turns", path=path, line=line)
    return RigidTransform(exp_rotation(values[3:]), MM * values[:3], "base", "frame")
