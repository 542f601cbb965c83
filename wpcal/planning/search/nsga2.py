"""The published method: a multi-objective genetic algorithm on smooth paths. Here it is NSGA-II from pymoo.

Also here: paths as genes: a base path, the change of each coordinate along the seam, and the branches of both inverses.

A coordinate at u = s / L is that of the base plus ``c_0 + c_1 (u - 1/2) + sum_m c_{m+1} sin(m π u)``: a level, a drift
and eight sine terms. These numbers are used instead of the knots of a curve because a mix of two smooth parents is
then smooth, while a mix of their knots is jagged. Short sine terms are seldom of use and get a small range. The bases
are the paths of a deterministic front, or there are none; between two bases the base is their weighted mean. Limits of
place, slope, rotation and torch angles are kept by clipping. Closed chain and inverses are exact for all genes.

References: Hou, Wang, Yue, Jia 2018, §2; the text at hand has lost its operators. Deb, Pratap, Agarwal, Meyarivan 2002
for NSGA-II; Blank, Deb 2020 for pymoo.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.core.arrays import BoolArray, FloatArray, IntArray
from wpcal.core.errors import InputError
from wpcal.core.options import opt
from wpcal.core.same_bits import product, sine
from wpcal.planning.cell.clearance import capsule_clearance
from wpcal.planning.cell.closed_chain import COORDINATES, PLACE, SPIN, YAW, all_joints, flange_poses
from wpcal.planning.cell.shape import JOINTS
from wpcal.planning.cell.workplace import LEAST_REGULARITY, reach_shortage
from wpcal.planning.search.objectives import OBJECTIVES
from wpcal.planning.search.pareto import is_nondominated, thin_front
from wpcal.planning.search.problem import CandidatePath, PlanningProblem, SearchProgress
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
    margin = np.where(there, capsule_clearance(problem.cell, flat).margin_mm.reshape(missing.shape), np.inf)
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


POOL = 20
"""Random paths per path of an unseeded population. One in some hundreds is allowed, and a few are enough to start."""
LARGEST_ARCHIVE = 300
"""Paths that are kept while it runs: comparing all of them with a generation then takes milliseconds."""
MOST_PATHS = 60  #: Paths that are returned, spread over the front: more than a person wants to choose from.


@dataclass(frozen=True, slots=True)
class Nsga2Options:
    """How long NSGA-II runs, and what it starts from. Raises `InputError` when a number is too small."""

    population: int = opt(100, "Population of NSGA-II.", least=4)
    generations: int = 200
    seed: int = opt(0, "Seed of all random numbers.", least=0)
    seeded: bool = True  #: Whether the deterministic front is part of the first population.

    def __post_init__(self) -> None:
        if self.population < 4 or self.generations < 1 or self.seed < 0:
            raise InputError("the genetic algorithm needs a population of at least 4 and one generation")


def evolve_paths(
    problem: PlanningProblem, seeds: Sequence[CandidatePath], options: Nsga2Options, progress: SearchProgress
) -> tuple[list[CandidatePath], bool]:
    """Run NSGA-II. Raises `InputError` when pymoo is not installed."""
    try:
        from pymoo.algorithms.moo.nsga2 import NSGA2  # noqa: PLC0415  # an optional extra, slow to import
        from pymoo.core.evaluator import Evaluator  # noqa: PLC0415
        from pymoo.core.problem import Problem  # noqa: PLC0415
        from pymoo.problems.static import StaticProblem  # noqa: PLC0415
    except ImportError:
        raise InputError("the genetic algorithm needs pymoo: install wpcal[planning]") from None
    code = PathEncoding.of_seeds(problem, seeds if options.seeded else ())
    start = first_population(code, options.population, np.random.default_rng(options.seed))
    task = Problem(
        n_var=len(code.least), n_obj=len(OBJECTIVES), n_ieq_constr=len(CONSTRAINTS), xl=code.least, xu=code.largest
    )
    kept = Archive.empty(len(code.least))
    algorithm: Any = NSGA2(pop_size=options.population, sampling=start)
    algorithm.setup(task, termination=("n_gen", options.generations), seed=options.seed, verbose=False)
    interrupted = False
    try:
        for generation in range(options.generations):
            progress("breeding paths", generation, options.generations)
            asked = algorithm.ask()
            genes = asked.get("X")
            decoded = code.decode(genes)
            values = problem.objectives(decoded.coordinates, decoded.joints)
            Evaluator().eval(StaticProblem(task, F=values, G=decoded.violations), asked)
            algorithm.tell(infills=asked)
            allowed = (decoded.violations <= 0).all(axis=1)
            kept = kept.joined(genes[allowed], values[allowed])
    except KeyboardInterrupt:
        interrupted = True
    if len(kept.genes) == 0:
        return [], interrupted
    best = code.decode(kept.genes[thin_front(kept.values, MOST_PATHS)])
    return [best.path(row) for row in range(len(best.coordinates))], interrupted


@dataclass(frozen=True, slots=True, eq=False)
class Archive:
    """The best allowed paths so far. NSGA-II loses some of them when it thins a crowded population."""

    genes: FloatArray  #: shape (m, g).
    values: FloatArray  #: shape (m, k). Objectives of the m paths.

    @classmethod
    def empty(cls, genes: int) -> Archive:
        """Return an archive without paths; `genes` is the number of genes per path."""
        return cls(np.zeros((0, genes)), np.zeros((0, len(OBJECTIVES))))

    def joined(self, genes: FloatArray, values: FloatArray) -> Archive:
        """Return the best of these paths and of new ones, with genes of shape (m, g) and objectives of shape (m, k)."""
        both = np.concatenate([self.genes, genes]), np.concatenate([self.values, values])
        rows = np.flatnonzero(is_nondominated(both[1]))
        if len(rows) > LARGEST_ARCHIVE:
            rows = rows[thin_front(both[1][rows], LARGEST_ARCHIVE)]
        return Archive(both[0][rows], both[1][rows])


def first_population(code: PathEncoding, population: int, rng: np.random.Generator) -> FloatArray:
    """Return the genes of a first population, shape (population, g).

    With bases: the bases unchanged, and random paths near them. Without bases: of `POOL` times as many random smooth
    paths, those that violate least.
    """
    if len(code.bases) > 1:
        genes, given = code.random(population, rng), code.of_bases()[:population]
        genes[: len(given)] = given
        return genes
    pool = [code.random(population, rng) for _ in range(POOL)]
    violated = np.concatenate([np.maximum(code.decode(genes).violations, 0.0).sum(axis=1) for genes in pool])
    return np.concatenate(pool)[np.argsort(violated, kind="stable")[:population]]
