"""Weldments whose plates moved: the pose of the whole, and a small motion of every body, from touches and priors."""

from wpcal.calibrate.bodies.bodies import Bodies, TackTolerance
from wpcal.calibrate.bodies.evidence import MotionEvidence, judge_motion
from wpcal.calibrate.bodies.fit import BodiesFit, fit_bodies
from wpcal.calibrate.bodies.motions import Motions

__all__ = ["Bodies", "BodiesFit", "MotionEvidence", "Motions", "TackTolerance", "fit_bodies", "judge_motion"]
