"""Which features of a part to teach, so that the welds come out well."""

from wpcal.advise.advice import Advice, AdvisedSet, advise, template_csv
from wpcal.features.touchable import Ease, Touchable, judge_features

__all__ = ["Advice", "AdvisedSet", "Ease", "Touchable", "advise", "judge_features", "template_csv"]
