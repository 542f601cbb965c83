"""Which features of a part to teach, so that the welds come out well."""

from wpcal.advise.advice import Advice, AdvisedSet, advise, advise_set, template_csv

__all__ = ["Advice", "AdvisedSet", "advise", "advise_set", "template_csv"]
