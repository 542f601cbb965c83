"""Paths as genes: a base path, the change of each of its coordinates along the seam, and the branches of both inverses.

A coordinate at u = s / L is that of the base plus ``c_0 + c_1 (u - 1/2) + sum_m c_{m+1} sin(m π u)``: a level, a drift
and eight sine terms. These numbers are used instead of the knots of a curve because a mix of two smooth parents is
then smooth, while a mix of their knots is jagged. Short sine terms are seldom of use and get a small range. The bases
are the paths of a deterministic front, or there are none; between two bases the base is their weighted mean. Limits of
place, slope, rotation and torch angles are kept by clipping. Closed chain and inverses are exact for all genes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.same_bits import product, sine
from wpcal.planning.cell.closed_chain import COORDINATES, PLACE, SPIN, YAW, all_joints, flange_poses
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.cell.singularity import LEAST_REGULARITY
from wpcal.planning.cell.workplace import reach_shortage
from wpcal.planning.search.problem import CandidatePath, PlanningProblem
from wpcal.robot.kinematics.inverse import TURN
from wpcal.robot.kinematics.opw import BRANCHES

TERMS = 10  #: Numbers per coordinate: level, drift and eight sine terms.
DRIFT_MM, DRIFT_RAD = 600.0, 8.0
"""Ranges of the drift of the place, and of yaw and spin (more than a whole turn). The range of the m-th sine term is
this divided by m + 1."""
SEEDED_SPAN = 0.1  #: Near a base the ranges are multiplied by this: the search is for improvements of that path.
RANDOM_SPREAD = 0.15
"""Standard deviation of the drift and sine terms of a random path, in parts of their ranges: most paths hardly move."""
CONSTRAINTS = ("reach", "joint limits", "singular poses", "joint speeds", "clearance")
"""Violations of decoded paths, each about 1 for a bad path: 100 mm, 1 rad, the whole measure, twice the speed, and
100 mm."""
HUNDRED_MM = 100.0  #: Unit of the violations that are lengths.


@dataclass(frozen=True, slots=True, eq=False)
class DecodedPaths:
    """N paths that were decoded from genes."""

    coordinates: FloatArray  #: shape (N, n, 9).
    branches: IntArray  #: shape (N, 2).
    joints: FloatArray  #: shape (N, n, 12). Unwrapped, rad; zero where a branch does not reach.
    violations: FloatArray  #: shape (N, 5). In the order of `CONSTRAINTS`; zero or less where a path is allowed.

    def path(self, row: int) -> CandidatePath:
        """Return one of the N paths."""
        one, two = self.branches[row]
        return CandidatePath(self.coordinates[row], (int(one), int(two)), self.joints[row])


@dataclass(frozen=True, slots=True, eq=False)
class PathEncoding:
    """What genes mean. A path has 9 `TERMS` + 3 genes: `TERMS` numbers per coordinate, the base, and two branches."""

    problem: PlanningProblem
    #: shape (m, n, 9). Base paths; neighbours are similar. A single row of zeros means that there are none.
    bases: FloatArray
    branches: IntArray  #: shape (m, 2). Of robot 1 and robot 2, for each base.
    #: `least`, `largest`: shape (9 TERMS + 3,). Ranges of the genes.
    least: FloatArray
    largest: FloatArray

    @classmethod
    def of_seeds(cls, problem: PlanningProblem, seeds: Sequence[CandidatePath]) -> PathEncoding:
        """Return the encoding of paths near some base paths, or of all paths if there are no bases."""
        n, span = len(problem.path), SEEDED_SPAN if seeds else 1.0
        bases = np.stack([path.coordinates for path in seeds]) if seeds else np.zeros((1, n, COORDINATES))
        branches = np.array([path.branches for path in seeds] or [(0, 0)], dtype=np.int64)
        low, high = problem.box
        low[[YAW, SPIN]], high[[YAW, SPIN]] = -TURN, TURN
        drift = high - low
        drift[PLACE], drift[[YAW, SPIN]] = DRIFT_MM, DRIFT_RAD
        terms = span * drift[:, None] / np.arange(1, TERMS)
        if seeds:
            low, high = -span * (high - low), span * (high - low)
        ends = (max(len(bases) - 1.0, 1.0), BRANCHES, BRANCHES)
        return cls(
            problem,
            bases,
            branches,
            np.concatenate([np.column_stack([low, -terms]).ravel(), np.zeros(3)]),
            np.concatenate([np.column_stack([high, terms]).ravel(), ends]),
        )

    def random(self, count: int, rng: np.random.Generator) -> FloatArray:
        """Return genes of random smooth paths, shape (count, 9 TERMS + 3), near the bases if there are any.

        Without bases most paths hardly move along the seam.
        """
        genes = rng.uniform(self.least, self.largest, (count, len(self.least)))
        terms = genes[:, :-3].reshape(count, COORDINATES, TERMS)
        first = 1 if len(self.bases) == 1 else 0  # without bases every level is equally likely
        spread = self.largest[:-3].reshape(-1, TERMS)[:, first:]
        terms[:, :, first:] = RANDOM_SPREAD * spread * rng.normal(size=terms[:, :, first:].shape)
        if len(self.bases) > 1:
            genes[:, -2:] = self.branches[np.rint(genes[:, -3]).astype(np.int64)] + 0.5
        return np.asarray(np.clip(genes, self.least, self.largest), dtype=np.float64)

    def of_bases(self) -> FloatArray:
        """Return the genes of the base paths, shape (m, 9 TERMS + 3)."""
        genes = np.zeros((len(self.bases), len(self.least)))
        genes[:, -3], genes[:, -2:] = np.arange(len(self.bases)), self.branches + 0.5
        return genes

    def decode(self, genes: FloatArray) -> DecodedPaths:
        """Compute the paths of genes of shape (N, 9 TERMS + 3), and what they violate."""
        problem, count, n = self.problem, len(genes), len(self.problem.path)
        coordinates = np.clip(self._coordinates(genes), *problem.box)
        branches = np.clip(np.floor(genes[:, -2:]), 0, BRANCHES - 1).astype(np.int64)
        rows, flat = problem.path.select(np.tile(np.arange(n), count)), coordinates.reshape(-1, COORDINATES)
        one, two = all_joints(problem.cell, rows, flat)
        point, chosen = np.arange(count * n), np.repeat(branches, n, axis=0)
        both = np.concatenate([one[point, chosen[:, 0]], two[point, chosen[:, 1]]], axis=1)
        missing = ~np.isfinite(both).all(axis=1)
        short = np.zeros(count * n)
        if missing.any():
            flanges = flange_poses(problem.cell, rows.select(np.flatnonzero(missing)), flat[missing])
            arms = (problem.cell.arm, problem.cell.arm2)
            short[missing] = 1.0 + sum(reach_shortage(arm, T) for arm, T in zip(arms, flanges, strict=True))
        both[missing] = 0.0
        joints = _turned_into_limits(problem, both.reshape(count, n, 2 * JOINTS))
        violations = _violations(problem, joints, missing.reshape(count, n), short.reshape(count, n))
        return DecodedPaths(coordinates, branches, joints, violations)

    def _coordinates(self, genes: FloatArray) -> FloatArray:
        s = self.problem.path.s_mm
        u = (s - s[0]) / (s[-1] - s[0])
        shapes = np.column_stack([np.ones(len(s)), u - 0.5, sine(np.pi * np.arange(1, TERMS - 1) * u[:, None])])
        before = np.clip(np.floor(genes[:, -3]), 0, max(len(self.bases) - 2, 0)).astype(np.int64)
        part = (genes[:, -3] - before)[:, None, None]
        after = np.minimum(before + 1, len(self.bases) - 1)
        base = (1.0 - part) * self.bases[before] + part * self.bases[after]
        beside = product(genes[:, :-3].reshape(len(genes), COORDINATES, TERMS), shapes.T)
        return np.asarray(base + np.swapaxes(beside, 1, 2), dtype=np.float64)


def _turned_into_limits(problem: PlanningProblem, joints: FloatArray) -> FloatArray:
    """Unwrap joints (N, n, 12) along the paths, and turn each as a whole to the middle of its limits."""
    unwrapped = np.unwrap(joints, axis=1)
    low, high = problem.cell.limits
    middle: FloatArray = (unwrapped.min(axis=1) + unwrapped.max(axis=1)) / 2
    return np.asarray(unwrapped + TURN * np.rint(((low + high) / 2 - middle) / TURN)[:, None], dtype=np.float64)


def _violations(problem: PlanningProblem, joints: FloatArray, missing: BoolArray, short: FloatArray) -> FloatArray:
    low, high = problem.cell.limits
    flat, there = joints.reshape(-1, 2 * JOINTS), ~missing
    margin = np.where(there, problem.margins(flat).reshape(missing.shape), np.inf)
    regular = np.where(there, problem.regularity(flat).min(axis=1).reshape(missing.shape), np.inf)
    beyond = np.where(there, np.maximum(joints - high, low - joints).max(axis=2), -np.inf)
    rates = np.abs(np.diff(joints, axis=1)) / np.diff(problem.path.s_mm)[:, None] * problem.speed_mm_s
    columns = (
        short.mean(axis=1) / HUNDRED_MM,
        beyond.max(axis=1),
        LEAST_REGULARITY - regular.min(axis=1),
        (rates / problem.cell.speeds).max(axis=(1, 2)) - 1.0,
        -margin.min(axis=1) / HUNDRED_MM,
    )
    return np.stack(columns, axis=1)
