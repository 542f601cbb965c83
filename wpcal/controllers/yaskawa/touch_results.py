"""Results of a touch program in INFORM: the variables of ``VAR.DAT``.

The file does not hold the user frame. The job says in remarks which numbers are typed in at the controller: those of
the plan with the digits of the language.

Sections ``///B``, ``///D`` and ``///P`` hold the variables in the order of their numbers, from 0. Rows of B and D have
any length. A position variable is one row; lines of settings (``///POSTYPE``, ``///USER``) between rows do not count.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from wpcal.controllers.language.rounding import rounded_frame
from wpcal.controllers.yaskawa.write import DEG_DECIMALS, MM_DECIMALS
from wpcal.core.errors import FormatError
from wpcal.core.transform import RigidTransform
from wpcal.taught.programs import stored_pose
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import (
    ResultsFile,
    SearchResults,
    StoredValues,
    fingerprint_of_stored,
    number_at,
    parsed_number,
    text_number,
)
from wpcal.touch.searches.setup import TouchSetup

SECTION = re.compile(r"^///(?P<kind>[A-Z]{1,2})\s*$")
ROW = re.compile(r"^\s*+(?:[A-Z]{1,2}(?P<number>\d{2,5})\s*+=\s*+)?(?P<values>[-+.\d].*)$")
AXES = ("X", "Y", "Z", "Rx", "Ry", "Rz")


def read_inform_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the file of variables; see `TouchResultsReader`."""
    file, inform = files[0], setup.inform
    rows = _sections(file)
    if not {"B", "D", "P"} <= set(rows):
        raise FormatError("has no sections ///B, ///D and ///P of variables", path=file.path)
    byte, double = (_numbers(rows[kind], kind, file.path) for kind in "BD")
    places = _positions(rows["P"])
    first = inform.first_double_variable
    stored = StoredValues(
        fingerprint=fingerprint_of_stored(double.get(first), double.get(first + 1)),
        tool=text_number(number_at(double, first + 3, f"D{first + 3:03d}", file.path)),
        count=number_at(double, first + 4, f"D{first + 4:03d}", file.path),
        T_base_part=rounded_frame(plan.T_base_part, mm_decimals=MM_DECIMALS, deg_decimals=DEG_DECIMALS),
    )
    for k, search in enumerate(plan.searches):
        name, number = search.name.upper(), inform.first_position_variable + k
        outcome = inform.first_byte_variable + k
        stored.outcomes[name] = number_at(byte, outcome, f"B{outcome:03d}", file.path)
        pose = _pose(places.get(number, []), f"P{number:03d}", file.path)
        if isinstance(pose, str):
            stored.faults[name] = pose
        else:
            stored.places[name] = pose
    return stored.results("inform", file.path)


def _sections(file: ResultsFile) -> dict[str, list[str]]:
    """Return the rows with values of each kind of variable."""
    rows: dict[str, list[str]] = {}
    kind = ""
    for line in file.text.splitlines():
        head = SECTION.match(line)
        if head:
            kind = head["kind"]
            rows.setdefault(kind, [])
        elif kind and ROW.match(line):
            rows[kind].append(line)
    return rows


def _numbers(rows: Sequence[str], kind: str, path: str) -> dict[int, float]:
    cells = [cell for row in rows for cell in re.split(r"[\s,]+", row.strip()) if cell]
    return {index: parsed_number(cell, f"{kind}{index:03d}", path) for index, cell in enumerate(cells)}


def _positions(rows: Sequence[str]) -> dict[int, list[str]]:
    found: dict[int, list[str]] = {}
    for index, row in enumerate(rows):
        match = ROW.match(row)
        if match:
            number = index if match["number"] is None else int(match["number"])
            found[number] = [cell for cell in re.split(r"[\s,]+", match["values"].strip()) if cell]
    return found


def _pose(cells: Sequence[str], name: str, path: str) -> RigidTransform | str:
    if len(cells) < len(AXES):
        return f"{name} is not a Cartesian position"
    return stored_pose(list(zip(AXES, cells, strict=False)), name, path, 0)
