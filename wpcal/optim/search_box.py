"""The box in which annealing searches; some of its variables are full turns."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import BoolArray, FloatArray, frozen
from wpcal.core.errors import InputError


@dataclass(frozen=True, slots=True, eq=False)
class SearchBox:
    """The box of states that a search may visit."""

    #: `lower`, `upper`: shape (d,).
    lower: FloatArray
    upper: FloatArray
    periodic: BoolArray  #: shape (d,). Variables that leave the box at one side and enter at the other: full turns.

    @classmethod
    def of(cls, lower: ArrayLike, upper: ArrayLike, periodic: ArrayLike | None = None) -> SearchBox:
        """Return a box; shape (d,) each. Raises `InputError` when it is empty or not finite."""
        low, high = frozen(lower), frozen(upper)
        if low.ndim != 1 or low.shape != high.shape or not (np.isfinite(low) & np.isfinite(high) & (low < high)).all():
            raise InputError(f"expected a box of finite bounds with lower < upper, got {low} and {high}")
        wraps = np.zeros(low.shape, dtype=bool) if periodic is None else np.array(periodic, dtype=bool)
        return cls(low, high, wraps)

    @property
    def width(self) -> FloatArray:
        """Upper minus lower bounds, shape (d,)."""
        return np.asarray(self.upper - self.lower, dtype=np.float64)

    @property
    def walls(self) -> tuple[FloatArray, FloatArray]:
        """Bounds that states stop at, shape (d,) each: none for periodic variables."""
        return np.where(self.periodic, -np.inf, self.lower), np.where(self.periodic, np.inf, self.upper)

    def wrapped(self, states: FloatArray) -> FloatArray:
        """States, shape (m, d), whose periodic variables are back in the box."""
        turned = self.lower + np.mod(states - self.lower, self.width)
        return np.where(self.periodic, turned, states)
