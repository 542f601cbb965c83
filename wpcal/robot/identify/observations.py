"""`PoseObservations`: where the tool really was, measured, for joint angles that the controller showed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, IntArray, as_points, frozen
from wpcal.core.errors import InputError


@dataclass(frozen=True, slots=True, eq=False)
class PoseObservations:
    """N measurements: joint angles, a measured position, and where the tracker gives it an orientation.

    Raises `InputError` when shapes differ, a value is not finite, or orientations come with more than one reflector.
    """

    joints: FloatArray  #: shape (N, n). Joint angles as the controller shows them, rad.
    #: shape (N, 3). Measured positions of the flange (or tool, or reflector), mm, in the frame of the measurement.
    p_base: FloatArray
    R_base_flange: FloatArray | None = None  #: shape (N, 3, 3). Measured orientations.
    reflectors: tuple[str, ...] = ("",)  #: Names of the reflectors on the tool; one, unnamed, when there is only one.
    #: shape (N,). Which reflector each row saw, an index into `reflectors`; the first unless given.
    reflector: IntArray = field(default_factory=lambda: np.zeros(0, np.int64))
    rows: tuple[int, ...] = ()  #: Line number of each measurement in its file, for messages.
    #: shape (N,). Weight of each measurement's squared residuals, 0 to 1; one unless given.
    weights: FloatArray = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        joints, p_base = frozen(self.joints), as_points(self.p_base, name="measured positions")
        if joints.ndim != 2 or len(joints) != len(p_base):
            raise InputError(f"{len(p_base)} positions, but joint angles of shape {joints.shape}")
        if not np.isfinite(joints).all():
            raise InputError("joint angles: a value is not finite")
        if self.R_base_flange is not None and np.shape(self.R_base_flange) != (len(joints), 3, 3):
            raise InputError(f"expected orientations of shape ({len(joints)}, 3, 3)")
        if self.R_base_flange is not None and len(self.reflectors) > 1:
            raise InputError("orientations belong to the tool; with several reflectors give positions only")
        index = np.zeros(len(joints), np.int64) if np.size(self.reflector) == 0 else np.array(self.reflector, np.int64)
        if index.shape != (len(joints),) or not np.isin(index, range(len(self.reflectors))).all():
            raise InputError(f"expected {len(joints)} reflector numbers below {len(self.reflectors)}")
        index.setflags(write=False)
        weights = np.ones(len(joints)) if np.size(self.weights) == 0 else np.array(self.weights, np.float64)
        if weights.shape != (len(joints),) or not ((weights >= 0) & (weights <= 1)).all():
            raise InputError(f"expected {len(joints)} weights between 0 and 1")
        R, rows = self.R_base_flange, tuple(self.rows) or tuple(range(1, len(joints) + 1))
        ours = (joints, p_base, R if R is None else frozen(R), self.reflectors, index, rows, frozen(weights))
        for each, value in zip(fields(self), ours, strict=True):
            object.__setattr__(self, each.name, value)

    def __len__(self) -> int:
        return len(self.joints)

    @property
    def has_orientations(self) -> bool:
        """Whether full poses were measured."""
        return self.R_base_flange is not None

    @property
    def equations(self) -> int:
        """The count of measured numbers: six per full pose, three per position."""
        return int(np.count_nonzero(self.weights)) * (6 if self.has_orientations else 3)

    @property
    def poses(self) -> IntArray:
        """Number of the pose of each row, shape (N,): rows with equal joint angles are one pose, seen by reflectors."""
        return np.asarray(np.unique(self.joints, axis=0, return_inverse=True)[1], dtype=np.int64).ravel()

    def weighted(self, weights: ArrayLike) -> PoseObservations:
        """Return the same measurements with other weights. `weights`: array_like, shape (N,)."""
        return replace(self, weights=np.asarray(weights, dtype=np.float64))

    def select(self, indices: Sequence[int] | ArrayLike) -> PoseObservations:
        """Return some of the measurements. `indices`: shape (k,). Rows, in the order wanted."""
        i = np.asarray(indices, dtype=np.int64)
        R = None if self.R_base_flange is None else self.R_base_flange[i]
        rows, reflector = tuple(self.rows[k] for k in i), self.reflector[i]
        return PoseObservations(self.joints[i], self.p_base[i], R, self.reflectors, reflector, rows, self.weights[i])
