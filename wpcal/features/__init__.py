"""Reference features: what a person can touch on the part, named."""

from wpcal.features.choose import choose_features
from wpcal.features.find import find_features
from wpcal.features.reference import FeatureKind, ReferenceFeature, feature_named, features_record

__all__ = ["FeatureKind", "ReferenceFeature", "choose_features", "feature_named", "features_record", "find_features"]
