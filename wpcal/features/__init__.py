"""Reference features: what a person can touch on the part, named."""

from wpcal.features.choose import choose_features
from wpcal.features.find import find_features
from wpcal.features.reference import (
    POINT_KINDS,
    FeatureKind,
    HoleForm,
    HoleStep,
    ReferenceFeature,
    Touch,
    feature_named,
    features_record,
)

__all__ = [
    "POINT_KINDS",
    "FeatureKind",
    "HoleForm",
    "HoleStep",
    "ReferenceFeature",
    "Touch",
    "choose_features",
    "feature_named",
    "features_record",
    "find_features",
]
