"""Issues of a finished fit, of points or of touches: residuals above the tolerance, and the error of the tool."""

from __future__ import annotations

import numpy as np

from wpcal.calibrate.uncertainty import TeachingError
from wpcal.core.issue import Issue
from wpcal.core.pairs import PointPairs, Residuals
from wpcal.core.transform import RigidTransform


def verdict_issues(
    pairs: PointPairs, check: PointPairs | None, T_base_part: RigidTransform, tolerance_mm: float
) -> tuple[Issue, ...]:
    """Name the fitted and the check points whose residuals exceed the tolerance."""
    found = []
    for group, word in ((pairs, "fitted"), (check, "check")):
        if group is None:
            continue
        residuals = Residuals.of(group, T_base_part)
        over = np.flatnonzero(residuals.norms_mm > tolerance_mm)
        if len(over):
            message = (
                f"the largest residual of the {word} points is {residuals.largest_mm:.4g} mm at {residuals.worst}; the "
                f"tolerance is {tolerance_mm:g} mm"
            )
            found.append(Issue("above-tolerance", message, tuple(group.names[i] for i in over[:20])))
    return tuple(found)


def bias_advice(teaching: TeachingError) -> tuple[Issue, ...]:
    """Say how a stated error of the tool centre point affects the welds, and how to avoid that."""
    if not teaching.tcp_bias_mm:
        return ()
    message = (
        f"a tool centre point off by {teaching.tcp_bias_mm:g} mm leaves no residual while the torch keeps its posture; "
        "the predicted errors allow for a weld a quarter turn away. Touch in the posture in which the tool centre "
        "point was calibrated (Yin 2003, section 3)"
    )
    return (Issue("tcp-bias", message),)
