"""The shapes of a calibrated part where they are, for scripts of build123d."""

from __future__ import annotations

from typing import Any

import numpy as np

from cad.workpiece.workpiece import Workpiece, labelled_solids
from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform


def moved_shapes(workpiece: Workpiece, T_base_part: RigidTransform, T_part_moved: FloatArray | None) -> list[Any]:
    """Return the shapes of a part in `base`.

    `T_part_moved`: shape (solids, 4, 4). Where each solid moved within `part`, mm; None: they did not.

    Returns: One for each shape of a script, of the same class, or one for each solid of a file. A shape whose solids
    moved differently is a compound with one child for each solid.
    """
    shapes = workpiece.shapes or workpiece.file.step.build123d_shapes()
    if T_part_moved is None:
        return [shape.moved(_location(T_base_part.matrix)) for shape in shapes]
    counts = [len(labelled_solids(shape)) for shape in shapes] if workpiece.shapes else [1] * len(shapes)
    each = np.split(T_base_part.matrix @ T_part_moved, np.cumsum(counts)[:-1])
    return [_moved(shape, T_base_moved) for shape, T_base_moved in zip(shapes, each, strict=True)]


def _moved(shape: Any, T_base_moved: FloatArray) -> Any:
    """Return a shape with its k-th solid at `T_base_moved[k]`, shape (solids, 4, 4), mm."""
    from build123d import Compound, Shape

    if (T_base_moved == T_base_moved[:1]).all():
        return shape.moved(_location(T_base_moved[0]))
    children = []
    for (label, solid), T in zip(labelled_solids(shape), T_base_moved, strict=True):
        child = Shape.cast(solid).moved(_location(T))
        child.label = label
        children.append(child)
    return Compound(label=shape.label, children=children)


def _location(matrix: FloatArray) -> Any:
    from build123d import Location

    from cad.kernel.geometry import to_location

    return Location(to_location(RigidTransform.from_matrix(matrix, target="base", source="part")))
