"""Graphs as files: what is read is what was written, the bytes are the same every time, other files are refused."""

import io
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from tests.saved_graphs import saved_graph
from wpcal.brep import BrepGraph
from wpcal.brep.graph_file import COLUMNS, graph_bytes, read_graph
from wpcal.brep.nurbs import NurbsCurve, NurbsSurface
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError


def with_splines() -> BrepGraph:
    """The T-joint with two curves and two surfaces of different sizes, and names outside ASCII."""

    def ramp(*shape: int) -> FloatArray:
        return np.arange(float(np.prod(shape))).reshape(shape) / 7

    curves = (NurbsCurve(3, ramp(8), ramp(4, 3), ramp(4) + 1), NurbsCurve(1, ramp(5), ramp(3, 3), ramp(3) + 1))
    surfaces = (
        NurbsSurface((3, 2), ramp(8), ramp(7), ramp(4, 4, 3), ramp(4, 4), (0.0, 1.0, 0.25, 0.5)),
        NurbsSurface((1, 1), ramp(4), ramp(5), ramp(2, 3, 3), ramp(2, 3), (0.0, 2.0, 0.0, 3.0)),
    )
    return replace(
        saved_graph("tee"), solid_names=("Grundplatte ä", "Steg"), nurbs_curves=curves, nurbs_surfaces=surfaces
    )


def test_what_is_read_is_what_was_written(tmp_path: Path) -> None:
    graph = with_splines()
    (tmp_path / "part.npz").write_bytes(graph_bytes(graph))
    found = read_graph(tmp_path / "part.npz")
    assert found.solid_names == graph.solid_names
    for name in COLUMNS:
        column = getattr(found, name)
        assert column.dtype == getattr(graph, name).dtype
        np.testing.assert_array_equal(column, getattr(graph, name))
    splines = (*graph.nurbs_curves, *graph.nurbs_surfaces)
    for mine, other in zip((*found.nurbs_curves, *found.nurbs_surfaces), splines, strict=True):
        assert type(mine) is type(other)
        for field in fields(mine):
            np.testing.assert_array_equal(getattr(mine, field.name), getattr(other, field.name))


def test_the_same_graph_gives_the_same_bytes(tmp_path: Path) -> None:
    content = graph_bytes(with_splines())
    (tmp_path / "part.npz").write_bytes(content)
    assert graph_bytes(read_graph(tmp_path / "part.npz")) == content


def archive(**arrays: object) -> bytes:
    file = io.BytesIO()
    np.savez(file, **arrays)
    return file.getvalue()


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"ISO-10303-21;", "is not a saved graph"),
        (b"", "is not a saved graph"),
        (graph_bytes(saved_graph("sharp-box"))[:-2000], "is not a saved graph"),
        (archive(format=np.array([{}], dtype=object)), "is not a saved graph"),
        (archive(points=np.zeros(3)), "expected the format 'wpcal graph 1', found 'no format'"),
        (archive(format=np.array("wpcal graph 2")), "found 'wpcal graph 2'"),
        (archive(format=np.array("wpcal graph 1")), "the array 'solid_names' is missing"),
    ],
)
def test_another_file_is_refused(content: bytes, message: str, tmp_path: Path) -> None:
    path = tmp_path / "part.npz"
    path.write_bytes(content)
    with pytest.raises(FormatError, match=message) as caught:
        read_graph(path)
    assert str(path) in str(caught.value)


def test_a_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.npz"):
        read_graph(tmp_path / "none.npz")
