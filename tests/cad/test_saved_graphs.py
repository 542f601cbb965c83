"""The saved graphs are those of the parts: what the tests without a kernel read is what the kernel gives."""

from dataclasses import fields
from itertools import chain
from pathlib import Path

import numpy as np
import pytest

from tests.samples.graphs import GRAPHS, build_graph
from tests.saved_graphs import GRAPHS as FOLDER
from tests.saved_graphs import saved_graph
from wpcal.brep import BrepGraph
from wpcal.brep.nurbs import NurbsCurve, NurbsSurface
from wpcal.core.arrays import FloatArray

KERNEL_MM = 1e-7  #: The kernel computes intersection curves to this tolerance; all other numbers agree to round-off.


@pytest.mark.parametrize("name", list(GRAPHS))
def test_a_saved_graph_equals_the_fresh_one(name: str) -> None:
    saved, fresh = saved_graph(name), build_graph(name)
    assert saved.solid_names == fresh.solid_names
    assert list(map(sizes, splines(saved))) == list(map(sizes, splines(fresh)))
    for field in fields(BrepGraph):
        column = getattr(fresh, field.name)
        if isinstance(column, np.ndarray):
            found = getattr(saved, field.name)
            assert found.dtype == column.dtype
            np.testing.assert_allclose(found, column, rtol=0, atol=KERNEL_MM, err_msg=field.name)
    for one, other in zip(splines(saved), splines(fresh), strict=True):
        for a, b in zip(numbers(one), numbers(other), strict=True):
            np.testing.assert_allclose(a, b, rtol=0, atol=KERNEL_MM)


def splines(graph: BrepGraph) -> list[NurbsCurve | NurbsSurface]:
    return list(chain(graph.nurbs_curves, graph.nurbs_surfaces))


def sizes(spline: NurbsCurve | NurbsSurface) -> tuple[object, ...]:
    degrees = spline.degree if isinstance(spline, NurbsCurve) else spline.degrees
    return (degrees, *(np.shape(values) for values in numbers(spline)))


def numbers(spline: NurbsCurve | NurbsSurface) -> list[FloatArray]:
    if isinstance(spline, NurbsCurve):
        return [spline.knots, spline.poles, spline.weights]
    return [spline.knots_u, spline.knots_v, spline.poles, spline.weights, np.array(spline.bounds)]


def test_every_saved_graph_has_its_part() -> None:
    assert {path.stem for path in Path(FOLDER).iterdir()} == set(GRAPHS)
