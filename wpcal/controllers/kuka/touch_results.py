"""Results of a touch program in KRL: the data list, as copied back from the controller."""

from __future__ import annotations

import re
from collections.abc import Sequence

from wpcal.controllers.kuka.read import read_krl
from wpcal.controllers.language.named_results import ResultNames
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import ResultsFile, SearchResults
from wpcal.touch.searches.setup import TouchSetup

NUMBER = re.compile(r"^[ \t]*+(?:DECL\s++)?(?:GLOBAL\s++)?INT\s++(WP\w++)\s*+=\s*+(\S++)", re.MULTILINE | re.IGNORECASE)
PLAN = re.compile(r'^[ \t]*+(WPPLAN)\[\]\s*+=\s*+"([^"\n]*+)"', re.MULTILINE | re.IGNORECASE)
NAMES = ResultNames("wpplan", "wptool", "wpcount", "wpo_", "wpr_", "wppart")


def read_krl_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the data list with the results; see `TouchResultsReader`."""
    file = next((each for each in files if PLAN.search(each.text)), files[0])
    values = {name.upper(): value for pattern in (PLAN, NUMBER) for name, value in pattern.findall(file.text)}
    return NAMES.stored(values, read_krl(file.text, file.path), file.path).results("krl", file.path)
