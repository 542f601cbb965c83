# SPDX-License-Identifier: MIT
"""What is drawn of a calibration: the seams in the colours of their errors, the residuals as arrows, seam frames.

All of it is in the robot's base. It is drawn where the part is, and once more on the model.
"""

from __future__ import annotations

import math
from typing import Any

from pivy import coin

from ..document.calibration import pose_of
from ..document.shown import Shown
from .colours import RESIDUAL, colour_of, unit
from .lines import NEAREST, Path, arrows_node, fitting_factor, not_clickable, paths_node, triads_node

SEAM_WIDTH = 6.0
REFUSED_WIDTH = 2.0
TRIAD_PART = 0.035  #: Length of the axes of a seam frame, as a part of the radius of everything.


def calibration_node(fit: dict[str, Any], frame: Any, shown: Shown) -> coin.SoSeparator:
    """Return what is drawn of a fit."""
    drawn = _in_base(fit, shown)
    root = coin.SoSeparator()
    if shown.at_pose:
        root.addChild(drawn)
    if shown.on_model:
        model = coin.SoSeparator()
        model.addChild(_transform(frame.multiply(pose_of(fit["T_base_part"]).inverse())))
        model.addChild(drawn)
        root.addChild(model)
    return root


def arrow_factor(fit: dict[str, Any]) -> int:
    """Return the factor by which the residuals of a fit are drawn so that the longest is well seen."""
    return fitting_factor(max((point["distance_mm"] for point in fit["points"]), default=0.0), radius_of(fit))


def radius_of(fit: dict[str, Any]) -> float:
    """Return half the diagonal of the box around points and seams, mm."""
    places = [point["p_base_mm"] for point in fit["points"]]
    places += [place for seam in fit["seams"] or () for place in seam["frames"]["p"]]
    if not places:
        return 1.0
    spans = [float(max(axis)) - float(min(axis)) for axis in zip(*places)]
    return max(0.5 * math.sqrt(sum(span * span for span in spans)), 1.0)


def _in_base(fit: dict[str, Any], shown: Shown) -> coin.SoSeparator:
    node = coin.SoSeparator()
    tolerance = fit["record"]["tolerance_mm"]
    seams: list[dict[str, Any]] = fit["seams"] or []
    accepted = [_path(seam, tolerance) for seam in seams if seam["accepted"]]
    refused = [_path(seam, None) for seam in seams if not seam["accepted"]]
    node.addChild(not_clickable())
    node.addChild(paths_node(accepted, width=SEAM_WIDTH, depth=NEAREST))
    node.addChild(paths_node(refused, width=REFUSED_WIDTH))
    starts = [point["p_base_mm"] for point in fit["points"]]
    vectors = [point["residual_mm"] for point in fit["points"]]
    factor = shown.factor or arrow_factor(fit)
    node.addChild(arrows_node(starts, vectors, factor=factor, colour=unit(RESIDUAL)))
    if shown.frames:
        poses = [pose for seam in seams if seam["accepted"] for pose in zip(seam["frames"]["p"], seam["frames"]["R"])]
        node.addChild(triads_node(poses, length=TRIAD_PART * radius_of(fit)))
    return node


def _path(seam: dict[str, Any], tolerance: float | None) -> Path:
    places, errors = seam["frames"]["p"], seam["frames"].get("u95")
    if tolerance is None or not errors:
        return places, [colour_of(None)] * len(places)
    return places, [colour_of(error / tolerance) for error in errors]


def _transform(placement: Any) -> coin.SoMatrixTransform:
    node = coin.SoMatrixTransform()
    columns = placement.toMatrix().transposed().A  # Coin multiplies rows with matrices
    node.matrix.setValue(*columns)
    return node
