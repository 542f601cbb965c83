"""The published method: a multi-objective genetic algorithm on smooth paths. Here it is NSGA-II from pymoo.

References
----------
Hou, Wang, Yue, Jia 2018, §2; the text at hand has lost its operators. Deb, Pratap, Agarwal, Meyarivan 2002 for
NSGA-II; Blank, Deb 2020 for pymoo.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.options import opt
from wpcal.planning.search.ga_variation import CONSTRAINTS, PathEncoding
from wpcal.planning.search.objectives import OBJECTIVES
from wpcal.planning.search.pareto import is_nondominated, thin_front
from wpcal.planning.search.problem import CandidatePath, PlanningProblem, SearchProgress

POOL = 20
"""Random paths per path of an unseeded population. One in some hundreds is allowed, and a few are enough to start."""
LARGEST_ARCHIVE = 300
"""Paths that are kept while it runs: comparing all of them with a generation then takes milliseconds."""
MOST_PATHS = 60  #: Paths that are returned, spread over the front: more than a person wants to choose from.


@dataclass(frozen=True, slots=True)
class Nsga2Options:
    """How long NSGA-II runs, and what it starts from.

    Raises `InputError` when a number is too small.
    """

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
    """Run NSGA-II.

    Raises `InputError` when pymoo is not installed.
    """
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
        n_var=len(code.least),
        n_obj=len(OBJECTIVES),
        n_ieq_constr=len(CONSTRAINTS),
        xl=code.least,
        xu=code.largest,
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
