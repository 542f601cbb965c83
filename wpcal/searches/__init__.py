"""Touch sensing: searches of the torch towards the part, the plan of them, and what a controller stored."""

from wpcal.searches.plan import Contact, SeamPrediction, Search, SearchKind, TouchPlan
from wpcal.searches.record import plan_from_record, read_touch_plan, touches_csv, touches_record
from wpcal.searches.results import Outcome, SearchResult, SearchResults
from wpcal.searches.setup import TouchSetup

__all__ = [
    "Contact",
    "Outcome",
    "SeamPrediction",
    "Search",
    "SearchKind",
    "SearchResult",
    "SearchResults",
    "TouchPlan",
    "TouchSetup",
    "plan_from_record",
    "read_touch_plan",
    "touches_csv",
    "touches_record",
]
