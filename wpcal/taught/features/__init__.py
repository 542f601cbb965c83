"""Reference features: named places on the part that a person can touch."""

from wpcal.taught.features.choose import FeatureChoice, choose_features
from wpcal.taught.features.detect import find_features
from wpcal.taught.features.reference import (
    POINT_KINDS,
    FeatureKind,
    HoleForm,
    HoleStep,
    ReferenceFeature,
    Touch,
    feature_named,
    features_record,
    point_named,
)
from wpcal.taught.features.touchable import Ease, Touchable, judge_features

__all__ = [
    "POINT_KINDS",
    "Ease",
    "FeatureChoice",
    "FeatureKind",
    "HoleForm",
    "HoleStep",
    "ReferenceFeature",
    "Touch",
    "Touchable",
    "choose_features",
    "feature_named",
    "features_record",
    "find_features",
    "judge_features",
    "point_named",
]
