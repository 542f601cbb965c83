"""Results of a touch program in AS: variables in a file that the controller's SAVE wrote."""

from __future__ import annotations

import re
from collections.abc import Sequence

from wpcal.controllers.kawasaki.read import read_as
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import ResultsFile, SearchResults, StoredValues, parsed_number
from wpcal.touch.searches.setup import TouchSetup

SECTION = re.compile(r"^\.(?P<name>[A-Za-z]++)\b")
VALUE = re.compile(r'^\s*+(?P<name>\$?+\w++)\s*+=\s*+(?:"(?P<text>[^"\n]*+)"|(?P<number>\S++))')
OUTCOME, PLACE, FRAME = "wpto_", "wptp_", "wpt_part"


def read_as_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the saved variables; see `TouchResultsReader`."""
    file = next((each for each in files if OUTCOME in each.text.lower()), files[0])
    stored, places = StoredValues(), [".TRANS"]
    section = ""
    for line in file.text.splitlines():
        head = SECTION.match(line)
        section = head["name"].upper() if head else section
        is_place = not head and section == "TRANS"
        places.append(line if is_place else "")  # programs of the same file say nothing about these values
        match = VALUE.match(line) if section in ("REALS", "STRINGS") else None
        if match:
            _note(stored, match["name"].lower(), match["text"], match["number"], file.path)
    for point in read_as("\n".join(places), file.path).points:
        name = point.name.lower()
        if name == FRAME:
            stored.T_base_part = point.T_frame_tool.relabelled(target="base", source="frame")
        elif name.startswith(PLACE):
            stored.places[name.removeprefix(PLACE).upper()] = point.T_frame_tool
    return stored.results("as", file.path)


def _note(stored: StoredValues, name: str, text: str | None, number: str | None, path: str) -> None:
    if name == "$wpt_plan":
        stored.fingerprint = text or ""
    elif name == "$wpt_tool":
        stored.tool = text or ""
    elif number is not None and name == "wpt_count":
        stored.count = parsed_number(number, name, path)
    elif number is not None and name.startswith(OUTCOME):
        stored.outcomes[name.removeprefix(OUTCOME).upper()] = parsed_number(number, name, path)
