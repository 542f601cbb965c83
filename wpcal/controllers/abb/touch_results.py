"""Results of a touch program in RAPID: the module that the program saves."""

from __future__ import annotations

import re
from collections.abc import Sequence

from wpcal.controllers.abb.read import read_rapid
from wpcal.controllers.language.named_results import ResultNames
from wpcal.core.errors import FormatError
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import ResultsFile, SearchResults
from wpcal.touch.searches.setup import TouchSetup

NUMBER = re.compile(r"\bPERS\s++num\s++(wpt\w++)\s*+:=\s*+([^;\s]++)\s*+;", re.IGNORECASE)
TEXT = re.compile(r'\bPERS\s++string\s++(wpt\w++)\s*+:=\s*+"([^"\n]*+)"\s*+;', re.IGNORECASE)
NAMES = ResultNames("wptplan", "wpttool", "wptcount", "wpto_", "wptp_", "wptpart")


def read_rapid_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the saved module of results; see `TouchResultsReader`."""
    file = next((each for each in files if TEXT.search(each.text)), files[0])
    values = {name: value for pattern in (TEXT, NUMBER) for name, value in pattern.findall(file.text)}
    stored = NAMES.stored(values, read_rapid(file.text, file.path), file.path)
    if stored.outcomes and stored.T_base_part is None:
        raise FormatError("lacks the work object wptPart of the places", path=file.path)
    return stored.results("rapid", file.path)
