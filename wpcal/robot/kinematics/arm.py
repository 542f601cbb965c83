"""`Arm`: a chain together with how its controller counts the joints, their limits, and where the numbers come from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.core.robot_space import RobotSpace
from wpcal.core.same_bits import product, solve
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed
from wpcal.robot.kinematics.forward import Frames, MDHChain, forward_kinematics, geometric_jacobian, start_frames, walk


@dataclass(frozen=True, slots=True)
class Joint:
    """One joint as the controller shows it."""

    name: str  #: As on the pendant: ``S``, ``J3``, ``A1``.
    sign: int  #: +1 where the controller counts with the model, -1 where against it.
    #: `min_rad`, `max_rad`: Limits of the angle the controller shows, rad.
    min_rad: float
    max_rad: float
    speed_rad_s: float | None = None  #: Largest speed.
    pulses_per_deg: float | None = None  #: Encoder pulses, for controllers whose programs hold pulses.

    def __post_init__(self) -> None:
        if self.sign not in (1, -1):
            raise InputError(f"joint {self.name}: sign is 1 or -1, got {self.sign}")
        if not self.min_rad < self.max_rad:
            raise InputError(f"joint {self.name}: the lower limit must be below the upper one")


@dataclass(frozen=True, slots=True)
class Coupling:
    """A joint whose shown angle does not hold the motion of another one: ``true angle = shown + factor · other``.

    Where a pendant shows J3 against the horizontal, J3 takes up J2 with factor 1.
    """

    joint: str
    adds: str
    factor: float


@dataclass(frozen=True, slots=True, eq=False)
class Arm:
    """An arm: shown joint angles q in, flange poses in the controller's base frame out.

    The model's angles are ``θ = S q`` with ``S = diag(sign) (I + couplings)``; the chain holds constant offsets.

    `mount_mm`: shape (3,). Origin of the mounting face in the base frame: the origin of drawings and meshes of the arm.
    """

    name: str
    chain: MDHChain
    joints: tuple[Joint, ...]  #: One a link.
    couplings: tuple[Coupling, ...] = ()
    #: `source`, `licence`: Where the numbers come from.
    source: str = ""
    licence: str = ""
    notes: tuple[str, ...] = ()
    mount_mm: FloatArray = (0.0, 0.0, 0.0)  # type: ignore[assignment]  # frozen in __post_init__
    space: RobotSpace = RobotSpace.NOMINAL  #: Whether the chain is the controller's model or an identified one.
    nominal: MDHChain | None = None  #: Of an identified arm, the chain that its controller computes with.
    #: Of an arm identified with an unknown tool: how far a tool centre point that was taught in the controller may be
    #: off in this arm (95 %), since the last link stayed nominal. A tool centre point found in this arm is not.
    unseen_tool_mm: float = 0.0

    def __post_init__(self) -> None:
        if len(self.joints) != len(self.chain):
            raise InputError(f"{self.name}: {len(self.chain)} links, but {len(self.joints)} joints")
        names = [joint.name for joint in self.joints]
        if len(set(names)) < len(names):
            raise InputError(f"{self.name}: joint names must be unique, got {listed(names)}")
        for coupling in self.couplings:
            for name in (coupling.joint, coupling.adds):
                if name not in names:
                    raise InputError(f"{self.name}: a coupling names joint {name!r}; there are {listed(names)}")
        if (self.space is RobotSpace.IDENTIFIED) != (self.nominal is not None):
            raise InputError(f"{self.name}: an identified arm, and only that, carries the nominal chain beside its own")
        mount = frozen(self.mount_mm)
        if mount.shape != (3,):
            raise InputError(f"{self.name}: expected a mounting point of three numbers, got shape {mount.shape}")
        object.__setattr__(self, "mount_mm", mount)

    @property
    def coupling_matrix(self) -> FloatArray:
        """S of ``θ = S q``, shape (n, n)."""
        return _coupling_matrices(self)[0]

    @property
    def limits(self) -> FloatArray:
        """Lower and upper limits of the shown angles, shape (2, n), rad."""
        return _limits(self)

    def model_angles(self, q: ArrayLike) -> FloatArray:
        """Return the angles of the model (without the chain's offsets) for shown angles, shape (..., n), rad."""
        shown = np.asarray(q, dtype=np.float64)
        if shown.shape[-1:] != (len(self.joints),):
            raise InputError(f"{self.name} has {len(self.joints)} joints, got angles of shape {shown.shape}")
        return np.asarray(product(shown, self.coupling_matrix.T))

    def shown_angles(self, theta: ArrayLike) -> FloatArray:
        """Return the angles that the controller shows for angles of the model, shape (..., n), rad."""
        return product(theta, _coupling_matrices(self)[1].T)

    def forward(self, q: ArrayLike) -> FloatArray:
        """Return ``T_base_flange`` for shown joint angles of shape (N, n), rad; shape (N, 4, 4), mm."""
        return forward_kinematics(self.chain, self.model_angles(q))

    def jacobian(self, q: ArrayLike, *, point: ArrayLike = (0.0, 0.0, 0.0)) -> FloatArray:
        """Return the derivative with respect to the shown angles, shape (N, 6, n).

        Rows as in `geometric_jacobian`: turning (rad), then velocity of `point` in the flange frame (mm).
        """
        J = geometric_jacobian(self.chain, self.model_angles(q), point=point)
        return product(J, self.coupling_matrix)

    def within_limits(self, q: ArrayLike) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """Tell for shown angles of shape (..., n) whether every one is within its limits; shape (...)."""
        low, high = self.limits
        shown = np.asarray(q, dtype=np.float64)
        return np.asarray(((shown >= low) & (shown <= high)).all(axis=-1))

    def angles_from_pulses(self, pulses: ArrayLike) -> FloatArray:
        """Return shown angles (rad) for encoder pulses, shape (..., n).

        Raises `InputError` when the arm's file does not state the pulses per degree of every joint.
        """
        return np.deg2rad(np.asarray(pulses, dtype=np.float64) / self._pulses_per_deg())

    def pulses_from_angles(self, q: ArrayLike) -> FloatArray:
        """Return encoder pulses, rounded to whole ones, for shown angles (rad), shape (..., n).

        Raises `InputError` when the arm's file does not state the pulses per degree of every joint.
        """
        return np.asarray(np.rint(np.rad2deg(q) * self._pulses_per_deg()), dtype=np.float64)

    def _pulses_per_deg(self) -> FloatArray:
        missing = [joint.name for joint in self.joints if joint.pulses_per_deg is None]
        if missing:
            raise InputError(f"{self.name}: pulses per degree are not stated for joint {', '.join(missing)}")
        return np.array([joint.pulses_per_deg for joint in self.joints], dtype=np.float64)

    def as_nominal(self) -> Arm:
        """Return the arm as its controller models it (itself when it is nominal)."""
        if self.nominal is None:
            return self
        return replace(self, chain=self.nominal, nominal=None, space=RobotSpace.NOMINAL, unseen_tool_mm=0.0)

    def as_identified(self, chain: MDHChain, *, unseen_tool_mm: float = 0.0) -> Arm:
        """Return the arm with an identified chain; the controller's own chain is kept beside it."""
        return replace(
            self,
            chain=chain,
            nominal=self.as_nominal().chain,
            space=RobotSpace.IDENTIFIED,
            unseen_tool_mm=unseen_tool_mm,
        )


@lru_cache(maxsize=64)
def _coupling_matrices(arm: Arm) -> tuple[FloatArray, FloatArray]:
    """Return S of ``θ = S q`` and its inverse."""
    names = [joint.name for joint in arm.joints]
    S = np.eye(len(names))
    for coupling in arm.couplings:
        S[names.index(coupling.joint), names.index(coupling.adds)] += coupling.factor
    S *= np.array([joint.sign for joint in arm.joints])[:, None]
    return frozen(S), frozen(solve(S[None], np.eye(len(names))[None])[0][0])


@lru_cache(maxsize=64)
def _limits(arm: Arm) -> FloatArray:
    return frozen([[j.min_rad for j in arm.joints], [j.max_rad for j in arm.joints]])


@lru_cache(maxsize=64)
def _start(arm: Arm, T_world_base: RigidTransform) -> tuple[Frames, Frames, FloatArray]:
    """Return the base, the frame before the first link and the parameters of the links."""
    first = T_world_base.relabelled(target="world", source="base") @ arm.chain.T_base_dh0
    return start_frames(T_world_base, 1), start_frames(first, 1), arm.chain.table


def arm_frames(
    arm: Arm, T_world_base: RigidTransform, joints: FloatArray, *, shift_mm: FloatArray | None = None
) -> Iterator[Frames]:
    """Yield the base, the frames after all links but the last, and the flange of an arm, in `world`.

    `joints`: shape (n, k). Shown angles, rad.
    `shift_mm`: shape (3, n). How far the base is from `T_world_base`, in `world`, mm.
    """
    moved = 0.0 if shift_mm is None else shift_mm
    base, first, table = _start(arm, T_world_base)
    yield base._replace(p=base.p + moved)
    *motions, last = walk(first._replace(p=first.p + moved), table, np.ascontiguousarray(arm.model_angles(joints).T))
    yield from (motion.frame for motion in motions)
    yield last.frame.then(arm.chain.T_dhn_flange)
