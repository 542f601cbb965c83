"""Which features of a part to teach, so that the welds come out well."""

from wpcal.advise.advice import Advice, AdvisedSet, advise, template_csv

__all__ = ["Advice", "AdvisedSet", "advise", "template_csv"]
