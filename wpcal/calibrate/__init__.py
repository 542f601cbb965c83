"""From point pairs to the part's place: fits, their proof, their error, and what is wrong with the points."""

from wpcal.calibrate.criteria import CriteriaComparison, Criterion
from wpcal.calibrate.distrust import Distrusted, FitSummary, compare_without
from wpcal.calibrate.points.least_squares import fit_least_squares, weighted_rms_bound
from wpcal.calibrate.points.minimax import MinimaxSolution, solve_minimax
from wpcal.calibrate.points.robust import RobustSolution, fit_robust
from wpcal.calibrate.points.weighted import fit_weighted
from wpcal.calibrate.result import CalibrationResult, Solver, SolverReport
from wpcal.calibrate.solve import anneal_pairs, calibrate
from wpcal.calibrate.uncertainty import TeachingError

__all__ = [
    "CalibrationResult",
    "CriteriaComparison",
    "Criterion",
    "Distrusted",
    "FitSummary",
    "MinimaxSolution",
    "RobustSolution",
    "Solver",
    "SolverReport",
    "TeachingError",
    "anneal_pairs",
    "calibrate",
    "compare_without",
    "fit_least_squares",
    "fit_robust",
    "fit_weighted",
    "solve_minimax",
    "weighted_rms_bound",
]
