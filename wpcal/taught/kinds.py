"""The kinds of taught rows: the words of the column `kind`, and what each word allows.

To add a kind of row, add one entry to `TouchKind`. Its target must be one of `TargetKind`; for a new sort of target,
add the class that measures distances to it in `wpcal.calibrate.observe.targets`.
"""

from __future__ import annotations

from enum import Enum
from typing import Self

from wpcal.brep.graph import SurfaceKind
from wpcal.calibrate.observe.targets import TargetKind


class TouchKind(Enum):
    """What a row was touched on.

    `value`: The word in the file.
    `target`: What the fit measures the distance to.
    `surfaces`: Of the faces that are meant; empty for points and edges.
    `is_inside`: Whether only the inner wall of such a surface is meant.
    """

    POINT = "point", TargetKind.POINT  #: A corner or the centre of a hole: the tip was at the feature itself.
    PLANE = "plane", TargetKind.FACE, (SurfaceKind.PLANE,)
    EDGE = "edge", TargetKind.EDGE
    HOLE = "hole", TargetKind.FACE, (SurfaceKind.CYLINDER,), True
    """The wall of a hole; three or more touches give its axis."""
    CYLINDER = "cylinder", TargetKind.FACE, (SurfaceKind.CYLINDER,)
    SPHERE = "sphere", TargetKind.FACE, (SurfaceKind.SPHERE,)
    SURFACE = "surface", TargetKind.FACE, tuple(kind for kind in SurfaceKind if kind is not SurfaceKind.NONE)
    """Any face, also a free-form one."""

    target: TargetKind
    surfaces: tuple[SurfaceKind, ...]
    is_inside: bool

    def __new__(
        cls, word: str, target: TargetKind, surfaces: tuple[SurfaceKind, ...] = (), is_inside: bool = False
    ) -> Self:
        """Make a kind from its word in the file and its attributes."""
        kind = object.__new__(cls)
        kind._value_, kind.target, kind.surfaces, kind.is_inside = word, target, surfaces, is_inside
        return kind

    @property
    def takes_radius(self) -> bool:
        """Whether the row may have been touched with a ball.

        At a corner or on an edge, where the centre of the ball is depends on the angle of the faces.
        """
        return self.target is TargetKind.FACE


KINDS = {kind.value: kind for kind in TouchKind}
"""The kinds by their words in the column `kind`; an empty cell means the first."""
