"""Which taught point is which point of the model."""

from wpcal.match.nameless import Answer, Match, match_points, name_points
from wpcal.match.places import Places
from wpcal.match.search import Assignments, find_assignments
from wpcal.match.taught import TaughtPoints, pair_points, read_taught

__all__ = [
    "Answer",
    "Assignments",
    "Match",
    "Places",
    "TaughtPoints",
    "find_assignments",
    "match_points",
    "name_points",
    "pair_points",
    "read_taught",
]
