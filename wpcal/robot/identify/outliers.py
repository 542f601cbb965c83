r"""Measured poses that the others contradict: found by deletion, named, and kept from bending the arm.

The rows of one pose form a block (several reflectors, or position and turn). With the whitened residuals
:math:`r_g` of a block and its part :math:`H_{gg}` of the hat matrix, deleting the block lowers the sum of squares by
:math:`d_g = r_g^\top (I - H_{gg})^{-1} r_g`. Under normal noise

.. math:: F_g = \frac{d_g / m}{(S - d_g) / (f - m)} \sim F(m, f - m)

with the m rows of the block, the sum of squares S and f degrees of freedom. The worst block, and those that stand out
nearly as much, are deleted, and the others are fitted and tested again, so that one outlier does not hide another.

Also here: which measured poses are fitted and which are kept back for the test.

References: Cook, Weisberg (1982), Residuals and Influence in Regression, chapter 2.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from scipy.stats import chi2, f

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.core.wording import short
from wpcal.robot.identify.least_squares import LeastSquaresFit
from wpcal.robot.identify.observations import PoseObservations
from wpcal.robot.identify.pose_residuals import evaluate

FALSE_ALARM = 0.01  #: Share of clean files in which a pose is named: the tests of all poses together (Bonferroni).
LARGEST_SHARE = 0.1
"""At most this share of the poses is named; more of them are not outliers but another kind of noise."""
LEAST_AS_FAR = 0.02
"""Poses are named together if each lowers the sum of squares by this share of the worst one, or by the share that the
parameters have in the measured numbers: by this much a far pose bends the arm, which makes sound poses stand out."""
HUBER = 1.5
"""A named pose keeps its direction of pull but only the force of a residual of this many standard deviations: 95 % of
the efficiency of least squares under normal noise, at a bounded influence (Huber 1964)."""


@dataclass(frozen=True, slots=True)
class OutlierPose:
    """A pose that the others contradict."""

    rows: tuple[int, ...]  #: Its lines in the file.
    #: How far the measured position is from the arm fitted without this pose (the largest of its rows), mm.
    distance_mm: float
    turn_deg: float | None  #: The same for the orientation, degrees.
    held_back: bool  #: Whether the pose was a test pose; it then never bent the fit.

    def __str__(self) -> str:
        lines = f"row {self.rows[0]}" if len(self.rows) == 1 else f"rows {', '.join(map(str, self.rows))}"
        turn = "" if self.turn_deg is None else f" and {short(self.turn_deg)} deg"
        where = "kept back for the test" if self.held_back else "fitted with little weight"
        return f"{lines}: {short(self.distance_mm)} mm{turn} off what the other poses give; {where}"


def deletion_chances(fit: LeastSquaresFit, observations: PoseObservations) -> tuple[IntArray, FloatArray, FloatArray]:
    """Return how likely normal noise makes a pose stand out as each does.

    Returns `poses`: ndarray of int, shape (G,). The poses with weight one.
    Returns `chances`: ndarray, shape (G,). The probability of an F as large, for one pose.
    Returns `drop`: ndarray, shape (G,). By how much its deletion lowers the sum of squares.
    """
    block = np.repeat(observations.poses, 6 if observations.has_orientations else 3)
    full = np.repeat(observations.weights, 6 if observations.has_orientations else 3) == 1.0
    Q = fit.prior.split(fit.jacobian)[0]
    total = float(np.sum(fit.residuals[full] ** 2))
    freedom = int(full.sum()) - len(fit.parameters)
    poses = np.unique(observations.poses[observations.weights == 1.0])
    drop, rows = np.empty(len(poses)), np.empty(len(poses))
    for k, pose in enumerate(poses):
        own = np.flatnonzero(block == pose)
        H = Q[own] @ Q[own].T
        drop[k] = fit.residuals[own] @ np.linalg.lstsq(np.eye(len(H)) - H, fit.residuals[own], rcond=None)[0]
        rows[k] = len(own)
    F = (drop / rows) / (np.maximum(total - drop, np.finfo(float).tiny) / np.maximum(freedom - rows, 1.0))
    spread = np.median(drop / chi2.median(rows)) * freedom / total  # above one where rows of a pose are off together
    chances = f.sf(F / max(1.0, spread), rows, np.maximum(freedom - rows, 1.0))
    return poses, np.asarray(chances, dtype=np.float64), drop


def find_outliers(
    fit: Callable[[PoseObservations], LeastSquaresFit], observations: PoseObservations
) -> tuple[IntArray, LeastSquaresFit]:
    """Find the poses that the others contradict, worst first.

    Returns `poses`: ndarray of int, shape (k,).
    Returns `without`: LeastSquaresFit. The fit in which these poses have no weight.
    """
    most, seen = math.ceil(LARGEST_SHARE * len(np.unique(observations.poses))), observations
    named: list[int] = []
    found = fit(seen)
    while len(named) < most:
        poses, chances, drop = deletion_chances(found, seen)
        out = np.flatnonzero(chances * len(poses) < FALSE_ALARM)
        if not len(out):
            break
        out = out[np.argsort(-drop[out], kind="stable")]
        as_far = max(LEAST_AS_FAR, len(found.parameters) / len(found.residuals))
        out = out[drop[out] >= as_far * drop[out[0]]][: most - len(named)]
        named += poses[out].tolist()
        seen = observations.weighted(np.where(np.isin(observations.poses, named), 0.0, 1.0))
        found = fit(seen)
    return np.array(named, dtype=np.int64), found


def huber_weights(distances: FloatArray, poses: IntArray, named: IntArray) -> FloatArray:
    """Return the weights of rows: one, and less for the rows of named poses, shape (N,).

    `distances`: shape (N,). Root mean square of the whitened residuals of each row, in a fit without the named poses.
    `poses`: shape (N,). The pose of each row.
    `named`: ndarray of int, shape (k,).
    """
    weights = np.ones(len(poses))
    for pose in named:
        own = poses == pose
        size = float(np.sqrt(np.mean(distances[own] ** 2)))
        weights[own] = min(1.0, HUBER / max(size, HUBER))
    return weights


def unexpected_poses(fit: LeastSquaresFit, theta: FloatArray, observations: PoseObservations) -> list[int]:
    """Return the poses, among some that were not fitted, that the fit does not expect.

    `theta`: shape (N, n). Model angles of the rows, rad.
    """
    at = evaluate(fit.model, fit.prior, theta, observations, fit.noise)
    block = np.repeat(observations.poses, len(at.r) // len(observations))
    poses = np.unique(observations.poses)
    distance, rows = np.empty(len(poses)), np.empty(len(poses))
    for k, pose in enumerate(poses):
        own = block == pose
        V = np.eye(int(own.sum())) + at.J[own] @ fit.covariance @ at.J[own].T
        distance[k], rows[k] = at.r[own] @ np.linalg.solve(V, at.r[own]), own.sum()
    spread = max(1.0, float(np.median(distance / chi2.median(rows))))
    chances = f.sf(distance / rows / spread, rows, fit.degrees_of_freedom)
    return [int(pose) for pose in poses[chances * len(poses) < FALSE_ALARM]]


TEST_SHARE = 20 / 70  #: Share of the poses kept back for the test: the paper's 20 of 70.


def split_poses(observations: PoseObservations, test: BoolArray | None, seed: int) -> tuple[IntArray, IntArray]:
    """Return the rows to fit and the rows to keep back; reflectors of one pose stay together.

    `test`: shape (N,). Rows to keep back; drawn with the seed unless given.
    """
    if test is not None:
        return np.flatnonzero(~test), np.flatnonzero(test)
    poses = observations.poses
    count = poses.max() + 1
    kept_back = max(1, round(TEST_SHARE * count))
    chosen = np.random.default_rng(seed).permutation(count)[:kept_back]
    away = np.isin(poses, chosen)
    return np.flatnonzero(~away), np.flatnonzero(away)


def fold_rows(observations: PoseObservations, folds: int, seed: int) -> Iterator[IntArray]:
    """Yield the rows of each fold; as many folds as poses leave one out at a time.

    Raises `InputError` when there are fewer than two folds, or more folds than poses.
    """
    poses = observations.poses
    count = int(poses.max()) + 1
    if not 2 <= folds <= count:
        raise InputError(f"expected 2 to {count} folds for {count} poses, got {folds}")
    order = np.random.default_rng(seed).permutation(count)
    for fold in range(folds):
        yield np.flatnonzero(np.isin(poses, order[fold::folds]))


def without_rows(
    observations: PoseObservations, test: BoolArray | None, lines: tuple[int, ...]
) -> tuple[PoseObservations, BoolArray | None]:
    """Return the measurements without some lines of their file.

    `test`: shape (N,). Rows to keep back.
    Raises `InputError` when a line holds no measured pose.
    """
    unknown = sorted(set(lines) - set(observations.rows))
    if unknown:
        raise InputError(f"row {unknown[0]} holds no measured pose; rows are lines of the file")
    keep = ~np.isin(observations.rows, lines)
    return observations.select(np.flatnonzero(keep)), None if test is None else test[keep]
