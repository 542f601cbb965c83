"""Reference features: what a person can touch on the part, named."""

from wpcal.features.find import find_features
from wpcal.features.reference import FeatureKind, ReferenceFeature, feature_named, features_record

__all__ = ["FeatureKind", "ReferenceFeature", "feature_named", "features_record", "find_features"]
