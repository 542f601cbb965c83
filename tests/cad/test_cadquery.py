"""Shapes of CadQuery are taken wherever shapes of build123d are.

CadQuery 2.8 needs another version of the kernel than wpcal and cannot be beside it (docs/how-to/scripting.md). So the
first tests use objects that have what CadQuery's have; the last one uses CadQuery where it can be imported.
"""

from collections.abc import Iterator
from typing import Any

import pytest

import cad
from wpcal.core.errors import InputError
from wpcal.seam import SeamOptions

TEE_SEAMS = 4


class CadQueryShape:
    """A shape as CadQuery wraps it."""

    __module__ = "cadquery.occ_impl.shapes"

    def __init__(self, wrapped: Any) -> None:
        self.wrapped = wrapped

    def ShapeType(self) -> str:  # CadQuery's name
        return "Solid"


class Place:
    """A location as CadQuery wraps it."""

    def __init__(self, *t_mm: float) -> None:
        from build123d import Location

        self.wrapped = Location(t_mm).wrapped


class Workplane:
    """What wpcal uses of a CadQuery `Workplane`."""

    def __init__(self, *objects: Any) -> None:
        self.objects = list(objects)

    def vals(self) -> list[Any]:
        return self.objects


class Assembly:
    """What wpcal uses of a CadQuery `Assembly`: it yields shapes with their names and places."""

    def __init__(self, *parts: tuple[Any, str, Place]) -> None:
        self.children = parts

    def toCompound(self) -> None:  # CadQuery's name
        raise AssertionError

    def __iter__(self) -> Iterator[tuple[Any, str, Place, None]]:
        for shape, name, place in self.children:
            yield shape, f"tee/{name}", place, None


@pytest.fixture(scope="module")
def plates() -> tuple[Any, Any]:
    from build123d import Box

    return Box(200, 120, 10), Box(150, 8, 80)


def test_an_assembly_is_the_same_shapes_at_their_places(plates: tuple[Any, Any]) -> None:
    from build123d import Pos

    plate, web = (CadQueryShape(each.wrapped) for each in plates)
    part = cad.open_workpiece(Assembly((plate, "plate", Place(100, 60, 5)), (web, "web", Place(100, 60, 50))))
    assert part.graph.solid_names == ("plate", "web")
    seams, _ = cad.find_seams(part, SeamOptions())
    placed = [Pos(100, 60, 5) * plates[0], Pos(100, 60, 50) * plates[1]]
    expected, _ = cad.find_seams(cad.open_workpiece(placed), SeamOptions())
    assert len(seams) == len(expected) == TEE_SEAMS
    for ours, theirs in zip(seams, expected, strict=True):
        assert ours.frames.p.tolist() == theirs.frames.p.tolist()


def test_workplanes_and_shapes_of_both_libraries_can_be_mixed(plates: tuple[Any, Any]) -> None:
    from build123d import Pos

    moved = (Pos(100, 60, 50) * plates[1]).wrapped
    vector = object()
    part = cad.open_workpiece([Pos(100, 60, 5) * plates[0], Workplane(vector, CadQueryShape(moved))])
    assert len(part.graph.solid_names) == 2
    found = [type(shape).__module__.partition(".")[0] for shape in part.shapes]
    assert found == ["build123d", "build123d"]


def test_shapes_are_opened_where_a_workpiece_is_expected(plates: tuple[Any, Any]) -> None:
    from build123d import Box, BuildPart, Edge, Pos

    with BuildPart() as built:
        Box(200, 120, 10)
    assert len(cad.find_seams([built, Pos(0, 0, 45) * plates[1]])[0]) == TEE_SEAMS
    with pytest.raises(InputError, match="expected shapes with solids, got Edge without one"):
        cad.open_workpiece([plates[0], Edge.make_line((0, 0, 0), (1, 1, 1))])
    with pytest.raises(InputError, match="got Vector"):
        cad.find_seams([plates[0], plates[0].center()])


@pytest.mark.parametrize("given", [7, None, {"a": 1}])
def test_what_is_no_shape_is_said(given: object) -> None:
    with pytest.raises(InputError, match="build123d or CadQuery"):
        cad.open_workpiece(given)


def test_cadquery_itself_where_it_is_installed() -> None:
    cadquery = pytest.importorskip("cadquery", reason="CadQuery is not installed for this kernel", exc_type=ImportError)
    web = cadquery.Workplane().box(150, 8, 80)
    assembly = cadquery.Assembly(name="tee").add(cadquery.Workplane().box(200, 120, 10), name="plate")
    assembly = assembly.add(web, name="web", loc=cadquery.Location((0, 0, 45)))
    part = cad.open_workpiece(assembly)
    assert part.graph.solid_names == ("plate", "web")
    assert len(cad.find_seams(part, SeamOptions())[0]) == TEE_SEAMS
