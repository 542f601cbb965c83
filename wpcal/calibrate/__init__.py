"""From point pairs to the part's place: fits, their proof, their error, and what is wrong with the points."""

from wpcal.calibrate.criteria import CriteriaComparison, Criterion
from wpcal.calibrate.distrust import Distrusted, FitSummary, compare_without
from wpcal.calibrate.least_squares import fit_least_squares, weighted_rms_bound
from wpcal.calibrate.minimax import MinimaxSolution, solve_minimax
from wpcal.calibrate.pairs_file import read_pairs
from wpcal.calibrate.result import CalibrationResult, Solver, SolverReport
from wpcal.calibrate.robust import RobustSolution, fit_robust
from wpcal.calibrate.solve import anneal_pairs, calibrate
from wpcal.calibrate.uncertainty import TeachingError
from wpcal.calibrate.weighted import fit_weighted

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
    "read_pairs",
    "solve_minimax",
    "weighted_rms_bound",
]
