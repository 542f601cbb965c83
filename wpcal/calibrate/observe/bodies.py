"""The bodies of a weldment, and how far tacks let each of them move."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from wpcal.calibrate.observe.bending import Bends
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.errors import InputError

LARGEST = 1e4  #: Of a tolerance in mm and mrad: it holds nothing any more, and a larger one costs digits.


@dataclass(frozen=True, slots=True)
class TackTolerance:
    """How far a tacked body is from its place in the model: standard deviations, the same along every axis.

    Raises `InputError` when a value is not positive, or not finite.
    """

    mm: float = 1.0  #: Of the centroid.
    mrad: float = 3.0  #: Of the turn about each axis through the centroid.

    def __post_init__(self) -> None:
        for name, value in (("mm", self.mm), ("mrad", self.mrad)):
            if not 0.0 < value < math.inf:
                raise InputError(f"the tack tolerance in {name} must be a positive number, got {value:g}")

    @property
    def scales(self) -> FloatArray:
        """Standard deviations of (ω, v), rad and mm, shape (6,)."""
        return np.repeat([min(self.mrad, LARGEST) * 1e-3, min(self.mm, LARGEST)], 3)


@dataclass(frozen=True, slots=True, eq=False)
class KeptContacts:
    """Points at which two bodies touch: a tacked plate stays on the face below it, within the gap of the joint."""

    p_part: FloatArray  #: shape (k, 3). In `part`, mm.
    normal_part: FloatArray  #: shape (k, 3). Unit normals of the contact, out of the first body.
    #: `first`, `second`: shape (k,). The two bodies.
    first: IntArray
    second: IntArray
    sigma_mm: FloatArray  #: shape (k,). Standard deviation of the gap.

    def __len__(self) -> int:
        return len(self.p_part)

    @classmethod
    def joined(cls, parts: Sequence[KeptContacts]) -> KeptContacts:
        """Return the contacts of all parts."""
        names = ("p_part", "normal_part", "first", "second", "sigma_mm")
        return cls(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))

    @classmethod
    def none(cls) -> KeptContacts:
        """No contact is kept."""
        empty = np.zeros((0, 3))
        return cls(empty, empty, np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0))


@dataclass(frozen=True, slots=True, eq=False)
class Bodies:
    """The b bodies that may move."""

    names: tuple[str, ...]
    centroid_part: FloatArray  #: shape (b, 3). The points about which they turn, in `part`, mm.
    tolerances: tuple[TackTolerance, ...]
    bends: Bends = field(default_factory=Bends.none)  #: How those of them bend that are long.

    def __post_init__(self) -> None:
        if not len(self.names) == len(self.centroid_part) == len(self.tolerances):
            raise InputError(
                f"{len(self.names)} bodies, {len(self.centroid_part)} centroids and {len(self.tolerances)} tolerances"
            )

    @classmethod
    def of_points(cls, p_part: FloatArray, body: Sequence[str], tolerance: TackTolerance) -> tuple[Bodies, IntArray]:
        """Return the bodies that points, shape (n, 3), lie on, in the order of their names, and the body of each point.

        A body turns about the middle of its points.
        """
        names = tuple(dict.fromkeys(body))
        own = np.array([names.index(each) for each in body], dtype=np.int64)
        boxes = [p_part[own == b] for b in range(len(names))]
        middle = np.stack([(each.min(axis=0) + each.max(axis=0)) / 2.0 for each in boxes])
        return cls(names, middle, (tolerance,) * len(names)), own

    def __len__(self) -> int:
        return len(self.names)

    @property
    def scales(self) -> FloatArray:
        """Standard deviations of the motions (ω, v) of all bodies, rad and mm, shape (b, 6)."""
        return np.stack([tolerance.scales for tolerance in self.tolerances])

    @property
    def all_scales(self) -> FloatArray:
        """Standard deviations of the motions and of the k amplitudes of bending, shape (6 b + k,)."""
        return np.concatenate([self.scales.ravel(), self.bends.scales])

    def scaled(self, turn: float, shift: float) -> Bodies:
        """Return the bodies with tolerances multiplied by these factors: turns by the first, shifts by the second."""
        tolerances = tuple(TackTolerance(t.mm * shift, t.mrad * turn) for t in self.tolerances)
        return replace(self, tolerances=tolerances)
