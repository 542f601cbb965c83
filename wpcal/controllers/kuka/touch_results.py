"""Results of a touch program in KRL: the data list, as copied back from the controller."""

from __future__ import annotations

import re
from collections.abc import Sequence

from wpcal.controllers.kuka.read import read_krl
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import ResultsFile, SearchResults, StoredValues, parsed_number
from wpcal.touch.searches.setup import TouchSetup

NUMBER = re.compile(r"^[ \t]*+(?:DECL\s++)?(?:GLOBAL\s++)?INT\s++(?P<name>WP\w++)\s*+=\s*+(?P<value>\S++)", re.M | re.I)
PLAN = re.compile(r'^[ \t]*+WPPLAN\[\]\s*+=\s*+"(?P<value>[^"\n]*+)"', re.MULTILINE | re.IGNORECASE)
OUTCOME, PLACE, FRAME = "WPO_", "WPR_", "WPPART"


def read_krl_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the data list with the results; see `TouchResultsReader`."""
    file = next((each for each in files if PLAN.search(each.text)), files[0])
    text = PLAN.search(file.text)
    stored = StoredValues(fingerprint="" if text is None else text["value"])
    for match in NUMBER.finditer(file.text):
        name, number = match["name"].upper(), match["value"]
        if name.startswith(OUTCOME):
            stored.outcomes[name.removeprefix(OUTCOME)] = parsed_number(number, name, file.path)
        elif name == "WPCOUNT":
            stored.count = parsed_number(number, name, file.path)
        elif name == "WPTOOL":
            stored.tool = number
    read = read_krl(file.text, file.path)
    for point in read.points:
        name = point.name.upper()
        if name.startswith(PLACE) and point.fault is None:
            stored.places[name.removeprefix(PLACE)] = point.T_frame_tool
        elif name.startswith(PLACE) and point.fault is not None:
            stored.faults[name.removeprefix(PLACE)] = point.fault
    stored.T_base_part = {name.upper(): T for name, T in read.frames.items()}.get(FRAME)
    return stored.results("krl", file.path)
