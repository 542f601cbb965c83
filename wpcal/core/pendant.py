"""A pose in the notations of the teach pendants, and back.

Positions are in mm in all of them. They differ in the orientation: a quaternion (ABB), angles about fixed axes (KUKA,
FANUC, Yaskawa; KUKA writes them in the opposite order), angles about moving axes (Staubli x, y, z; Kawasaki z, y, z) or
a rotation vector (UR).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.rotations import (
    quaternion_from_rotation,
    rotation_from_quaternion,
    rotation_from_zyx,
    rotation_from_zyz,
    zyx_angles,
    zyz_angles,
)
from wpcal.core.tangent import exp_rotation, log_rotation
from wpcal.core.transform import RigidTransform


@dataclass(frozen=True, slots=True)
class Notation:
    """How the pendants of one maker show a pose."""

    maker: str  #: One or more makers.
    labels: tuple[str, ...]  #: Of the position and the orientation, in the order of the pendant.
    unit: str  #: Of the orientation; empty for a quaternion.
    decimals: int  #: Of the orientation, as a person copies it: 2 m away the rounding moves a point by 0.02 mm at most.
    #: `to_numbers`, `to_rotation`: From a rotation matrix, shape (3, 3), to the numbers, and back.
    to_numbers: Callable[[FloatArray], FloatArray]
    to_rotation: Callable[[FloatArray], FloatArray]

    def numbers(self, T: RigidTransform) -> FloatArray:
        """Return the numbers of a pose in the order of `labels`: mm first; shape (6,) or (7,)."""
        return np.concatenate([T.t_mm, self.to_numbers(T.R)])

    def transform(self, numbers: ArrayLike, *, target: str, source: str) -> RigidTransform:
        """Return the pose of numbers in the order of `labels`.

        `numbers`: shape (6,) or (7,). mm, and the orientation in `unit`.
        `target`, `source`: Frame names.
        Raises `InputError` when the count is wrong.
        """
        values = np.asarray(numbers, dtype=np.float64)
        if values.shape != (len(self.labels),):
            raise InputError(f"{self.maker}: expected {', '.join(self.labels)}, got {values.size} numbers")
        return RigidTransform(self.to_rotation(values[3:]), values[:3], target, source)

    def text(self, T: RigidTransform) -> str:
        """Return a pose as a person types it: ``X 812.494  Y … mm  A 34.3366  … deg``."""
        return f"{_labelled(self.labels[:3], T.t_mm, 3)} mm  {self.orientation_text(T)}"

    def orientation_text(self, T: RigidTransform) -> str:
        """Return the orientation as a person types it: ``A 34.3366  B -2.0054  C 1.1459 deg``."""
        shown = _labelled(self.labels[3:], self.to_numbers(T.R), self.decimals)
        return f"{shown} {self.unit}" if self.unit else shown

    def record(self, T: RigidTransform) -> dict[str, float]:
        """Return the numbers by their labels, for a JSON file."""
        return dict(zip(self.labels, self.numbers(T).tolist(), strict=True))


def _labelled(labels: tuple[str, ...], values: FloatArray, decimals: int) -> str:
    rounded = (round(float(value), decimals) + 0.0 for value in values)  # + 0.0: no -0.000
    return "  ".join(f"{label} {value:.{decimals}f}" for label, value in zip(labels, rounded, strict=True))


def _fixed_xyz(R: FloatArray) -> FloatArray:
    return np.rad2deg(zyx_angles(R))


def _from_fixed_xyz(angles: FloatArray) -> FloatArray:
    return rotation_from_zyx(*np.deg2rad(angles))


def _moving_xyz(R: FloatArray) -> FloatArray:
    return -np.rad2deg(zyx_angles(R.T))  # the transpose of Rx(a) Ry(b) Rz(c) is Rz(-c) Ry(-b) Rx(-a)


def _from_moving_xyz(angles: FloatArray) -> FloatArray:
    return rotation_from_zyx(*np.deg2rad(-angles)).T


NOTATIONS = (
    Notation(
        "ABB",
        ("X", "Y", "Z", "q1", "q2", "q3", "q4"),
        "",
        6,
        lambda R: np.roll(quaternion_from_rotation(R), 1),
        lambda q: rotation_from_quaternion(np.roll(q, -1)),
    ),
    Notation(
        "KUKA",
        ("X", "Y", "Z", "A", "B", "C"),
        "deg",
        4,
        lambda R: _fixed_xyz(R)[::-1],
        lambda angles: _from_fixed_xyz(angles[::-1]),
    ),
    Notation("FANUC", ("X", "Y", "Z", "W", "P", "R"), "deg", 4, _fixed_xyz, _from_fixed_xyz),
    Notation("Yaskawa", ("X", "Y", "Z", "Rx", "Ry", "Rz"), "deg", 4, _fixed_xyz, _from_fixed_xyz),
    Notation("Staubli", ("x", "y", "z", "rx", "ry", "rz"), "deg", 4, _moving_xyz, _from_moving_xyz),
    Notation(
        "Kawasaki",
        ("X", "Y", "Z", "O", "A", "T"),
        "deg",
        4,
        lambda R: np.rad2deg(zyz_angles(R)),
        lambda angles: rotation_from_zyz(*np.deg2rad(angles)),
    ),
    Notation("UR", ("X", "Y", "Z", "RX", "RY", "RZ"), "rad", 5, log_rotation, exp_rotation),
)
"""In the order of the how-to pages."""
