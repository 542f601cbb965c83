"""Touch sensing: searches of the torch towards the part, the plan of them, and what a controller stored."""

from wpcal.searches.plan import Contact, Search, SearchKind, TouchPlan
from wpcal.searches.results import Outcome, SearchResult, SearchResults
from wpcal.searches.setup import TouchSetup

__all__ = [
    "Contact",
    "Outcome",
    "Search",
    "SearchKind",
    "SearchResult",
    "SearchResults",
    "TouchPlan",
    "TouchSetup",
]
