r"""Inverse kinematics of 6R arms whose wrist is not spherical, as collaborative arms have: all solutions.

An arm is a product of turns about the axes that it has at zero, ``T = e1 e2 e3 e4 e5 e6 M``. Axes 2 and 3 are parallel.

* Axes 2, 3 and 4 are parallel, and axes 5 and 6 meet (Universal Robots): closed form, eight solutions. The place of the
  point where axes 5 and 6 meet gives θ1, the direction of axis 6 gives θ5, and the rest is a plane arm of two links.
* Axes 4 and 5 meet, and axis 6 misses that point: θ6 puts the point on a circle, and θ1, θ2 and θ3 reach it
  in four ways. The angle between axes 4 and 5 must then be that of the arm. The roots of this function of θ6 are all
  solutions, at most sixteen (Abbes, Poisson 2024, inverse kinematics of a
  collaborative robot). They are bracketed on a grid, pairs of them around turning points too, and polished by Newton
  steps (`wpcal.robot.kinematics.inverse`).

References: Paden, Kahan: subproblems of turns, in Murray, Li, Sastry, A mathematical introduction to robotic
manipulation, 1994, §3.3.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import GeometryError
from wpcal.core.last_held import last_held
from wpcal.core.same_bits import arc_tangent, length, product, sine_cosine
from wpcal.robot.kinematics.forward import MDHChain, cross, forward_kinematics, start_frames, walk

FAMILY_ATOL = 1e-9  #: As in `wpcal.robot.kinematics.opw`.
SLACK = 1e-12  #: Squares below zero by this part are round-off at the edge of the reach.
GRID, FINE = 64, 12  #: Parts of a turn of θ6, and of such a part where roots may hide, in which roots are looked for.
NEAR = (
    2.0  #: Roots may hide between two nodes if the miss at one of them is less than this times its second difference.
)
THIRDS = 14  #: Of two parts, until the turning point between them is known to 3e-3 of them.
HALVINGS = 30  #: A bracket is then 1e-10 rad wide, from where Newton steps converge.
MOST_ROOTS = 16  #: Of a 6R arm.
SAME_RAD = 1e-6  #: Solutions that differ by less are one.


def _turned(k: FloatArray, angle: FloatArray, v: FloatArray) -> FloatArray:
    """Turn vectors (3, ...) about a unit vector (3,) by angles (...)."""
    s, c = sine_cosine(angle)
    axis = k.reshape(3, *(1,) * max(v.ndim - 1, angle.ndim))
    v = v.reshape(3, *(1,) * (axis.ndim - v.ndim), *v.shape[1:])
    along = (axis * v).sum(axis=0)
    return np.asarray(c * v + s * cross(axis, v) + (1.0 - c) * along * axis)


def _angle(k: FloatArray, u: FloatArray, v: FloatArray) -> FloatArray:
    """Return the angles about a unit vector (3,) that turn vectors u (3, ...) into the directions of v (3, ...)."""
    u, v = np.broadcast_arrays(u, v)
    axis, w = np.broadcast_to(k.reshape(3, *(1,) * (u.ndim - 1)), u.shape), cross(u, v)
    flat = (u * v).sum(axis=0) - (axis * u).sum(axis=0) * (axis * v).sum(axis=0)
    return arc_tangent((axis * w).sum(axis=0), flat)


def _angle_to_height(k: FloatArray, u: FloatArray, h: FloatArray, height: FloatArray, sign: FloatArray) -> FloatArray:
    """Return an angle about k that brings vectors u (3, ...) to a height along h (3,): of the two, that of the sign."""
    shape = (3, *(1,) * (u.ndim - 1))
    axis, up = k.reshape(shape), h.reshape(shape)
    along = (axis * u).sum(axis=0) * float(product(k, h))
    a = (up * u).sum(axis=0) - along
    b = (np.cross(h, k).reshape(shape) * u).sum(axis=0)
    c, square = height - along, a * a + b * b
    return np.asarray(arc_tangent(b, a) + sign * arc_tangent(_root(square - c * c, square), c))


def _root(square: FloatArray, scale: FloatArray | float) -> FloatArray:
    return np.sqrt(np.where(square < -SLACK * scale, np.nan, np.maximum(square, 0.0)))


@dataclass(frozen=True, slots=True, eq=False)
class OffsetWrist:
    """The axes of an arm at zero, in its base: directions and points, shape (6, 3), and the flange."""

    chain: MDHChain
    k: FloatArray
    o: FloatArray
    flange: FloatArray  #: shape (4, 4).
    point6: FloatArray  #: shape (3,). On axis 6, nearest to axis 5.
    is_parallel: bool  #: Whether axis 4 is parallel to axes 2 and 3.

    @classmethod
    def of_chain(cls, chain: MDHChain) -> OffsetWrist:
        """Read the axes off a chain.

        Raises `GeometryError` when it is of neither kind; the message says which axes are not as they should be.
        """
        return _offset_wrist(chain)

    @property
    def branches(self) -> int:
        """Most solutions of a pose."""
        return 8 if self.is_parallel else MOST_ROOTS

    @property
    def reach_mm(self) -> float:
        """Bound of the distance of `point6` from the point of axis 2 at the next axis."""
        joints = [self.o[1], self.o[2], self.o[3], self.o[4], self.point6]
        return sum(length(b - a) for a, b in pairwise(joints))

    @property
    def arm_lengths_mm(self) -> tuple[float, float]:
        """Of the upper and of the lower arm, across axis 2."""
        upper, fore = ((v - product(v, self.k[1]) * self.k[1]) for v in np.diff(self.o[1:4], axis=0))
        return length(upper), length(fore)

    def shortage(self, T_base_flange: FloatArray) -> FloatArray:
        """Return how far `point6` is beyond `reach_mm` from axis 2 at poses of shape (N, 4, 4), shape (N,), mm."""
        place = product(T_base_flange, product(np.linalg.inv(self.flange), np.append(self.point6, 1.0)))[:, :3]
        away = place - self.o[1]
        return np.asarray(np.maximum(np.sqrt((away * away).sum(axis=1)) - self.reach_mm, 0.0))

    def solve(self, T_base_flange: FloatArray) -> FloatArray:
        """Return all solutions for N poses, shape (N, b, 6): angles without the chain's offsets, rad; NaN: none.

        `T_base_flange`: shape (N, 4, 4). mm.
        """
        back = np.linalg.inv(self.flange)
        X = product(T_base_flange, back)  # e1 ... e6
        R, p = np.moveaxis(X[:, :3, :3], 0, 2), X[:, :3, 3].T
        found = self._closed(R, p) if self.is_parallel else self._roots(R, p)
        return np.asarray(found - 2 * np.pi * np.ceil(found / (2 * np.pi) - 0.5))

    def _bend(self, far: FloatArray, sign: FloatArray) -> FloatArray:
        """Return θ3 for the point of axis 4 at vectors (3, ...) from axis 2: of two, that of the sign; NaN: too far."""
        k, columns = self.k, (3, *(1,) * (far.ndim - 1))
        upper, fore = (v - product(v, k[1]) * k[1] for v in np.diff(self.o[1:4], axis=0))
        a, b = self.arm_lengths_mm
        height = (k[1].reshape(columns) * far).sum(axis=0)
        cosine = ((far * far).sum(axis=0) - height * height - a * a - b * b) / (2.0 * a * b)
        straight = float(_angle(k[2], fore.reshape(3, 1), upper.reshape(3, 1))[0])
        return np.asarray(straight + sign * arc_tangent(_root((1.0 - cosine) * (1.0 + cosine), 1.0), cosine))

    def _elbow(self, spot: FloatArray, theta3: FloatArray) -> FloatArray:
        """Return θ2 that brings the point of axis 4, after a turn of joint 3, to a spot (3, ...)."""
        o2, o3 = (self.o[row].reshape(3, *(1,) * theta3.ndim) for row in (1, 2))
        fore = _turned(self.k[2], theta3, self.o[3] - self.o[2]) + o3 - o2
        return _angle(self.k[1], fore, spot - o2)

    def _closed(self, R: FloatArray, p: FloatArray) -> FloatArray:
        """Return the eight solutions of an arm with three parallel axes, shape (N, 8, 6)."""
        k, o, n = self.k, self.o, R.shape[2]
        out = np.full((2, 2, 2, 6, n), np.nan)
        w = np.einsum("ijn,j->in", R, self.point6) + p - o[0].reshape(3, 1)
        height = np.full(n, float(product(k[1], self.point6 - o[0])))
        both = np.array([1.0, -1.0])
        theta1 = _angle_to_height(-k[0], w[:, None], k[1], height, both[:, None])  # (2, N)
        up = self._of(R, k[5], theta1)
        lift = (k[1].reshape(3, 1, 1) * up).sum(axis=0)
        v = np.broadcast_to(k[5].reshape(3, 1, 1), (3, *lift.shape))
        theta5 = _angle_to_height(k[4], v[:, None], k[1], lift, both[:, None, None])  # (2, 2, N): θ5, θ1
        axis = np.broadcast_to(k[1].reshape(3, *(1,) * theta1.ndim), (3, *theta1.shape))
        seen = np.einsum("ijn,i...n->j...n", R, _turned(k[0], theta1, axis))[:, None]  # axis 2 as the flange sees it
        wrist = _turned(k[4], -theta5, k[1])
        theta6 = _angle(k[5], np.broadcast_to(seen, wrist.shape), wrist)
        x = np.cross(k[1], k[0])
        flat = np.broadcast_to(theta1, theta5.shape)
        back = _turned(k[5], -theta6, _turned(k[4], -theta5, x))  # carried by e2 e3 e4 of x, and of the point of axis 4
        turn = _angle(k[1], x.reshape(3, 1, 1, 1), self._of(R, back, flat))
        point = _turned(k[4], -theta5, o[3] - o[4]) + (o[4] - self.point6).reshape(3, 1, 1, 1)
        point = _turned(k[5], -theta6, point) + self.point6.reshape(3, 1, 1, 1)
        spot = self._of(R, point, flat, p)
        signs = np.array([float(np.sign(product(k[1], k[row]))) for row in (2, 3)])
        for row, sign in enumerate((1.0, -1.0)):
            theta3 = self._bend(spot - o[1].reshape(3, 1, 1, 1), np.array(sign))
            theta2 = self._elbow(spot, theta3)
            theta4 = signs[1] * (turn - theta2 - signs[0] * theta3)
            for column, angles in enumerate((flat, theta2, theta3, theta4, theta5, theta6)):
                out[:, :, row, column] = angles
        bad = np.isnan(out).any(axis=3, keepdims=True)
        return np.moveaxis(np.where(bad, np.nan, out).reshape(8, 6, n), 2, 0)

    def _of(self, R: FloatArray, v: FloatArray, theta1: FloatArray, p: FloatArray | None = None) -> FloatArray:
        """Return points, or without `p` vectors, of shape (3,) or (3, ..., N) carried by ``e2 ... e6``."""
        if v.ndim == 1:
            v = np.broadcast_to(v.reshape(3, *(1,) * theta1.ndim), (3, *theta1.shape))
        moved = np.einsum("ijn,j...n->i...n", R, v)
        if p is None:
            return _turned(self.k[0], -theta1, moved)
        o = self.o[0].reshape(3, *(1,) * theta1.ndim)
        moved = moved + p.reshape(3, *(1,) * (theta1.ndim - 1), -1) - o
        return np.asarray(_turned(self.k[0], -theta1, moved) + o)

    def _arm(self, R: FloatArray, p: FloatArray, theta6: FloatArray, way: _Way) -> tuple[FloatArray, FloatArray]:
        """Return by how much axes 4 and 5 miss their angle, as a cosine, and all angles (6, ...), for θ6 (..., N)."""
        k, o, columns = self.k, self.o, (3, *(1,) * theta6.ndim)
        base, shoulder, last = (point.reshape(columns) for point in (o[0], o[1], self.point6))
        w = self._moved(R, _turned(k[5], -theta6, o[3] - self.point6) + last, p) - base
        height = np.full(theta6.shape, float(product(k[1], o[3] - o[0])))
        theta1 = _angle_to_height(-k[0], w, k[1], height, way[0])
        spot = _turned(k[0], -theta1, w) + base
        theta3 = self._bend(spot - shoulder, way[1])
        theta2 = self._elbow(spot, theta3)
        axis4 = _turned(k[1], theta2, _turned(k[2], theta3, k[3]))
        axis5 = _turned(k[0], -theta1, self._moved(R, _turned(k[5], -theta6, k[4])))
        axis6 = _turned(k[0], -theta1, self._moved(R, np.broadcast_to(k[5].reshape(columns), w.shape)))
        miss = (axis4 * axis5).sum(axis=0) - product(k[3], k[4])

        def back(v: FloatArray) -> FloatArray:
            return _turned(k[2], -theta3, _turned(k[1], -theta2, v))

        theta4 = _angle(k[3], k[4].reshape(columns), back(axis5))
        theta5 = _angle(k[4], k[5].reshape(columns), _turned(k[3], -theta4, back(axis6)))
        return miss, np.stack([theta1, theta2, theta3, theta4, theta5, theta6])

    def _moved(self, R: FloatArray, v: FloatArray, p: FloatArray | None = None) -> FloatArray:
        """Return points, or without `p` vectors, of shape (3, ..., N) carried by ``e1 ... e6``."""
        moved = np.einsum("ijn,j...n->i...n", R, v)
        return np.asarray(moved if p is None else moved + p.reshape(3, *(1,) * (v.ndim - 2), -1))

    def _roots(self, R: FloatArray, p: FloatArray) -> FloatArray:
        """Return all solutions of an arm whose axis 6 misses the wrist, shape (N, 16, 6), before Newton steps."""
        n = R.shape[2]
        signs = np.array([(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)])
        which = np.stack([np.repeat(np.arange(4), n), np.tile(np.arange(n), 4)], axis=1)
        at = R, p, signs
        u = 2.0 * np.pi * np.arange(-1, GRID + 2) / GRID  # with a part before and a part after the turn
        miss = self._miss(at, which, np.broadcast_to(u[:, None], (len(u), len(which))))
        bend = np.nan_to_num(np.abs(miss[:-2] + miss[2:] - 2.0 * miss[1:-1]), nan=np.inf)
        is_way, size = np.isfinite(miss[1:-1]), np.abs(miss[1:-1])
        near = np.fmin(size[:-1], size[1:]) <= NEAR * np.maximum(bend[:-1], bend[1:])
        cell, own = np.nonzero(near & (is_way[:-1] | is_way[1:]))
        plain = np.argwhere(~near & (np.sign(miss[1:-2]) * np.sign(miss[2:-1]) <= 0.0))
        # where the miss may turn near zero, or a way ends as the arm is stretched: once more, denser at that end
        low, high = u[cell + 1], u[cell + 2]
        ends, begins = is_way[cell, own] & ~is_way[cell + 1, own], ~is_way[cell, own]
        low = np.where(begins, self._end(at, which[own], high, low, begins), low)
        high = np.where(ends, self._end(at, which[own], low, high, ends), high)
        share = np.linspace(0.0, 1.0, FINE + 1)[:, None]
        share = np.where(begins, share**2, np.where(ends, 1.0 - (1.0 - share) ** 2, share))
        fine = low + share * (high - low)
        again = self._miss(at, which[own], fine)
        sign, size = np.sign(again), np.abs(again)
        crosses = np.argwhere(sign[:-1] * sign[1:] <= 0.0)
        turns = np.argwhere(
            (size[1:-1] <= np.minimum(size[:-2], size[2:])) & (sign[1:-1] == sign[:-2]) & (sign[1:-1] == sign[2:])
        )
        before, after = fine[turns[:, 0], turns[:, 1]], fine[turns[:, 0] + 2, turns[:, 1]]
        least = self._least(at, which[own[turns[:, 1]]], before, after)
        rows = np.concatenate([plain[:, 1], own[crosses[:, 1]], own[turns[:, 1]], own[turns[:, 1]]])
        a = np.concatenate([u[plain[:, 0] + 1], fine[tuple(crosses.T)], before, least])
        b = np.concatenate([u[plain[:, 0] + 2], fine[crosses[:, 0] + 1, crosses[:, 1]], least, after])
        first = np.sign(self._miss(at, which[rows], a))
        kept = first * np.sign(self._miss(at, which[rows], b)) <= 0.0
        a, b, first, rows = a[kept], b[kept], first[kept], which[rows[kept]]
        a, b = last_held(a, b, lambda r, u: np.sign(self._miss(at, rows[r], u)) == first[r], halvings=HALVINGS)
        pose, way = rows[:, 1], signs[rows[:, 0]].T
        _, angles = self._arm(R[:, :, pose], p[:, pose], (a + b) / 2, (way[0], way[1]))
        return _placed(n, pose, angles.T)

    def _miss(self, at: _Where, which: IntArray, theta6: FloatArray) -> FloatArray:
        """Return the miss at places (..., r) of r ways; rows of `which`: signs, pose."""
        way, pose = at[2][which[:, 0]].T, which[:, 1]
        return self._arm(at[0][:, :, pose], at[1][:, pose], theta6, (way[0], way[1]))[0]

    def _least(self, at: _Where, which: IntArray, a: FloatArray, b: FloatArray) -> FloatArray:
        """Return where between two places the size of the miss is least: by thirds."""
        sign = np.sign(self._miss(at, which, (a + b) / 2))
        for _ in range(THIRDS):
            c, d = a + (b - a) / 3.0, b - (b - a) / 3.0
            lower = sign * self._miss(at, which, c) < sign * self._miss(at, which, d)
            a, b = np.where(lower, a, c), np.where(lower, d, b)
        return np.asarray((a + b) / 2)

    def _end(self, at: _Where, which: IntArray, inner: FloatArray, outer: FloatArray, some: BoolArray) -> FloatArray:
        """Return the last places of some ways, from places on them to places beside them; the others stay."""
        found, ways = inner.copy(), which[some]
        found[some], _ = last_held(
            inner[some], outer[some], lambda row, u: np.isfinite(self._miss(at, ways[row], u)), halvings=HALVINGS
        )
        return found


_Way = tuple[FloatArray, FloatArray]  # the signs of shoulder and elbow
_Where = tuple[FloatArray, FloatArray, FloatArray]  # rotations and places of all poses, and the signs of all ways


def _placed(n: int, pose: IntArray, angles: FloatArray) -> FloatArray:
    """Return solutions (r, 6) in rows by their poses, in the order of their ways, shape (n, 16, 6)."""
    out = np.full((n, MOST_ROOTS, 6), np.nan)
    order = np.argsort(pose, kind="stable")
    number = np.arange(len(pose)) - np.searchsorted(pose[order], pose[order])
    kept = number < MOST_ROOTS
    out[pose[order][kept], number[kept]] = angles[order][kept]
    return out


@lru_cache(maxsize=64)
def _offset_wrist(chain: MDHChain) -> OffsetWrist:
    motions = list(walk(start_frames(chain.T_base_dh0, 1), chain.table, np.zeros((6, 1))))
    k = np.array([motion.z[:, 0] for motion in motions])
    o = np.array([motion.p_before[:, 0] for motion in motions])
    reach = max(1.0, float(np.abs(np.diff(o, axis=0)).sum()))
    if length(np.cross(k[1], k[2])) > FAMILY_ATOL:
        raise GeometryError("no inverse kinematics for this arm: axis 3 is not parallel to axis 2")
    o = o.copy()
    is_parallel = length(np.cross(k[1], k[3])) <= FAMILY_ATOL
    o[4], point6 = _nearest(o[4], k[4], o[5], k[5])
    if is_parallel:
        if length(o[4] - point6) > FAMILY_ATOL * reach:
            raise GeometryError(
                "no inverse kinematics for this arm: axes 2, 3, 4 are parallel, and axes 5, 6 do not meet"
            )
    else:
        o[3], meets = _nearest(o[3], k[3], o[4], k[4])
        if length(o[3] - meets) > FAMILY_ATOL * reach:
            raise GeometryError("no inverse kinematics for this arm: axes 4 and 5 do not meet")
        o[4] = meets
    flange = forward_kinematics(chain, np.zeros((1, 6)))[0]
    return OffsetWrist(chain, k, o, flange, point6, is_parallel)


def _nearest(p: FloatArray, u: FloatArray, q: FloatArray, v: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the points of two lines that are nearest to each other; the lines are not parallel."""
    n = np.cross(u, v)
    n2 = float(product(n, n))
    s, t = (float(product(np.cross(q - p, way), n)) / n2 for way in (v, u))
    return p + s * u, q + t * v
