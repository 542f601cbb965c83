"""Parts whose faces do not fit their edges, as a damaged file gives them: no NaN, no warning, wpcal's own errors."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from tests.saved_graphs import saved_graph
from wpcal.brep import BrepGraph, CurveKind
from wpcal.brep.extent import require_finite
from wpcal.core.errors import GeometryError, InputError
from wpcal.seam import SeamOptions, detect_seams
from wpcal.seam.path.discretise import speeds


def exchanged(graph: BrepGraph, one: int, other: int) -> BrepGraph:
    """Two faces with each other's surface."""
    frame = graph.face_frame.copy()
    frame[[one, other]] = frame[[other, one]]
    return replace(graph, face_frame=frame)


@pytest.mark.deep
def test_faces_with_exchanged_surfaces_give_finite_frames_or_an_error_of_ours() -> None:
    graph = saved_graph("joint-tee")
    for one, other in list(combinations(range(graph.face_count), 2))[::3]:
        try:
            seams = detect_seams(exchanged(graph, one, other), SeamOptions())
        except InputError:
            continue
        for seam in seams:
            assert np.isfinite(seam.frames.p).all()
            assert np.isfinite(seam.frames.R).all()


def test_a_length_per_parameter_is_above_zero_on_every_curve() -> None:
    graph = saved_graph("saddle")
    edges = np.flatnonzero(graph.edge_kind != CurveKind.DEGENERATE)
    assert (graph.edge_kind[edges] == CurveKind.NURBS).any()
    assert (speeds(graph, edges) > 0).all()


@pytest.mark.parametrize("wrong", [np.inf, np.nan, -1e200, 1.1e9])
@pytest.mark.parametrize("array", ["face_frame", "face_param", "edge_frame", "edge_param", "edge_range", "vertex_p"])
def test_geometry_at_infinity_is_refused_with_the_solid(array: str, wrong: float) -> None:
    graph = saved_graph("saddle")
    require_finite(graph)
    values = getattr(graph, array).copy()
    row = int(np.flatnonzero(graph.edge_kind == CurveKind.LINE)[0]) if array.startswith("edge") else 0
    values[row].flat[-1] = wrong
    with pytest.raises(
        GeometryError, match=rf"geometry in ({'|'.join(graph.solid_names)}) is infinite or farther away"
    ):
        require_finite(replace(graph, **{array: values}))


def test_poles_at_infinity_are_refused() -> None:
    graph = saved_graph("saddle")
    curve = graph.nurbs_curves[0]
    poles = curve.poles.copy()
    poles[1, 2] = np.nan
    with pytest.raises(GeometryError, match="is infinite or farther away"):
        require_finite(replace(graph, nurbs_curves=(replace(curve, poles=poles), *graph.nurbs_curves[1:])))
    (surface,) = saved_graph("bead-leaning-pipe").nurbs_surfaces
    with pytest.raises(GeometryError, match="is infinite or farther away"):
        require_finite(
            replace(saved_graph("bead-leaning-pipe"), nurbs_surfaces=(replace(surface, poles=1e300 * surface.poles),))
        )
