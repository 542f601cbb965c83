"""Paths as genes: each coordinate is a level, a drift and some waves along the seam, and two genes choose the branches.

A coordinate at u = s / L is ``c_0 + c_1 (u - 1/2) + sum_m c_{m+1} sin(m π u)``. The numbers stand for the knots of a
smooth curve: a mix of two parents is then as smooth as they are, where a mix of their knots is jagged; and short waves,
which are seldom of use, get a small range. Limits of place, slope, rotation and torch angles hold by cutting off;
closed chain and inverses are exact whatever the genes are.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.planning.cell import JOINTS
from wpcal.planning.closed_chain import COORDINATES, PLACE, SPIN, YAW, all_joints, flange_poses
from wpcal.planning.linear_model import Path
from wpcal.planning.problem import PlanningProblem
from wpcal.planning.singularity import LEAST_REGULARITY
from wpcal.planning.workplace import reach_shortage
from wpcal.robot.inverse import TURN
from wpcal.robot.opw import BRANCHES

WAVES = 10
"""Numbers of a coordinate: the paths of the least squares are met within some tenths of a degree."""
DRIFT_MM, DRIFT_RAD = 600.0, 8.0
"""Ranges of the drift of the place, and of yaw and spin: a turn all around with some to spare. The m-th wave has the
(m + 1)-th part of it."""
RANDOM_WAVE = 0.15
"""Standard deviation of the waves of a random path, in parts of their ranges: most paths hardly move."""
CONSTRAINTS = ("reach", "joint limits", "singular poses", "joint speeds", "clearance")
"""Violations of decoded paths, each about one for a bad path: by 100 mm, 1 rad, the whole measure, twice the speed, and
100 mm."""
HUNDRED_MM = 100.0
"""Unit of the violations that are lengths."""


@dataclass(frozen=True, slots=True, eq=False)
class DecodedPaths:
    """N paths that genes stand for.

    Parameters
    ----------
    coordinates : ndarray, shape (N, n, 9)
    branches : ndarray of int, shape (N, 2)
    joints : ndarray, shape (N, n, 12)
        Unwrapped, rad; zero where a branch does not reach.
    violations : ndarray, shape (N, 5)
        In the order of `CONSTRAINTS`; zero or less where a path is allowed.
    """

    coordinates: FloatArray
    branches: IntArray
    joints: FloatArray
    violations: FloatArray

    def path(self, row: int) -> Path:
        """Return one of them."""
        one, two = self.branches[row]
        return Path(self.coordinates[row], (int(one), int(two)), self.joints[row])


def gene_box(problem: PlanningProblem) -> tuple[FloatArray, FloatArray]:
    """Return the least and largest genes, shape (9 WAVES + 2,) each: waves coordinate by coordinate, then branches."""
    low, high = problem.box
    low[[YAW, SPIN]], high[[YAW, SPIN]] = -TURN, TURN
    first = high - low
    first[PLACE], first[[YAW, SPIN]] = DRIFT_MM, DRIFT_RAD
    waves = first[:, None] / np.arange(1, WAVES)
    least = np.concatenate([np.column_stack([low, -waves]).ravel(), (0.0, 0.0)])
    largest = np.concatenate([np.column_stack([high, waves]).ravel(), (BRANCHES, BRANCHES)])
    return least, largest


def random_genes(problem: PlanningProblem, count: int, rng: np.random.Generator) -> FloatArray:
    """Return genes of random smooth paths, shape (count, 9 WAVES + 2)."""
    least, largest = gene_box(problem)
    genes = rng.uniform(least, largest, (count, len(least)))
    waves = genes[:, :-2].reshape(count, COORDINATES, WAVES)
    waves[:, :, 1:] = rng.normal(0.0, RANDOM_WAVE, waves[:, :, 1:].shape) * largest[:-2].reshape(-1, WAVES)[:, 1:]
    return np.asarray(np.clip(genes, least, largest), dtype=np.float64)


def encode_path(problem: PlanningProblem, path: Path) -> FloatArray:
    """Return the genes of the waves nearest to a path, shape (9 WAVES + 2,)."""
    waves, *_ = np.linalg.lstsq(_waves(problem), path.coordinates, rcond=None)
    least, largest = gene_box(problem)
    waves[0, [YAW, SPIN]] -= TURN * np.rint(waves[0, [YAW, SPIN]] / TURN)
    genes = np.concatenate([waves.T.ravel(), np.array(path.branches) + 0.5])
    return np.asarray(np.clip(genes, least, largest), dtype=np.float64)


def _waves(problem: PlanningProblem) -> FloatArray:
    """Level, drift and waves at the points of the seam, shape (n, WAVES)."""
    s = problem.path.s_mm
    u = (s - s[0]) / (s[-1] - s[0])
    waves = np.sin(np.pi * np.arange(1, WAVES - 1) * u[:, None])
    return np.column_stack([np.ones(len(s)), u - 0.5, waves])


def decode_paths(problem: PlanningProblem, genes: FloatArray) -> DecodedPaths:
    """Compute the paths of N sets of genes, and what they violate.

    Parameters
    ----------
    problem : PlanningProblem
    genes : ndarray, shape (N, 9 WAVES + 2)
    """
    count, n = len(genes), len(problem.path)
    coefficients = genes[:, :-2].reshape(count, COORDINATES, WAVES)
    coordinates: FloatArray = np.swapaxes(coefficients @ _waves(problem).T, 1, 2).copy()
    coordinates = np.clip(coordinates, *problem.box)
    branches = np.clip(np.floor(genes[:, -2:]), 0, BRANCHES - 1).astype(np.int64)
    rows = problem.path.select(np.tile(np.arange(n), count))
    flat = coordinates.reshape(-1, COORDINATES)
    one, two = all_joints(problem.cell, rows, flat)
    point = np.arange(count * n)
    both = np.concatenate(
        [one[point, np.repeat(branches[:, 0], n)], two[point, np.repeat(branches[:, 1], n)]], axis=1
    ).reshape(count, n, 2 * JOINTS)
    missing = ~np.isfinite(both).all(axis=2)
    joints = _turned_into_limits(problem, np.where(missing[:, :, None], 0.0, both))
    short = np.zeros(count * n)
    if missing.any():
        lost = missing.ravel()
        flanges = flange_poses(problem.cell, rows.select(np.flatnonzero(lost)), flat[lost])
        arms = (problem.cell.arm1, problem.cell.arm2)
        short[lost] = 1.0 + sum(reach_shortage(arm, T) for arm, T in zip(arms, flanges, strict=True))
    violations = _violations(problem, joints, missing, short.reshape(count, n))
    return DecodedPaths(coordinates, branches, joints, violations)


def _turned_into_limits(problem: PlanningProblem, joints: FloatArray) -> FloatArray:
    """Unwrap joints (N, n, 12) along the paths, and turn each as a whole to the middle of its limits."""
    unwrapped = np.unwrap(joints, axis=1)
    low, high = problem.joint_limits
    middle: FloatArray = (unwrapped.min(axis=1) + unwrapped.max(axis=1)) / 2
    return np.asarray(unwrapped + TURN * np.rint(((low + high) / 2 - middle) / TURN)[:, None], dtype=np.float64)


def _violations(problem: PlanningProblem, joints: FloatArray, missing: BoolArray, short: FloatArray) -> FloatArray:
    low, high = problem.joint_limits
    flat, there = joints.reshape(-1, 2 * JOINTS), ~missing
    margin = np.where(there, problem.margins(flat).reshape(missing.shape), np.inf)
    regular = np.where(there, problem.regularity(flat).min(axis=1).reshape(missing.shape), np.inf)
    beyond = np.where(there, np.maximum(joints - high, low - joints).max(axis=2), -np.inf)
    rates = np.abs(np.diff(joints, axis=1)) / np.diff(problem.path.s_mm)[:, None] * problem.speed_mm_s
    columns = (
        short.mean(axis=1) / HUNDRED_MM,
        beyond.max(axis=1),
        LEAST_REGULARITY - regular.min(axis=1),
        (rates / problem.joint_speeds).max(axis=(1, 2)) - 1.0,
        -margin.min(axis=1) / HUNDRED_MM,
    )
    return np.stack(columns, axis=1)
