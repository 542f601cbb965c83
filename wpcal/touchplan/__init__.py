"""Which touches to make: searches with the least predicted error of the seams, and the safe way between them."""

from wpcal.touchplan.options import NominalError, Template, TouchOptions
from wpcal.touchplan.plan_touches import TouchPart, plan_touches

__all__ = ["NominalError", "Template", "TouchOptions", "TouchPart", "plan_touches"]
