"""From taught points or touches to the pose of the part: fits, their proof, their error, and wrong observations."""

from wpcal.calibrate.errors.prediction import Sigma, SigmaSource, TeachingError
from wpcal.calibrate.observe.points import PointProblem
from wpcal.calibrate.observe.touches import Touches
from wpcal.calibrate.result import CalibrationResult
from wpcal.calibrate.run import calibrate
from wpcal.calibrate.solve.annealed import anneal_pairs
from wpcal.calibrate.solve.least_squares import fit_least_squares
from wpcal.calibrate.solve.minimax import MinimaxSolution, solve_minimax
from wpcal.calibrate.solve.weighted import fit_weighted
from wpcal.calibrate.solver_report import Solver, SolverReport
from wpcal.calibrate.trust.blame import Exchange, Suspect
from wpcal.calibrate.trust.criteria import CriteriaComparison, Criterion, FitProblem, FitSummary
from wpcal.calibrate.trust.touch_evidence import HeldMotion, StartsEvidence, TouchEvidence
from wpcal.calibrate.trust.verdict import Verdict, VerdictKind, VerdictReason
from wpcal.calibrate.trust.without import Distrusted, compare_without
from wpcal.optim.annealing import AnnealingSchedule as AnnealingSchedule  # documented in wpcal.optim

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
    "fit_weighted",
    "solve_minimax",
]
