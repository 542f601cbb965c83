"""The tolerance at which two solids touch, for features and seams alike."""

CONTACT_GAP_MM = 0.5
"""Two solids whose faces come this near are in contact: a fillet weld of usual size bridges the gap. Seams use it as
the largest default gap (`wpcal.seam.limits.usual_gap_mm`). A corner this near to another solid is not free."""
