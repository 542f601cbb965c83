"""Results of a touch program in RAPID: the module that the program saves."""

from __future__ import annotations

import re
from collections.abc import Sequence

from wpcal.controllers.abb.read import read_rapid
from wpcal.core.errors import FormatError
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import ResultsFile, SearchResults, StoredValues, parsed_number
from wpcal.touch.searches.setup import TouchSetup

NUMBER = re.compile(r"\bPERS\s++num\s++(?P<name>wpt\w++)\s*+:=\s*+(?P<value>[^;\s]++)\s*+;", re.IGNORECASE)
TEXT = re.compile(r'\bPERS\s++string\s++(?P<name>wpt\w++)\s*+:=\s*+"(?P<value>[^"\n]*+)"\s*+;', re.IGNORECASE)
OUTCOME, PLACE, FRAME = "wpto_", "wptp_", "wptpart"


def read_rapid_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the saved module of results; see `TouchResultsReader`."""
    file = next((each for each in files if any(_texts(each.text))), files[0])
    numbers = {match["name"].lower(): match["value"] for match in NUMBER.finditer(file.text)}
    texts = _texts(file.text)
    stored = StoredValues(fingerprint=texts.get("wptplan", ""), tool=texts.get("wpttool", ""))
    for name, value in numbers.items():
        number = parsed_number(value, name, file.path)
        if name.startswith(OUTCOME):
            stored.outcomes[name.removeprefix(OUTCOME).upper()] = number
        elif name == "wptcount":
            stored.count = number
    read = read_rapid(file.text, file.path)
    for point in read.points:
        search = point.name.lower().removeprefix(PLACE).upper()
        if not point.name.lower().startswith(PLACE):
            continue
        if point.fault is not None:
            stored.faults[search] = point.fault
        else:
            stored.places[search] = point.T_frame_tool
    frames = {name.lower(): T for name, T in read.frames.items()}
    if stored.outcomes and FRAME not in frames:
        raise FormatError("lacks the work object wptPart of the places", path=file.path)
    stored.T_base_part = frames.get(FRAME)
    return stored.results("rapid", file.path)


def _texts(text: str) -> dict[str, str]:
    return {match["name"].lower(): match["value"] for match in TEXT.finditer(text)}
