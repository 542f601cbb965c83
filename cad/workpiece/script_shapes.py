"""Shapes of scripts: build123d's as they are, CadQuery's as shapes of build123d.

CadQuery is recognised by what its objects have, so that nothing of it is imported here. Both libraries wrap shapes of
the same kernel (OCP) in an attribute ``wrapped``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any, Protocol, TypeAlias

from wpcal.core.errors import InputError

_CADQUERY = "cadquery"


class ScriptShape(Protocol):
    """A shape of build123d or CadQuery."""

    wrapped: Any  #: The kernel's shape.


class BuildPart(Protocol):
    """A builder of build123d."""

    part: Any


class CadQuery(Protocol):
    """A `Workplane` or an `Assembly`."""

    objects: Any


ScriptShapes: TypeAlias = ScriptShape | BuildPart | CadQuery | Iterable[ScriptShape]


def script_shapes(given: ScriptShapes) -> tuple[Any, ...]:
    """Return shapes of build123d. Those of build123d unchanged; those of an assembly at their places.

    `given`: The label of a shape, or its name in an assembly, becomes the name of its solid.
    Raises `InputError` when something else is given.
    """
    return tuple(_shapes_of(given))


def _shapes_of(given: Any) -> Iterator[Any]:
    if hasattr(getattr(given, "wrapped", None), "ShapeType"):  # a vector wraps something else, an empty shape nothing
        yield _to_build123d(given.wrapped, str(getattr(given, "label", "") or "")) if _is_cadquery(given) else given
    elif hasattr(given, "toCompound") and hasattr(given, "children"):  # a CadQuery Assembly
        for shape, name, place, *_ in given:
            yield _to_build123d(shape.wrapped.Moved(place.wrapped), name.rpartition("/")[2])
    elif hasattr(given, "vals") and hasattr(given, "objects"):  # a CadQuery Workplane
        for shape in given.vals():
            if hasattr(shape, "ShapeType"):  # a vector on the stack is not a shape
                yield from _shapes_of(shape)
    elif type(given).__name__ == "BuildPart":
        yield from _shapes_of(given.part)
    elif isinstance(given, Iterable) and not isinstance(given, dict | str) and not hasattr(given, "wrapped"):
        for each in given:
            yield from _shapes_of(each)
    else:
        raise InputError(f"expected shapes of build123d or CadQuery, got {type(given).__name__}")


def _is_cadquery(shape: Any) -> bool:
    return any(kind.__module__.partition(".")[0] == _CADQUERY for kind in type(shape).__mro__)


def _to_build123d(wrapped: Any, label: str) -> Any:
    from build123d import Compound

    shape = Compound.cast(wrapped)
    shape.label = label
    return shape
