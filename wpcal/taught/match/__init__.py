"""Which taught point is which point of the model."""

from wpcal.taught.match.nameless import Answer, Match, MatchOptions, match_points, name_points
from wpcal.taught.match.places import Places
from wpcal.taught.match.search import Assignments, find_assignments

__all__ = [
    "Answer",
    "Assignments",
    "Match",
    "MatchOptions",
    "Places",
    "find_assignments",
    "match_points",
    "name_points",
]
