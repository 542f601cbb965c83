"""Results of a touch program of FANUC: position registers (``posreg.va``) and registers (``numreg.va``).

The controller drops the zero before the point of small numbers (``-.123``), prints asterisks where a number does not
fit or was never set, and ``Uninitialized`` for an empty register. ``posreg.va`` names neither user frame nor tool.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from wpcal.core.errors import FormatError, InputError
from wpcal.core.transform import RigidTransform
from wpcal.taught.programs import coordinates, frame_from_xyz_angles
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

POSITIONS = re.compile(r"^\[\*POSREG\*\]\$POSREG\b", re.MULTILINE)
NUMBERS = re.compile(r"^\[\*NUMREG\*\]\$NUMREG\b", re.MULTILINE)
POSITION = re.compile(r"^\s*+\[1,(?P<number>\d{1,5})\]\s*+=\s*+'[^'\n]*+'(?P<rest>.*)$")
OTHER = re.compile(r"^\s*+\[")
COORDINATE = re.compile(r"\b([XYZWPR]):\s*+([^\s:]{1,40}+)")
JOINT = re.compile(r"\bJ[1-9]\s*+=")
NUMBER = re.compile(r"^\s*+\[(?P<number>\d{1,5})\]\s*+=\s*+(?P<value>[^\s']++)")
KEYS = "XYZWPR"
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
    poses, faults = _positions(positions)
    if place in faults:
        raise FormatError(f"PR[{place}], the user frame of the touches, {faults[place]}", path=positions.path)
    stored.T_base_part = poses.get(place)
    for k, search in enumerate(plan.searches):
        name, register, number = search.name.upper(), first + FIRST_OUTCOME + k, place + 1 + k
        stored.outcomes[name] = number_at(numbers, register, f"R[{register}]", registers.path)
        if number in poses:
            stored.places[name] = poses[number]
        else:
            stored.faults[name] = f"PR[{number}] {faults.get(number, 'is not in the file')}"
    return stored.results("fanuc", positions.path)


def _numbers(file: ResultsFile) -> dict[int, float]:
    values: dict[int, float] = {}
    for line in file.text[_start(NUMBERS, file.text) :].splitlines()[1:]:
        if line.startswith("[*"):
            break
        match = NUMBER.match(line)
        if match and "*" not in match["value"] and match["value"] != "Uninitialized":
            values[int(match["number"])] = parsed_number(match["value"], f"R[{match['number']}]", file.path)
    return values


def _positions(file: ResultsFile) -> tuple[dict[int, RigidTransform], dict[int, str]]:
    """Return the poses of motion group 1, and why the others are none."""
    bodies: dict[int, list[str]] = {}
    body: list[str] = []
    for line in file.text[_start(POSITIONS, file.text) :].splitlines()[1:]:
        if line.startswith("[*"):
            break
        match = POSITION.match(line)
        if match:
            body = bodies[int(match["number"])] = [match["rest"]]
        elif OTHER.match(line):
            body = []
        else:
            body.append(line)
    poses: dict[int, RigidTransform] = {}
    faults: dict[int, str] = {}
    for number, lines in bodies.items():
        pose = _pose("\n".join(lines), number, file.path)
        if isinstance(pose, str):
            faults[number] = pose
        else:
            poses[number] = pose
    return poses, faults


def _pose(text: str, number: int, path: str) -> RigidTransform | str:
    if "Uninitialized" in text:
        return "is not initialised"
    if JOINT.search(text):
        return "is stored as joint angles"
    values = dict(COORDINATE.findall(text))
    if any("*" in value for value in values.values()):
        return "has coordinates that the controller prints as asterisks"
    missing = [key for key in KEYS if key not in values]
    if missing:
        return f"lacks {', '.join(missing)}"
    cells = coordinates([(key, values[key]) for key in KEYS], f"PR[{number}]", path, 0)
    try:
        return frame_from_xyz_angles(np.asarray(cells).tolist())
    except InputError as error:
        return str(error)


def _start(head: re.Pattern[str], text: str) -> int:
    match = head.search(text)
    return 0 if match is None else match.start()
