"""`RigidTransform`: a rotation and a translation with the names of the two frames they join."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import FrameError, InputError
from wpcal.core.rotations import rotation_from_zyx, zyx_from_rotation
from wpcal.core.same_bits import product
from wpcal.core.tangent import log_rotation

LARGEST_OF_ROTATION = 2.0
"""No number of a rotation is larger than 1; far above this, the square of a wrong one would overflow."""
ORTHONORMAL_ATOL = 1e-6
"""A matrix from a file (six printed digits) may differ this much from a rotation; an SVD then makes it exact."""


@dataclass(frozen=True, slots=True)
class SixTuple:
    """The six variables of a rigid motion in Yin 2003, §1: translation in mm and Z-Y-X angles in rad."""

    x_mm: float
    y_mm: float
    z_mm: float
    alpha_rad: float
    beta_rad: float
    gamma_rad: float

    def to_record(self) -> dict[str, float]:
        """Return plain values for a JSON file."""
        return asdict(self)


@dataclass(frozen=True, slots=True, eq=False)
class RigidTransform:
    """``T_target_source``: carries points from the frame `source` to the frame `target`.

    Raises `InputError` when R is not a rotation within 1e-6, or a value is not finite.

    >>> T_base_part = RigidTransform(np.eye(3), [100, 0, 0], target="base", source="part")
    >>> T_base_part.apply([[1, 2, 3]]).tolist()
    [[101.0, 2.0, 3.0]]
    """

    R: FloatArray  #: shape (3, 3). Rotation, determinant +1.
    t_mm: FloatArray  #: shape (3,). Origin of `source` in `target`, mm.
    #: `target`, `source`: Frame names.
    target: str
    source: str

    def __post_init__(self) -> None:
        R, t = frozen(self.R), frozen(self.t_mm)
        if R.shape != (3, 3) or t.shape != (3,):
            raise InputError(f"expected a rotation (3, 3) and a translation (3,), got {R.shape} and {t.shape}")
        if not (np.isfinite(R).all() and np.isfinite(t).all()):
            raise InputError(f"T_{self.target}_{self.source} holds a value that is not finite")
        if np.abs(R).max() > LARGEST_OF_ROTATION:  # its square could overflow
            what = f"holds {np.abs(R).max():.3g}, and no rotation holds more than 1"
            raise InputError(f"T_{self.target}_{self.source} is not a rigid motion: R {what}")
        off = float(np.abs(R @ R.T - np.eye(3)).max())
        if off > ORTHONORMAL_ATOL or np.linalg.det(R) < 0:
            what = f"R Rᵀ is off the identity by {off:.3g}, det R = {np.linalg.det(R):.3g}"
            raise InputError(f"T_{self.target}_{self.source} is not a rigid motion: {what}")
        object.__setattr__(self, "R", R)
        object.__setattr__(self, "t_mm", t)

    @classmethod
    def identity(cls, *, target: str, source: str) -> RigidTransform:
        """Return the transform between two frames that coincide."""
        return cls(np.eye(3), np.zeros(3), target, source)

    @classmethod
    def from_matrix(cls, matrix: ArrayLike, *, target: str, source: str) -> RigidTransform:
        """Build from a homogeneous matrix. A rotation that is off by rounding is made exact.

        `matrix`: shape (4, 4). Rotation, and translation in mm.
        `target`, `source`: Frame names.
        Raises `InputError` when the matrix is not 4×4, its last row is not 0 0 0 1, or its rotation is off by more than
        1e-6.
        """
        try:
            m = np.asarray(matrix)
        except (TypeError, ValueError):
            raise InputError("expected a 4×4 matrix of numbers") from None
        if m.dtype.kind not in "iuf":  # NumPy would also take texts
            raise InputError("expected a 4×4 matrix of numbers")
        m = m.astype(np.float64)
        if m.shape != (4, 4):
            raise InputError(f"expected a 4×4 matrix, got shape {m.shape}")
        if not np.allclose(m[3], (0, 0, 0, 1), rtol=0, atol=ORTHONORMAL_ATOL):
            raise InputError(f"the last row of a pose is 0 0 0 1, got {m[3].tolist()}")
        cls(m[:3, :3], m[:3, 3], target, source)  # refuses what is not a rotation, before the steps make it one
        R = m[:3, :3]
        for _ in range(2):  # Newton's steps to the nearest rotation: 1e-6 off, then 1e-12, then round-off
            R = 1.5 * R - 0.5 * product(R, product(R.T, R))
        return cls(R, m[:3, 3], target, source)

    @classmethod
    def from_six_tuple(cls, values: ArrayLike, *, target: str, source: str) -> RigidTransform:
        """Build from six variables with ``R = Rz(γ) Ry(β) Rx(α)``.

        `values`: shape (6,). x, y, z in mm and α, β, γ in rad.
        `target`, `source`: Frame names.
        Raises `InputError` when there are not six numbers.
        """
        v = np.asarray(values, dtype=np.float64)
        if v.shape != (6,):
            raise InputError(f"expected six numbers x, y, z, alpha, beta, gamma, got shape {v.shape}")
        return cls(rotation_from_zyx(v[3], v[4], v[5]), v[:3], target, source)

    @classmethod
    def from_record(cls, record: Mapping[str, Any], *, target: str, source: str) -> RigidTransform:
        """Build from the fields ``xyz_mm`` and ``rpy_deg`` of a file, ``R = Rz(yaw) Ry(pitch) Rx(roll)``.

        Raises `InputError` when a field does not hold three numbers.
        Raises `KeyError` when a field is missing.
        """
        xyz, rpy = (np.asarray(record[field], dtype=np.float64) for field in ("xyz_mm", "rpy_deg"))
        if xyz.shape != (3,) or rpy.shape != (3,):
            raise InputError(f"T_{target}_{source}: expected three numbers in xyz_mm and in rpy_deg")
        return cls(rotation_from_zyx(*np.deg2rad(rpy)), xyz, target, source)

    def to_record(self) -> dict[str, list[float]]:
        """Return ``xyz_mm`` and ``rpy_deg``; `from_record` reads them back to round-off."""
        angles = np.rad2deg(zyx_from_rotation(self.R))
        return {"xyz_mm": self.t_mm.tolist(), "rpy_deg": [float(angle) for angle in angles]}

    @property
    def matrix(self) -> FloatArray:
        """Homogeneous matrix, shape (4, 4), mm."""
        m = np.eye(4)
        m[:3, :3], m[:3, 3] = self.R, self.t_mm
        return m

    @property
    def six_tuple(self) -> SixTuple:
        """The six-tuple (x, y, z, α, β, γ) of Yin 2003."""
        x, y, z = (float(v) for v in self.t_mm)
        return SixTuple(x, y, z, *zyx_from_rotation(self.R))

    def apply(self, points: ArrayLike) -> FloatArray:
        """Carry points from `source` to `target`, shape (..., 3). The same points in `target`, mm.

        `points`: shape (..., 3). Points in `source`, mm.
        """
        return np.asarray(product(points, self.R.T) + self.t_mm, dtype=np.float64)

    def rotate(self, directions: ArrayLike) -> FloatArray:
        """Carry directions (no translation) from `source` to `target`, shape (..., 3). In `target`.

        `directions`: shape (..., 3). In `source`.
        """
        return product(directions, self.R.T)

    def relabelled(self, *, target: str, source: str) -> RigidTransform:
        """Return the same motion between frames of other names.

        Some results have general frame names, such as `part` and `base` of a calibration; the caller may know the
        frames by other names. Nothing is computed, and nothing checks that the new names are right.

        >>> RigidTransform.identity(target="base", source="part").relabelled(target="base1", source="base2").source
        'base2'
        """
        return RigidTransform(self.R, self.t_mm, target, source)

    def inverse(self) -> RigidTransform:
        """Return ``T_source_target``."""
        return RigidTransform(self.R.T, -product(self.R.T, self.t_mm), self.source, self.target)

    def __matmul__(self, other: RigidTransform) -> RigidTransform:
        if self.source != other.target:
            raise FrameError(
                f"T_{self.target}_{self.source} @ T_{other.target}_{other.source}: the inner frames must be the same, "
                f"got {self.source!r} and {other.target!r}"
            )
        return RigidTransform(
            product(self.R, other.R), product(self.R, other.t_mm) + self.t_mm, self.target, other.source
        )

    def is_close(self, other: RigidTransform, *, atol_mm: float, atol_rad: float) -> bool:
        """Tell whether the frame names are equal, the origins within `atol_mm` and the rotations within `atol_rad`."""
        return (
            (self.target, self.source) == (other.target, other.source)
            and float(np.linalg.norm(self.t_mm - other.t_mm)) <= atol_mm
            and float(np.linalg.norm(log_rotation(self.R.T @ other.R))) <= atol_rad
        )
