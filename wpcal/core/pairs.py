"""Point pairs: the same points in two frames, and their distances after a fit."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, as_points, frozen
from wpcal.core.errors import InputError
from wpcal.core.robot_space import RobotSpace
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed


@dataclass(frozen=True, slots=True, eq=False)
class PointPairs:
    """n named points, each known in a source frame (the CAD model) and in a target frame (the robot's base).

    Raises `InputError` when shapes differ, a value is not finite, or a name appears twice.
    """

    names: tuple[str, ...]  #: length n. Unique.
    #: `p_source`, `p_target`: shape (n, 3). The points in the two frames, mm.
    p_source: FloatArray
    p_target: FloatArray
    covariances: FloatArray | None = None  #: shape (n, 3, 3). Covariance of each taught point in the target frame, mm².
    #: `source`, `target`: Frame names.
    source: str = "part"
    target: str = "base"
    space: RobotSpace = RobotSpace.NOMINAL  #: The robot model with which the target points were computed.

    def __post_init__(self) -> None:
        names = tuple(str(name) for name in self.names)
        p_source = as_points(self.p_source, name="source points")
        p_target = as_points(self.p_target, name="target points")
        if not len(names) == len(p_source) == len(p_target):
            raise InputError(f"{len(names)} names, {len(p_source)} source and {len(p_target)} target points")
        if len(set(names)) < len(names):
            twice = sorted(name for name, count in Counter(names).items() if count > 1)
            raise InputError(f"point names must be unique; more than once: {listed(twice)}")
        object.__setattr__(self, "names", names)
        object.__setattr__(self, "p_source", p_source)
        object.__setattr__(self, "p_target", p_target)
        if self.covariances is not None:
            covariances = frozen(self.covariances)
            if covariances.shape != (len(names), 3, 3):
                raise InputError(f"expected covariances of shape ({len(names)}, 3, 3), got {covariances.shape}")
            object.__setattr__(self, "covariances", covariances)

    def __len__(self) -> int:
        return len(self.names)

    def select(self, indices: Sequence[int] | ArrayLike) -> PointPairs:
        """Return some of the pairs. `indices`: shape (m,). Rows, in the order of the result."""
        rows = np.asarray(indices, dtype=np.int64)
        return PointPairs(
            tuple(self.names[i] for i in rows),
            self.p_source[rows],
            self.p_target[rows],
            None if self.covariances is None else self.covariances[rows],
            self.source,
            self.target,
            self.space,
        )


@dataclass(frozen=True, slots=True, eq=False)
class Residuals:
    """Distances of point pairs under a transform: ``taught - T model``, in the target frame."""

    names: tuple[str, ...]
    vectors_mm: FloatArray  #: shape (n, 3). Taught point minus moved model point, in the target frame, mm.

    @classmethod
    def of(cls, pairs: PointPairs, transform: RigidTransform) -> Residuals:
        """Compute the residuals of `pairs` under `transform`."""
        return cls(pairs.names, frozen(pairs.p_target - transform.apply(pairs.p_source)))

    @property
    def norms_mm(self) -> FloatArray:
        """Distances, shape (n,), mm: the d_i of Yin 2003, eq. (3)."""
        return np.asarray(np.linalg.norm(self.vectors_mm, axis=1), dtype=np.float64)

    @property
    def worst(self) -> str:
        """Name of the point with the largest distance."""
        return self.names[int(np.argmax(self.norms_mm))]

    @property
    def largest_mm(self) -> float:
        """Largest distance, mm: the f of Yin 2003, eq. (5)."""
        return float(self.norms_mm.max())

    @property
    def rms_mm(self) -> float:
        """Root of the mean squared distance, mm."""
        return float(np.sqrt(np.mean(self.norms_mm**2)))
