"""Results of a touch program in INFORM: the variables of ``VAR.DAT``.

The file does not hold the user frame. The job says in remarks which numbers are typed in at the controller: those of
the plan with the digits of the language.

Sections ``///B``, ``///D`` and ``///P`` hold the variables in the order of their numbers, from 0. Rows of B and D have
any length. A position variable is one row; lines of settings (``///POSTYPE``, ``///USER``) between rows do not count.
"""

from __future__ import annotations

from collections.abc import Sequence

from wpcal.controllers.language.rounding import rounded_frame
from wpcal.controllers.yaskawa.read import AXES, Variables, variables_of
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


def read_inform_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the file of variables; see `TouchResultsReader`."""
    file, inform = files[0], setup.inform
    rows = [*variables_of(file.text)]
    if not {"B", "D", "P"} <= {row.kind for row in rows}:
        raise FormatError("has no sections ///B, ///D and ///P of variables", path=file.path)
    byte, double = (_numbers(rows, kind, file.path) for kind in "BD")
    places = {row.first: row.cells for row in rows if row.kind == "P"}
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


def _numbers(rows: Sequence[Variables], kind: str, path: str) -> dict[int, float]:
    cells = {row.first + k: cell for row in rows if row.kind == kind for k, cell in enumerate(row.cells)}
    return {index: parsed_number(cell, f"{kind}{index:03d}", path) for index, cell in cells.items()}


def _pose(cells: Sequence[str], name: str, path: str) -> RigidTransform | str:
    if len(cells) < len(AXES):
        return f"{name} is not a Cartesian position"
    return stored_pose(list(zip(AXES, cells, strict=False)), name, path, 0)
