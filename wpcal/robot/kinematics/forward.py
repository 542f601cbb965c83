"""Batched forward kinematics of an `MDHChain`, and its derivatives.

All poses are computed at once. A frame is kept as its three axes and its origin, each of shape (3, ...): every step of
a link is then a few sums over long contiguous rows, which NumPy does far faster than products of small matrices.

Also here: `MDHChain`: the links of a serial arm as Denavit-Hartenberg parameters with Hayati's fifth.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, IntArray, frozen
from wpcal.core.errors import InputError
from wpcal.core.same_bits import sine_cosine
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


class Frames(NamedTuple):
    """Axes and origin of many frames in the base: x, y, z (unit) and p (mm), each of shape (3, ...)."""

    x: FloatArray
    y: FloatArray
    z: FloatArray
    p: FloatArray

    def point(self, offset: ArrayLike) -> FloatArray:
        """Return the points at `offset` in these frames: ``p + u x + v y + w z``; offset has shape (3,) or (3, ...)."""
        u, v, w = np.asarray(offset, dtype=np.float64)
        return np.asarray(self.p + u * self.x + v * self.y + w * self.z, dtype=np.float64)

    def then(self, transform: RigidTransform) -> Frames:
        """Return the frames `transform` further on: each times ``T``."""
        x, y, z = ((self.x * c[0] + self.y * c[1] + self.z * c[2]) for c in transform.R.T)
        return Frames(x, y, z, self.point(transform.t_mm))

    def shifted(self, by: FloatArray) -> Frames:
        """Return the frames with their origins moved. `by`: shape (3, n). mm."""
        x, y, z = (np.broadcast_to(axis, by.shape) for axis in self[:3])
        return Frames(x, y, z, self.p + by)

    def at(self, rows: IntArray) -> Frames:
        """Return frames of shape (3, n) at some of the n states; frames that stand still, (3, 1), stay as they are."""
        return self if self.p.shape[1] == 1 else Frames(*(axis[:, rows] for axis in self))

    def rotations(self) -> FloatArray:
        """Return rotation matrices, shape (..., 3, 3)."""
        columns = np.moveaxis(np.stack([self.x, self.y, self.z], axis=1), (0, 1), (-2, -1))
        return np.asarray(columns, dtype=np.float64)

    def matrices(self) -> FloatArray:
        """Return homogeneous matrices, shape (..., 4, 4)."""
        T = np.zeros((4, 4, *self.p.shape[1:]))
        T[:3, 0], T[:3, 1], T[:3, 2], T[:3, 3], T[3, 3] = self.x, self.y, self.z, self.p, 1.0
        return np.ascontiguousarray(np.moveaxis(T, (0, 1), (-2, -1)))


class LinkMotion(NamedTuple):
    """Where one link's parameters act: each turns about or moves along one of these axes at one of these origins.

    θ and d: axis `z` at `p_before`. a: axis `x`. α: axis `x` at `frame.p`. β: axis `frame.y` at `frame.p`.
    """

    z: FloatArray
    p_before: FloatArray
    x: FloatArray
    frame: Frames


def start_frames(T_base_dh0: RigidTransform, ndim: int) -> Frames:
    """Return the frame before the first link, shaped (3, 1, ..., 1) with `ndim` ones, ready to broadcast."""
    columns = (*T_base_dh0.R.T, T_base_dh0.t_mm)
    return Frames(*(np.reshape(column, (3, *(1,) * ndim)) for column in columns))


def walk(start: Frames, table: FloatArray, theta: FloatArray) -> Iterator[LinkMotion]:
    """Go along the links and yield what each of them does.

    `table`: shape (5, n, ...). Link parameters in the order of `LINK_SYMBOLS`; axes after the second broadcast with
    those of `theta`.
    `theta`: shape (n, ...). Joint angles without the offsets of the table, rad.
    """
    frame, more = start, (1,) * (theta.ndim + 1 - table.ndim)
    offsets, ds, lengths, alphas, betas = table.reshape(*table.shape[:2], *more, *table.shape[2:])
    own = (
        sine_cosine(theta + offsets),
        _of_links(alphas.tobytes(), alphas.shape),
        _of_links(betas.tobytes(), betas.shape),
    )
    turns = (zip(*angles, strict=True) for angles in own)
    for d, a, turn, twist, tilt in zip(ds, lengths, *turns, strict=True):
        z, p_before = frame.z, frame.p
        x, y = _turn(frame.x, frame.y, turn)  # Rz(θ)
        p = p_before + d * z + a * x  # Tz(d) Tx(a)
        y, z_end = _turn(y, z, twist)  # Rx(α)
        x_end = x
        if tilt[0].any():
            z_end, x_end = _turn(z_end, x, tilt)  # Ry(β)
        frame = Frames(x_end, y, z_end, p)
        yield LinkMotion(z, p_before, x, frame)


@lru_cache(maxsize=64)
def _of_links(angles: bytes, shape: tuple[int, ...]) -> tuple[FloatArray, FloatArray]:
    """Return sine and cosine of angles that the links of an arm have, whatever the joints."""
    return sine_cosine(np.frombuffer(angles).reshape(shape))


def _turn(u: FloatArray, v: FloatArray, turn: tuple[FloatArray, FloatArray]) -> tuple[FloatArray, FloatArray]:
    """Turn the axes u and v in their plane, u towards v, by an angle with this sine and cosine."""
    s, c = turn
    return c * u + s * v, c * v - s * u


def chain_frames(chain: MDHChain, theta: ArrayLike) -> Frames:
    """Return the flange frames in the base for joint angles of shape (N, n), rad; arrays of shape (3, N)."""
    angles = np.ascontiguousarray(np.asarray(theta, dtype=np.float64).T)
    frame = start_frames(chain.T_base_dh0, 1)
    for motion in walk(frame, chain.table, angles):
        frame = motion.frame
    return frame.then(chain.T_dhn_flange)


def forward_kinematics(chain: MDHChain, theta: ArrayLike) -> FloatArray:
    """Return the flange poses ``T_base_flange``, shape (N, 4, 4). Homogeneous matrices, mm.

    `theta`: shape (N, n). Joint angles of the model without its offsets, rad.

    References: Xiong, Yang, Wang 2015, eq. (1) to (3).

    A planar arm of two links, stretched out and then bent by a quarter turn:

    >>> arm = MDHChain([0, 0], [0, 0], [400, 300], [0, 0], [0, 0], (True, False))
    >>> forward_kinematics(arm, [[0, 0], [0, np.pi / 2]])[:, :2, 3].round(9).tolist()
    [[700.0, 0.0], [400.0, 300.0]]
    """
    return chain_frames(chain, theta).matrices()


def geometric_jacobian(chain: MDHChain, theta: ArrayLike, *, point: ArrayLike = (0.0, 0.0, 0.0)) -> FloatArray:
    """Return the derivative of the flange with respect to the joint angles of the model.

    `theta`: shape (N, n). Joint angles, rad.
    `point`: shape (3,) or (3, N). The point in the flange frame whose velocity is wanted, mm.
    Returns ndarray, shape (N, 6, n). Rows: turning of the flange (rad), then velocity of the point (mm), both in the
    base, per rad.
    """
    angles = np.ascontiguousarray(np.asarray(theta, dtype=np.float64).T)
    motions = list(walk(start_frames(chain.T_base_dh0, 1), chain.table, angles))
    p = motions[-1].frame.then(chain.T_dhn_flange).point(point)
    J = np.empty((6, len(chain), p.shape[1]))
    for i, motion in enumerate(motions):
        J[:3, i] = motion.z
        J[3:, i] = cross(motion.z, p - motion.p_before)
    return np.ascontiguousarray(np.moveaxis(J, 2, 0))


def cross(u: FloatArray, v: FloatArray) -> FloatArray:
    """Return u × v, all of shape (3, ...); far faster than `numpy.cross` on long rows."""
    out = np.empty(np.broadcast_shapes(u.shape, v.shape))
    out[0] = u[1] * v[2] - u[2] * v[1]
    out[1] = u[2] * v[0] - u[0] * v[2]
    out[2] = u[0] * v[1] - u[1] * v[0]
    return out
