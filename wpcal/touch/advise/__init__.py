"""Which features of a part to teach, so that the welds come out well."""

from wpcal.touch.advise.advice import Advice, AdvisedSet, advise, advise_set, template_csv
from wpcal.touch.advise.plane_touches import advise_touches

__all__ = ["Advice", "AdvisedSet", "advise", "advise_set", "advise_touches", "template_csv"]
