"""Which measured poses are fitted and which are kept back for the test."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from wpcal.core.arrays import BoolArray, IntArray
from wpcal.core.errors import InputError
from wpcal.robot.identify.observations import PoseObservations

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
