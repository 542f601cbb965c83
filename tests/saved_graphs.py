"""The saved graphs in fixtures/graphs, for tests that need no CAD kernel; `tests.samples.graphs` makes them."""

from functools import cache
from pathlib import Path

from wpcal.brep import BrepGraph
from wpcal.brep.graph_file import read_graph
from wpcal.seam import Seam, detect_seams

GRAPHS = Path(__file__).parents[1] / "fixtures" / "graphs"


@cache
def saved_graph(name: str) -> BrepGraph:
    """Return a saved graph, read once in a process."""
    return read_graph(GRAPHS / f"{name}.npz")


@cache
def saved_seams(name: str) -> tuple[Seam, ...]:
    """Return the seams of a saved graph with the usual options, found once in a process."""
    return detect_seams(saved_graph(name))
