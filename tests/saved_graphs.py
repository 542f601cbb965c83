"""The saved graphs in fixtures/graphs, for tests that need no CAD kernel; `tests.samples.graphs` makes them."""

from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from tests.kept import kept
from wpcal.brep import BrepGraph
from wpcal.brep.graph_file import read_graph
from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform
from wpcal.seam import Seam, SeamOptions, detect_seams

GRAPHS = Path(__file__).parents[1] / "fixtures" / "graphs"


@cache
def saved_graph(name: str) -> BrepGraph:
    """Return a saved graph, read once in a process."""
    return read_graph(GRAPHS / f"{name}.npz")


def saved_seams(name: str, options: SeamOptions | None = None) -> tuple[Seam, ...]:
    """Return the seams of a saved graph, found once in a run."""
    options = options or SeamOptions()
    return kept(f"seams of {name}: {options}", lambda: detect_seams(saved_graph(name), options))


def moved(graph: BrepGraph, T: RigidTransform) -> BrepGraph:
    """Move every point and direction of a graph; done here, with no code of wpcal that knows about shapes."""

    def frames(rows: FloatArray) -> FloatArray:
        return np.concatenate([T.apply(rows[:, 0])[:, None], rows[:, 1:] @ T.R.T], axis=1)

    return replace(
        graph,
        face_frame=frames(graph.face_frame),
        edge_frame=frames(graph.edge_frame),
        vertex_p=T.apply(graph.vertex_p),
        nurbs_surfaces=tuple(replace(surface, poles=T.apply(surface.poles)) for surface in graph.nurbs_surfaces),
        nurbs_curves=tuple(replace(curve, poles=T.apply(curve.poles)) for curve in graph.nurbs_curves),
    )
