"""Pose errors in numbers that people compare, and the verdict whether an identification made them smaller.

Also here: slips in a file of poses that a fit would absorb: wrong units, quaternions in another order, transposed
rotations.

A nominal arm is off by millimetres and tenths of a degree. Once base and tool are placed as well as possible, larger
residuals therefore mean that the file is not what it claims to be. If one usual slip explains them, it is named.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from scipy.stats import wilcoxon

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError, UnitError
from wpcal.core.rotations import quaternion_from_rotation, rotation_from_quaternion, rotation_from_zyx, zyx_angles
from wpcal.core.wording import short
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.pose_residuals import pose_errors
from wpcal.robot.identify.registration import register
from wpcal.robot.kinematics.forward import MDHChain

LEAST_TEST_POSES = 7  #: Below seven poses even a gain in every one of them has a chance of 2⁻⁶ or more to be luck.
CHANCE = 0.01  #: A gain on the test poses counts when luck alone would show it once in a hundred times or less.
LARGEST_LEFT_DEG = 2.0
"""The same for orientations: identified arms leave hundredths of a degree, and a probe that slipped leaves degrees."""
LARGEST_CHANGE_MM, LARGEST_CHANGE_RAD = 50.0, float(np.deg2rad(15.0))
"""No link of an arm that moves is this far off its nominal value: larger changes come from measurements in another unit
or convention, or of another robot. A joint zero lost in a crash stays below."""
LARGEST_LEFT_MM = 5.0
"""Identified arms leave tenths of a millimetre. More than this (root mean square) on the test poses means that the
measurements are not of these joint angles, even where a bent model comes nearer to them than the nominal one."""


@dataclass(frozen=True, slots=True)
class ErrorFigures:
    """Mean, root mean square, largest, and 95th percentile of one kind of error."""

    mean: float
    rms: float
    largest: float
    percentile_95: float


@dataclass(frozen=True, slots=True)
class PoseErrorSummary:
    """Errors of a set of poses."""

    distance_mm: ErrorFigures  #: Of the position.
    turn_deg: ErrorFigures | None  #: Of the orientation, as one angle; None where only positions were measured.

    def to_record(self) -> dict[str, Any]:
        """Return plain values for a JSON file."""
        return asdict(self)


@dataclass(frozen=True, slots=True)
class Verdict:
    """Whether the identified arm is better, judged on poses that were not fitted."""

    improved: bool
    chance: float  #: Probability of such a gain by luck (Wilcoxon's signed-rank test on the paired distances).
    reasons: tuple[str, ...]  #: Why not, when not.


def distances_mm(errors: FloatArray) -> FloatArray:
    """Return position errors, shape (N,), mm, of errors as `pose_errors` gives them."""
    return np.asarray(np.linalg.norm(errors[:, -3:], axis=1), dtype=np.float64)


def turns_deg(errors: FloatArray) -> FloatArray | None:
    """Return orientation errors, shape (N,), degrees; None where only positions were measured."""
    return np.rad2deg(np.linalg.norm(errors[:, :3], axis=1)) if errors.shape[1] == 6 else None


def summarise(errors: FloatArray) -> PoseErrorSummary:
    """Return the figures of errors, shape (N, 3 or 6), as `pose_errors` gives them."""
    turns = turns_deg(errors)
    return PoseErrorSummary(_figures(distances_mm(errors)), None if turns is None else _figures(turns))


def _figures(values: FloatArray) -> ErrorFigures:
    rms, percentile_95 = np.sqrt(np.mean(values**2)), np.percentile(values, 95.0)
    return ErrorFigures(float(np.mean(values)), float(rms), float(np.max(values)), float(percentile_95))


def judge(
    before: FloatArray,
    after: FloatArray,
    *,
    changes: Mapping[str, tuple[float, bool]] | None = None,
    doubts: Sequence[str] = (),
) -> Verdict:
    """Judge whether the errors of the same test poses became smaller, and whether the change is one of a real arm.

    Positions must become better. Orientations, where measured, must not become worse.

    `before`, `after`: shape (N, 3 or 6). Errors of the nominal and of the identified arm, as `pose_errors` gives them.
    `changes`: Change of each link parameter, mm or rad, and whether it is a length.
    `doubts`: What else speaks against the identified arm.
    """
    gain = distances_mm(before) - distances_mm(after)
    left = float(np.sqrt(np.mean(distances_mm(after) ** 2)))
    chance = float(wilcoxon(gain, alternative="greater", method="approx").pvalue) if gain.any() else 1.0
    reasons = []
    if len(gain) < LEAST_TEST_POSES:
        reasons.append(
            f"{len(gain)} test poses are too few to tell a gain from luck; measure {LEAST_TEST_POSES} or judge by folds"
        )
    if chance > CHANCE:
        reasons.append(
            f"a gain like this comes by luck with a probability of {chance:.2g}; folds test every pose and decide more"
        )
    if left > LARGEST_LEFT_MM:
        reasons.append(
            f"{short(left)} mm are left on the test poses: the measurements are not of these joint angles and this arm"
        )
    reasons += _orientation_reasons(before, after) + _change_reasons(changes or {})
    reasons += doubts
    return Verdict(not reasons, chance, tuple(reasons))


def _orientation_reasons(before: FloatArray, after: FloatArray) -> list[str]:
    turns_before, turns_after = turns_deg(before), turns_deg(after)
    if turns_before is None or turns_after is None:
        return []
    left = float(np.sqrt(np.mean(turns_after**2)))
    if left > LARGEST_LEFT_DEG:
        return [
            f"{short(left)} deg are left on the test poses: the orientations are not of these joint angles and this arm"
        ]
    loss = turns_after - turns_before
    if loss.any() and float(wilcoxon(loss, alternative="greater", method="approx").pvalue) <= CHANCE:
        was, became = short(turns_before.mean()), short(turns_after.mean())
        return [f"orientations became worse: {was} deg before, {became} deg after, in the mean"]
    return []


def _change_reasons(changes: Mapping[str, tuple[float, bool]]) -> list[str]:
    limits = {True: LARGEST_CHANGE_MM, False: LARGEST_CHANGE_RAD}
    names = [name for name, (change, is_length) in changes.items() if abs(change) > limits[is_length]]
    if not names:
        return []
    change, is_length = changes[names[0]]
    much = f"{change:+.1f} mm" if is_length else f"{np.rad2deg(change):+.1f} deg"
    return [f"{names[0]} would change by {much}, which no arm is off by: check units, conventions and the arm file"]


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


IN_RADIANS = "angles in radians, expected degrees"
ORIENTATION_SLIPS: dict[str, Callable[[FloatArray], FloatArray]] = {
    "quaternions in the order w, x, y, z; expected x, y, z, w": lambda R: rotation_from_quaternion(
        np.roll(quaternion_from_rotation(R), -1, axis=-1)
    ),
    "rotations from the base to the flange; expected the flange's orientation in the base": lambda R: R.swapaxes(1, 2),
    IN_RADIANS: lambda R: rotation_from_zyx(*np.rad2deg(zyx_angles(R)).T),  # such rotations are below seven degrees
}
"""Usual slips, and what undoes them."""
