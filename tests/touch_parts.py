"""Parts for tests of touch plans: saved graphs with their accepted seams."""

from functools import cache

from tests.saved_graphs import saved_graph, saved_seams
from wpcal.brep.trim import TrimmedFaces
from wpcal.taught.features import find_features
from wpcal.touch.plan import TouchPart


@cache
def touch_part(name: str) -> TouchPart:
    """Return a part of `fixtures/graphs`; its exact faces are what the torch is compared with."""
    graph = saved_graph(name)
    seams = [seam for seam in saved_seams(name) if seam.accepted]
    return TouchPart(f"{name}.step", graph, TrimmedFaces.of(graph), seams, find_features(graph))
