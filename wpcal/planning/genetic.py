"""The published way: a multi-objective genetic algorithm, here NSGA-II as pymoo has it, on smooth paths.

References
----------
Hou, Wang, Yue, Jia 2018, §2; its operators are lost in the text at hand. Deb, Pratap, Agarwal, Meyarivan 2002 for
NSGA-II; Blank, Deb 2020 for pymoo.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.planning.linear_model import Path
from wpcal.planning.problem import PlanningProblem
from wpcal.planning.sweep import Progress
from wpcal.planning.waves import CONSTRAINTS, DecodedPaths, decode_paths, encode_path, gene_box, random_genes

SEED_NOISE = 0.02
"""Spread of copies of the seeds, in parts of the genes' ranges: near enough to stay allowed as a rule."""
RANDOM_SHARE = 0.2
"""Part of a seeded population that is random, so that the algorithm is not bound to the seeds' branches."""


@dataclass(frozen=True, slots=True)
class GeneticOptions:
    """How long the genetic algorithm runs, and from what.

    Parameters
    ----------
    population, generations : int
    seed : int
        Of every random number.
    seeded : bool
        Whether the deterministic front is part of the first population.

    Raises
    ------
    InputError
        When a number is too small.
    """

    population: int = 100
    generations: int = 200
    seed: int = 0
    seeded: bool = True

    def __post_init__(self) -> None:
        if self.population < 4 or self.generations < 1 or self.seed < 0:
            raise InputError("the genetic algorithm needs a population of at least 4 and one generation")


def evolve_paths(
    problem: PlanningProblem, seeds: Sequence[Path], options: GeneticOptions, progress: Progress
) -> tuple[list[Path], bool]:
    """Run NSGA-II.

    Parameters
    ----------
    problem : PlanningProblem
    seeds : sequence of Path
        The deterministic front.
    options : GeneticOptions
    progress : callable

    Returns
    -------
    paths : list of Path
        Those of the last population that are allowed.
    interrupted : bool
        Whether the user ended it early.

    Raises
    ------
    InputError
        When pymoo is not installed.
    """
    try:
        from pymoo.algorithms.moo.nsga2 import NSGA2  # noqa: PLC0415  # an optional extra, slow to import
        from pymoo.core.evaluator import Evaluator  # noqa: PLC0415
        from pymoo.core.problem import Problem  # noqa: PLC0415
        from pymoo.problems.static import StaticProblem  # noqa: PLC0415
    except ImportError:
        raise InputError("the genetic algorithm needs pymoo: install wpcal[planning]") from None
    least, largest = gene_box(problem)
    rng = np.random.default_rng(options.seed)
    start = first_population(problem, seeds if options.seeded else (), options.population, rng)
    task = Problem(n_var=len(least), n_obj=3, n_ieq_constr=len(CONSTRAINTS), xl=least, xu=largest)
    algorithm: Any = NSGA2(pop_size=options.population, sampling=start)
    algorithm.setup(task, termination=("n_gen", options.generations), seed=options.seed, verbose=False)
    interrupted = False
    try:
        for generation in range(options.generations):
            progress("breeding paths", generation, options.generations)
            asked = algorithm.ask()
            F, G = judged(problem, decode_paths(problem, asked.get("X")))
            Evaluator().eval(StaticProblem(task, F=F, G=G), asked)
            algorithm.tell(infills=asked)
    except KeyboardInterrupt:
        interrupted = True
    last = decode_paths(problem, algorithm.pop.get("X")) if algorithm.pop is not None else None
    if last is None:
        return [], interrupted
    return [last.path(int(row)) for row in np.flatnonzero((last.violations <= 0).all(axis=1))], interrupted


def first_population(
    problem: PlanningProblem, seeds: Sequence[Path], population: int, rng: np.random.Generator
) -> FloatArray:
    """Return the genes of a first population: the seeds, noisy copies of them, and random smooth paths."""
    genes = random_genes(problem, population, rng)
    if not seeds:
        return genes
    least, largest = gene_box(problem)
    given = np.stack([encode_path(problem, path) for path in seeds])[:population]
    copies = given[np.arange(round((1.0 - RANDOM_SHARE) * population)) % len(given)]
    noise = SEED_NOISE * (largest - least) * rng.normal(size=copies.shape)
    noise[: len(given)], noise[:, -2:] = 0.0, 0.0
    genes[: len(copies)] = np.clip(copies + noise, least, largest)
    return genes


def judged(problem: PlanningProblem, decoded: DecodedPaths) -> tuple[FloatArray, FloatArray]:
    """Return objectives (N, 3) and violations (N, 5) of decoded paths."""
    return problem.objectives(decoded.coordinates, decoded.joints), decoded.violations
