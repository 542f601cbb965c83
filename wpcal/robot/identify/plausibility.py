"""Slips in a file of poses that a fit would absorb: a wrong unit, quaternions in another order, transposed rotations.

A nominal arm is off by millimetres and tenths of a degree. Once base and tool are placed as well as possible, larger
residuals therefore mean that the file is not what it claims to be. If one usual slip explains them, it is named.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError, UnitError
from wpcal.core.rotations import quaternion_from_rotation, rotation_from_quaternion, rotation_from_zyx, zyx_angles
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.pose_residuals import pose_errors
from wpcal.robot.identify.registration import register
from wpcal.robot.kinematics.chain import MDHChain

LARGEST_NOMINAL_MM = 20.0
"""Root mean square of the position errors of a nominal arm in its best base and tool; industrial arms stay below 5."""

LARGEST_NOMINAL_DEG = 10.0
"""The same for orientations; a joint zero may be off by some degrees after a crash, and the others are not."""

EXPLAINS = 0.2  #: A slip is named when correcting it leaves less than this share of the residual.

LENGTH_UNITS = {"metres": 1000.0, "inches": 25.4, "centimetres": 10.0}
"""Units that positions come in by mistake, and how many mm they have."""


def require_plausible(
    chain: MDHChain, theta: FloatArray, observations: PoseObservations, *, free_base: bool, free_tool: bool
) -> None:
    """Refuse measurements that the nominal arm cannot have produced.

    `theta`: shape (N, n). Model angles of the rows, rad.
    Raises `UnitError` when positions are in metres, inches or centimetres, or angles in radians.
    Raises `InputError` when orientations are given in another convention, or belong to other poses.
    """

    def residuals(changed: PoseObservations) -> tuple[float, float]:
        model = register(chain, theta, changed, free_base=free_base, free_tool=free_tool)
        errors = pose_errors(model, theta, changed)
        turn = float(np.rad2deg(_rms(errors[:, :3]))) if changed.has_orientations else 0.0
        return _rms(errors[:, -3:]), turn

    off_mm, off_deg = residuals(observations)
    if off_mm > LARGEST_NOMINAL_MM:
        for unit, factor in LENGTH_UNITS.items():
            if residuals(replace(observations, p_base=observations.p_base * factor))[0] < EXPLAINS * off_mm:
                raise UnitError(
                    f"the positions look like {unit}, expected mm: as mm they miss the arm by {off_mm:.0f} mm"
                )
    if off_deg > LARGEST_NOMINAL_DEG and observations.R_base_flange is not None:
        left = {
            slip: residuals(replace(observations, R_base_flange=corrected(observations.R_base_flange)))[1]
            for slip, corrected in ORIENTATION_SLIPS.items()
        }
        slips = [slip for slip, deg in sorted(left.items(), key=lambda item: item[1]) if deg < EXPLAINS * off_deg]
        if slips:
            # with base and tool unknown, some slips differ by a fixed turn only, and both explain the file
            error = UnitError if slips[0] == IN_RADIANS else InputError
            raise error(
                f"the orientations look like {', or '.join(slips)}: as given they miss the arm by {off_deg:.0f} deg, "
                f"otherwise by {left[slips[0]]:.2g} deg"
            )


def _rms(vectors: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))


def _as_scalar_first(R: FloatArray) -> FloatArray:
    """Undo the reading of quaternions w, x, y, z as x, y, z, w."""
    return rotation_from_quaternion(np.roll(quaternion_from_rotation(R), -1, axis=-1))


def _as_transposed(R: FloatArray) -> FloatArray:
    return np.asarray(np.swapaxes(R, 1, 2))


def _as_radians(R: FloatArray) -> FloatArray:
    """Undo the reading of angles in radians as degrees; such rotations are all below seven degrees."""
    return rotation_from_zyx(*np.rad2deg(zyx_angles(R)).T)


IN_RADIANS = "angles in radians, expected degrees"
ORIENTATION_SLIPS: dict[str, Callable[[FloatArray], FloatArray]] = {
    "quaternions in the order w, x, y, z; expected x, y, z, w": _as_scalar_first,
    "rotations from the base to the flange; expected the flange's orientation in the base": _as_transposed,
    IN_RADIANS: _as_radians,
}
"""Usual slips, and what undoes them."""
