"""From taught points or touches to the pose of the part: fits, their proof, their error, and wrong observations."""

from wpcal.calibrate.criteria import CriteriaComparison, Criterion, FitProblem, FitSummary
from wpcal.calibrate.distrust import Distrusted, compare_without
from wpcal.calibrate.points.annealed import anneal_pairs
from wpcal.calibrate.points.least_squares import fit_least_squares, weighted_rms_bound
from wpcal.calibrate.points.minimax import MinimaxSolution, solve_minimax
from wpcal.calibrate.points.problem import PointProblem
from wpcal.calibrate.points.robust import RobustSolution, fit_robust
from wpcal.calibrate.points.weighted import fit_weighted
from wpcal.calibrate.result import CalibrationResult
from wpcal.calibrate.solve import calibrate
from wpcal.calibrate.solver_report import Solver, SolverReport
from wpcal.calibrate.suspect import Exchange, Suspect
from wpcal.calibrate.touches import Touches
from wpcal.calibrate.touches.evidence import HeldMotion, StartsEvidence, TouchEvidence
from wpcal.calibrate.uncertainty import Sigma, SigmaSource, TeachingError
from wpcal.calibrate.verdict import Verdict, VerdictKind, VerdictReason

__all__ = [
    "CalibrationResult",
    "CriteriaComparison",
    "Criterion",
    "Distrusted",
    "Exchange",
    "FitProblem",
    "FitSummary",
    "HeldMotion",
    "MinimaxSolution",
    "PointProblem",
    "RobustSolution",
    "Sigma",
    "SigmaSource",
    "Solver",
    "SolverReport",
    "StartsEvidence",
    "Suspect",
    "TeachingError",
    "TouchEvidence",
    "Touches",
    "Verdict",
    "VerdictKind",
    "VerdictReason",
    "anneal_pairs",
    "calibrate",
    "compare_without",
    "fit_least_squares",
    "fit_robust",
    "fit_weighted",
    "solve_minimax",
    "weighted_rms_bound",
]
