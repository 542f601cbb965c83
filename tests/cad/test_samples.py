"""The sample parts and saved graphs as files: the same bytes in every run, and what the kernel gives."""

import subprocess
import sys
from dataclasses import fields
from itertools import chain
from pathlib import Path

import numpy as np
import pytest

from cad.samples.parts import SAMPLES
from cad.step.append_colors import with_solid_colors
from cad.step.new_file import new_step_text
from tests.samples.graphs import GRAPHS, build_graph
from tests.saved_graphs import GRAPHS as FOLDER
from tests.saved_graphs import saved_graph
from wpcal.brep import BrepGraph
from wpcal.brep.nurbs import NurbsCurve, NurbsSurface
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError

RUNS = 3
"""Processes whose files are compared. An order by address differs between most of them: six runs showed four orders of
the frame's rails."""

DIGESTS = """
import hashlib
from cad.samples.parts import SAMPLES
from cad.step.new_file import new_step_text
for name, sample in SAMPLES.items():
    print(name, hashlib.sha256(new_step_text(sample.build(), name)).hexdigest())
"""


@pytest.mark.deep
def test_samples_are_the_same_bytes_in_every_process() -> None:
    command = [sys.executable, "-c", DIGESTS]
    runs = {subprocess.run(command, capture_output=True, text=True, check=True).stdout for _ in range(RUNS)}
    assert len(runs) == 1
    assert next(iter(runs)).count("\n") == len(SAMPLES)


@pytest.mark.parametrize("name", SAMPLES)
def test_a_sample_is_read_back_with_the_names_and_colours_of_its_members(name: str, tmp_path: Path) -> None:
    from cad.kernel.xcaf import srgb
    from cad.step.read import read_step

    members = SAMPLES[name].build()
    path = tmp_path / "part.step"
    path.write_bytes(new_step_text(members, name))
    part = read_step(path)
    assert part.issues == ()
    assert [(solid.name, solid.color_rgb) for solid in part.solids] == [
        (member, srgb(rgb)) for member, _, rgb in members
    ]


def test_colours_and_solids_are_as_many() -> None:
    text = new_step_text(SAMPLES["lap"].build(), "lap")
    with pytest.raises(FormatError, match="a solid for each of 1 colours, found 2"):
        with_solid_colors(text, [(1.0, 0.0, 0.0)], name="lap")


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
