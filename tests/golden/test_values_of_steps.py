"""What each step of the judgement of shapes finds, also where no seam shows it: surfaces, members, holes, contacts.

Every public function of these rooms is asked that needs no more than a graph and places on it.
"""

import inspect
from collections.abc import Callable, Iterator
from importlib import import_module
from itertools import product
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
import pytest

from tests.saved_graphs import saved_graph, saved_seams
from wpcal.brep.graph import CurveKind
from wpcal.brep.trim import TrimmedFaces
from wpcal.core.errors import WpcalError
from wpcal.seam.options import Judging, SeamOptions

ROOT = Path(__file__).parents[2]
ROOMS = ("brep", "seam/find", "seam/member", "seam/judge", "taught/features")
GRAPHS = (
    *(
        "gusseted-bracket",
        "bead-leaning-pipe",
        "hollow-corner",
        "bolted-plates",
        "drilled",
        "joint-tee-gap",
        "bent-sheet",
    ),
    *("bar-with-nut", "thick-tee-in-one", "slots-in-line", "saddle-60", "collar-on-tube", "zed", "counterbored-cap"),
    *("pockets", "rod-on-plate", "crossed-tee"),
)
GAP_MM = 0.5


def functions(rooms: tuple[str, ...] = ROOMS) -> Iterator[Callable[..., Any]]:
    """Yield the public functions of the rooms."""
    for path in sorted(path for room in rooms for path in (ROOT / "wpcal" / room).glob("*.py")):
        module = import_module(".".join(path.relative_to(ROOT).with_suffix("").parts))
        found = [each for each in vars(module).values() if isinstance(each, FunctionType)]
        yield from (each for each in found if each.__module__ == module.__name__ and not each.__name__.startswith("_"))


def given(name: str) -> Iterator[dict[str, Any]]:
    """Yield places on a graph by the names of parameters: of each two solids."""
    graph, rng = saved_graph(name), np.random.default_rng(7)
    kept, count = np.flatnonzero(graph.edge_kind != CurveKind.DEGENERATE), len(graph.solid_names)
    n = max(len(graph.face_kind), len(kept))
    faces, edges = np.arange(n) % len(graph.face_kind), kept[np.arange(n) % len(kept)]
    (first, last), rays = graph.edge_range[edges].T, rng.normal(size=(n, 3))
    points = rng.uniform(graph.vertex_p.min(axis=0), graph.vertex_p.max(axis=0), (n, 3))
    places = {
        "graph": graph, "trimmed": TrimmedFaces.of(graph), "self": TrimmedFaces.of(graph), "solids": np.arange(count),
        "faces": faces, "edges": edges,
        "edge": edges, "t": first + 0.37 * (last - first), "t0": first + 0.1 * (last - first), "points": points,
        "t1": first + 0.8 * (last - first), "gap_mm": GAP_MM, "within_mm": 5.0, "min_length_mm": 5.0,
        "uv": points[:, :2], "origins": points, "rays": rays / np.linalg.norm(rays, axis=1)[:, None],
        "length_mm": 300.0, "u": points[:, 0], "options": SeamOptions(), "judging": Judging(),
        "seams": saved_seams(name),
    }  # fmt: skip
    for one, other in product(range(min(count, 3)), range(count - 1, max(count - 3, -1), -1)):
        yield {**places, "solid": one, "ring": one, "other": other}


def asked(step: Callable[..., Any], known: dict[str, Any]) -> Any:
    try:
        with np.errstate(divide="ignore", invalid="ignore"):
            found = step(**{name: known[name] for name in inspect.signature(step).parameters if name in known})
            return list(found) if isinstance(found, Iterator) else found
    except (WpcalError, KeyError) as error:
        return str(error)


def needed(step: Callable[..., Any]) -> set[str]:
    given = inspect.signature(step).parameters.values()
    return {each.name for each in given if each.default is inspect.Parameter.empty}


KNOWN = {*next(given(GRAPHS[0]))}
OTHER_SHAPES = {
    "arc_length",
    "cumulative_length",
    "piece_counts_of",
    "add_edges",
    "are_inside",
    "graph_bytes",
    "find_held",
}
OF_FACES = (TrimmedFaces.contains, TrimmedFaces.boundary_distance, TrimmedFaces.nearest_pieces)
STEPS = [each for each in (*functions(), *OF_FACES) if needed(each) <= KNOWN and each.__name__ not in OTHER_SHAPES]


@pytest.mark.parametrize("name", GRAPHS)
def test_steps(name: str, golden: Any) -> None:
    of_solids = {"solid", "ring", "other"}
    first, *others = given(name)
    found = {f"{each.__module__}.{each.__name__}": [asked(each, first)] for each in STEPS}
    for each in (each for each in STEPS if needed(each) & of_solids):
        found[f"{each.__module__}.{each.__name__}"] += [asked(each, known) for known in others]
    golden(found)
