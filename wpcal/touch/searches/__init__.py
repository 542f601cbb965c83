"""Touch sensing: searches of the torch towards the part, the plan of them, and what a controller stored."""

from wpcal.touch.searches.plan import (
    Contact,
    FirstStage,
    PlannedBody,
    SeamPrediction,
    Search,
    SearchKind,
    Served,
    TouchPlan,
)
from wpcal.touch.searches.record import plan_from_record, read_touch_plan, touches_csv, touches_record
from wpcal.touch.searches.results import (
    STORED_NUMBERS,
    Outcome,
    ResultsFile,
    SearchResult,
    SearchResults,
    TouchResultsReader,
    fingerprint_of,
    halves_of,
)
from wpcal.touch.searches.setup import TouchSetup, read_touch_setup, setup_template

__all__ = [
    "STORED_NUMBERS",
    "Contact",
    "FirstStage",
    "Outcome",
    "PlannedBody",
    "ResultsFile",
    "SeamPrediction",
    "Search",
    "SearchKind",
    "SearchResult",
    "SearchResults",
    "Served",
    "TouchPlan",
    "TouchResultsReader",
    "TouchSetup",
    "fingerprint_of",
    "halves_of",
    "plan_from_record",
    "read_touch_plan",
    "read_touch_setup",
    "setup_template",
    "touches_csv",
    "touches_record",
]
