"""Workpiece calibration for robot welding: taught points in, calibrated weld seams out.

The names below are for scripts; each is imported when it is used. Type checkers and editors read the
imports and `__all__`, Python reads `_HOMES`; a test compares them with each other and with what the documentation uses.

`calibrate_points` is `wpcal.calibrate.run`. It cannot have its own name here: Python sets ``wpcal.calibrate`` to
the package of that name as soon as anything imports it. No public name is therefore the name of a package.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from wpcal.core.lazy_names import lazy_names
from wpcal.core.version import __version__ as __version__

if TYPE_CHECKING:
    from wpcal.calibrate import Criterion
    from wpcal.calibrate import calibrate as calibrate_points
    from wpcal.calibrate.plane_touches import calibrate_bodies, predict_body_errors
    from wpcal.core import PointPairs, RigidTransform, WpcalError
    from wpcal.results import schema_text
    from wpcal.seam import SeamOptions, StepOptions, detect_seams
    from wpcal.taught.features import feature_named, find_features
    from wpcal.taught.table import TaughtPoints, pair_points, read_taught
    from wpcal.touch.moved_advice import advise_touches


_HOMES = {
    "Criterion": "wpcal.calibrate:Criterion",
    "PointPairs": "wpcal.core:PointPairs",
    "RigidTransform": "wpcal.core:RigidTransform",
    "SeamOptions": "wpcal.seam:SeamOptions",
    "StepOptions": "wpcal.seam:StepOptions",
    "TaughtPoints": "wpcal.taught.table:TaughtPoints",
    "WpcalError": "wpcal.core:WpcalError",
    "advise_touches": "wpcal.touch.moved_advice:advise_touches",
    "calibrate_bodies": "wpcal.calibrate.plane_touches:calibrate_bodies",
    "calibrate_points": "wpcal.calibrate:calibrate",
    "detect_seams": "wpcal.seam:detect_seams",
    "feature_named": "wpcal.taught.features:feature_named",
    "find_features": "wpcal.taught.features:find_features",
    "pair_points": "wpcal.taught.table:pair_points",
    "predict_body_errors": "wpcal.calibrate.plane_touches:predict_body_errors",
    "read_taught": "wpcal.taught.table:read_taught",
    "schema_text": "wpcal.results:schema_text",
}
__all__ = [
    "Criterion",
    "PointPairs",
    "RigidTransform",
    "SeamOptions",
    "StepOptions",
    "TaughtPoints",
    "WpcalError",
    "advise_touches",
    "calibrate_bodies",
    "calibrate_points",
    "detect_seams",
    "feature_named",
    "find_features",
    "pair_points",
    "predict_body_errors",
    "read_taught",
    "schema_text",
]
__getattr__, __dir__ = lazy_names(__name__, _HOMES)
