"""Results of a touch program of FANUC: position registers (``posreg.va``) and registers (``numreg.va``).

The controller prints ``Uninitialized`` for an empty register.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

from wpcal.controllers.fanuc.registers import POSITIONS, registers_of, rows_behind
from wpcal.core.errors import FormatError
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

NUMBERS = re.compile(r"^\[\*NUMREG\*\]\$NUMREG\b", re.MULTILINE)
NUMBER = re.compile(r"^\s*+\[(?P<number>\d{1,5})\]\s*+=\s*+(?P<value>[^\s']++)")
FIRST_OUTCOME = 5  #: Registers before the outcomes: two of the fingerprint, frame, tool and count.


def read_fanuc_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read both files; see `TouchResultsReader`."""
    positions = next((each for each in files if POSITIONS.search(each.text)), None)
    registers = next((each for each in files if NUMBERS.search(each.text)), None)
    path = files[0].path
    if positions is None or registers is None:
        missing = "posreg.va" if positions is None else "numreg.va"
        raise FormatError(f"without {missing}: copy posreg.va and numreg.va into one folder", path=path)
    numbers = _numbers(registers)
    first, place = setup.fanuc.first_register, setup.fanuc.first_position_register
    stored = StoredValues(
        fingerprint=fingerprint_of_stored(numbers.get(first), numbers.get(first + 1)),
        tool=text_number(number_at(numbers, first + 3, f"R[{first + 3}]", registers.path)),
        count=number_at(numbers, first + 4, f"R[{first + 4}]", registers.path),
    )
    poses = {each.number: each.pose for each in registers_of(positions.text, positions.path)}
    T_base_part = poses.get(place)
    if isinstance(T_base_part, str):
        raise FormatError(f"PR[{place}], the user frame of the touches, {T_base_part}", path=positions.path)
    stored.T_base_part = T_base_part
    for k, search in enumerate(plan.searches):
        name, register, number = search.name.upper(), first + FIRST_OUTCOME + k, place + 1 + k
        stored.outcomes[name] = number_at(numbers, register, f"R[{register}]", registers.path)
        pose = poses.get(number, "is not in the file")
        if isinstance(pose, str):
            stored.faults[name] = f"PR[{number}] {pose}"
        else:
            stored.places[name] = pose
    return stored.results("fanuc", positions.path)


def _numbers(file: ResultsFile) -> dict[int, float]:
    values: dict[int, float] = {}
    for _, line in rows_behind(NUMBERS, file.text):
        match = NUMBER.match(line)
        if match and "*" not in match["value"] and match["value"] != "Uninitialized":
            values[int(match["number"])] = parsed_number(match["value"], f"R[{match['number']}]", file.path)
    return values
