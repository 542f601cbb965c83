"""`Shape`: a rigid body for collision checks, as capsules and a hull."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError

BY_LENGTH = "(estimated)"  #: At the end of the name of a body that is estimated from the lengths of its arm.
JOINTS = 6  #: The closed-form inverse kinematics that both arms need has six joints.


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """A rigid body for collision checks: some capsules, and the hull around it.

    Raises `InputError` when shapes of arrays differ, a value is not finite or a radius is not positive.

    `hull`: shape (m, 3), optional. Corners of the convex body in the same frame, mm; empty if the body has capsules
    only.
    """

    name: str
    #: `p`, `q`: shape (k, 3). Ends of the capsules' axes in the frame of the body, mm; equal ends make a ball.
    p: FloatArray
    q: FloatArray
    radius_mm: FloatArray  #: shape (k,).
    #: For a body of an arm: the frame it moves with. 0 is the base, i the frame after link i of the chain, and 6 (the
    #: last) the flange. Bodies of the torch, the part and the bench are given in `tool`, `part` and `world`.
    link: int = 0
    hull: FloatArray = ()  # type: ignore[assignment]  # frozen in __post_init__
    #: For a body of the torch that works close to the part (the nozzle): its own safety distance to the part.
    to_part_mm: float | None = None

    def __post_init__(self) -> None:
        p, q, radius = frozen(self.p).reshape(-1, 3), frozen(self.q).reshape(-1, 3), frozen(self.radius_mm).reshape(-1)
        hull = frozen(self.hull).reshape(-1, 3)
        if not len(p) == len(q) == len(radius) >= 1:
            raise InputError(f"shape {self.name}: {len(p)} and {len(q)} ends of axes, {len(radius)} radii; one each")
        if not all(np.isfinite(values).all() for values in (p, q, radius, hull)):
            raise InputError(f"shape {self.name}: a value is not finite")
        if not (radius > 0).all():
            raise InputError(f"shape {self.name}: a radius must be positive, got {radius.min():g} mm")
        if not 0 <= self.link <= JOINTS:
            raise InputError(f"shape {self.name}: link is 0 (base) to {JOINTS} (flange), got {self.link}")
        for name, values in (("p", p), ("q", q), ("radius_mm", radius), ("hull", hull)):
            values.setflags(write=False)
            object.__setattr__(self, name, values)

    @property
    def box(self) -> tuple[FloatArray, FloatArray]:
        """Least and largest corner of the box around all of the body, in its own frame, shape (3,) each, mm."""
        r = self.radius_mm[:, None]
        low, high = np.minimum(self.p, self.q) - r, np.maximum(self.p, self.q) + r
        return np.concatenate([low, self.hull]).min(axis=0), np.concatenate([high, self.hull]).max(axis=0)


def corners_of_box(low: FloatArray, high: FloatArray) -> FloatArray:
    """Return the corners of a box, shape (8, 3)."""
    return np.array(np.meshgrid(*zip(low, high, strict=True))).reshape(3, -1).T
