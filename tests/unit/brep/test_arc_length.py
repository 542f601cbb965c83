"""Parameters at arc lengths: the length to the parameter found is the length asked for."""

import numpy as np
import pytest

from tests.saved_graphs import saved_graph
from wpcal.brep.curves import cumulative_length, parameters_at_length
from wpcal.brep.graph import CurveKind


@pytest.mark.parametrize("name", ["saddle", "saddle-60", "cross-hole"])
@pytest.mark.parametrize("backwards", [False, True])
def test_the_length_to_the_parameter_is_the_length_asked_for(name: str, backwards: bool) -> None:
    graph, rng = saved_graph(name), np.random.default_rng(7)
    uneven = np.flatnonzero((graph.edge_kind == CurveKind.NURBS) | (graph.edge_kind == CurveKind.ELLIPSE))
    assert len(uneven), "the sample holds no curve with an uneven speed"
    for edge in uneven.tolist():
        t0, t1 = graph.edge_range[edge][:: -1 if backwards else 1]
        whole = abs(cumulative_length(graph, edge, np.array([t0, t1]))[-1])
        s = np.concatenate([[0.0, whole], rng.uniform(0.0, whole, 50)])
        t = parameters_at_length(graph, edge, t0, t1, s)
        assert np.abs(cumulative_length(graph, edge, np.concatenate([[t0], t]))[1:]) == pytest.approx(
            s, abs=1e-10 * whole
        )
        assert t[:2] == pytest.approx([t0, t1], abs=1e-12)
