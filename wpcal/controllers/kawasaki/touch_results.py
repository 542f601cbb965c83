"""Results of a touch program in AS: variables in a file that the controller's SAVE wrote."""

from __future__ import annotations

import re
from collections.abc import Sequence

from wpcal.controllers.kawasaki.read import read_as
from wpcal.controllers.language.named_results import ResultNames
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import ResultsFile, SearchResults
from wpcal.touch.searches.setup import TouchSetup

SECTION = re.compile(r"^\.(?P<name>[A-Za-z]++)\b")
VALUE = re.compile(r'^\s*+(?P<name>\$?+\w++)\s*+=\s*+(?:"(?P<text>[^"\n]*+)"|(?P<number>\S++))')
NAMES = ResultNames("$wpt_plan", "$wpt_tool", "wpt_count", "wpto_", "wptp_", "wpt_part")


def read_as_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the saved variables; see `TouchResultsReader`."""
    file = next((each for each in files if NAMES.outcome in each.text.lower()), files[0])
    values, places, section = dict[str, str](), [".TRANS"], ""
    for line in file.text.splitlines():
        head = SECTION.match(line)
        section = head["name"].upper() if head else section
        # programs of the same file say nothing about these values
        places.append(line if not head and section == "TRANS" else "")
        if section in ("REALS", "STRINGS") and (match := VALUE.match(line)):
            values[match["name"].lower()] = match["number"] if match["text"] is None else match["text"]
    return NAMES.stored(values, read_as("\n".join(places), file.path), file.path).results("as", file.path)
