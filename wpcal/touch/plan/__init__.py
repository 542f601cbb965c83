"""Which touches to make: searches with the least predicted error of the seams, and the safe way between them."""

from wpcal.touch.plan.options import NominalError, Pattern, TouchOptions
from wpcal.touch.plan.part import TouchPart
from wpcal.touch.plan.plan_touches import plan_touches

__all__ = ["NominalError", "Pattern", "TouchOptions", "TouchPart", "plan_touches"]
