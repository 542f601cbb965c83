"""The verdict on a weldment whose bodies may have moved."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wpcal.calibrate.bodies.errors import MOST_POINTS, MeetingPoints, joint_error, meeting_errors, meeting_jacobian
from wpcal.calibrate.bodies.moved import MovedBodies
from wpcal.calibrate.verdict import Verdict, VerdictKind, VerdictReason
from wpcal.core.wording import listed


def judge_bodies(
    moved: MovedBodies, points: MeetingPoints, seam_names: Sequence[str], *, tolerance_mm: float
) -> Verdict:
    """Judge whether the seams are shown to be within the tolerance.

    Parameters
    ----------
    moved : MovedBodies
    points : MeetingPoints
        Points of the accepted seams; k of them.
    seam_names : sequence of str, length k
    tolerance_mm : float

    Returns
    -------
    Verdict
    """
    own = meeting_errors(moved.fit, points).total_mm
    worst = np.argsort(-own, kind="stable")[:MOST_POINTS]
    J = meeting_jacobian(moved.fit.motions, points.select(worst))
    error_mm = joint_error(J, moved.fit.covariance)
    seam = seam_names[int(worst[0])]
    if moved.wrong:
        sentence = f"the other touches contradict {listed(moved.wrong)}, also if bodies moved: touch there again"
        return Verdict(VerdictKind.FAIL, sentence, seam, VerdictReason.CONTRADICTION, error_mm)
    what = f"{moved.sentence()}; {moved.tolerances_sentence()}"
    if error_mm <= tolerance_mm:
        sentence = f"the accepted seams are within {error_mm:.3g} mm with 95 % confidence ({what})"
        return Verdict(VerdictKind.PASS, sentence, seam, VerdictReason.WITHIN, error_mm)
    sentence = (
        f"seam {seam} may be off by {error_mm:.3g} mm (95 %), which is more than the tolerance of {tolerance_mm:g} mm "
        f"({what}): touch its bodies again"
    )
    return Verdict(VerdictKind.UNSURE, sentence, seam, VerdictReason.ERROR, error_mm)
