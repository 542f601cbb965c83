"""Results of a touch program in RAPID: the module that the program saves."""

from __future__ import annotations

from collections.abc import Sequence

from wpcal.controllers.abb.read import read_rapid
from wpcal.controllers.abb.statements import declarations, statements_of
from wpcal.controllers.language.named_results import ResultNames
from wpcal.core.errors import FormatError
from wpcal.touch.searches.plan import TouchPlan
from wpcal.touch.searches.results import ResultsFile, SearchResults
from wpcal.touch.searches.setup import TouchSetup

NAMES = ResultNames("wptplan", "wpttool", "wptcount", "wpto_", "wptp_", "wptpart")


def read_rapid_results(files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
    """Read the saved module of results; see `TouchResultsReader`."""
    file = next((each for each in files if _values(each.text, "string")), files[0])
    values = _values(file.text, "string", "num")
    stored = NAMES.stored(values, read_rapid(file.text, file.path), file.path)
    if stored.outcomes and stored.T_base_part is None:
        raise FormatError("lacks the work object wptPart of the places", path=file.path)
    return stored.results("rapid", file.path)


def _values(text: str, *kinds: str) -> dict[str, str]:
    """Return what a program of touches stores, without quotes."""
    found = declarations(statements_of(text), *kinds)
    return {
        each.name: "".join(each.tokens).strip('"')
        for each in found
        if each.storage == "PERS" and each.name.lower().startswith("wpt")
    }
