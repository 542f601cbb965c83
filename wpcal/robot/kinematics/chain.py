"""`MDHChain`: the links of a serial arm as Denavit-Hartenberg parameters with Hayati's fifth."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform

LINK_SYMBOLS = ("theta", "d", "a", "alpha", "beta")
"""Order of the link parameters wherever one array holds them: rows of `MDHChain.table`."""


@dataclass(frozen=True, slots=True, eq=False)
class MDHChain:
    """n revolute links between a base frame and a flange frame.

    Link i (Xiong 2015, eq. 1 and 2) is ``Rz(θ_i + offset_i) Tz(d_i) Tx(a_i) Rx(α_i) Ry(β_i)``. The flange is

    ``T_base_flange = T_base_dh0 · link 1 · … · link n · T_dhn_flange``.

    Raises `InputError` when lengths differ, a value is not finite, or the last link is marked parallel to a next one.
    """

    #: `theta`, `d`, `a`, `alpha`, `beta`: shape (n,). Offset of the joint angle (rad), distance along z (mm) and along
    #: x (mm), twist about x (rad), and Hayati's twist about y (rad).
    theta: FloatArray
    d: FloatArray
    a: FloatArray
    alpha: FloatArray
    beta: FloatArray
    #: length n. Whether the axis of the next joint is parallel to this one: then β is a parameter of the link and d is
    #: not.
    hayati: tuple[bool, ...]
    #: `T_base_dh0`, `T_dhn_flange`: From the base to the first axis, and from the last link to the flange (or tool);
    #: identity unless given.
    T_base_dh0: RigidTransform = field(default_factory=lambda: RigidTransform.identity(target="base", source="dh0"))
    T_dhn_flange: RigidTransform = field(default_factory=lambda: RigidTransform.identity(target="dhn", source="flange"))

    def __post_init__(self) -> None:
        for symbol in LINK_SYMBOLS:
            values = frozen(getattr(self, symbol))
            if values.shape != (len(self.hayati),):
                raise InputError(f"{symbol}: expected {len(self.hayati)} values, one a link, got shape {values.shape}")
            if not np.isfinite(values).all():
                raise InputError(f"{symbol}: a value is not finite: {values.tolist()}")
            object.__setattr__(self, symbol, values)
        object.__setattr__(self, "hayati", tuple(bool(flag) for flag in self.hayati))
        if not self.hayati:
            raise InputError("a chain needs at least one link")
        if self.hayati[-1]:
            raise InputError("the last link has no next axis that it could be parallel to")

    def __len__(self) -> int:
        return len(self.hayati)

    @property
    def table(self) -> FloatArray:
        """All link parameters, shape (5, n): rows in the order of `LINK_SYMBOLS`, mm and rad."""
        return np.stack([getattr(self, symbol) for symbol in LINK_SYMBOLS])

    def with_table(self, table: ArrayLike) -> MDHChain:
        """Return the same chain with other link parameters, shape (5, n) as in `table`."""
        rows = np.asarray(table, dtype=np.float64)
        if rows.shape != (len(LINK_SYMBOLS), len(self)):
            raise InputError(f"expected a table of shape (5, {len(self)}), got {rows.shape}")
        return replace(self, **dict(zip(LINK_SYMBOLS, rows, strict=True)))
