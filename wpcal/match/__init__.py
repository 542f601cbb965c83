"""Which taught point is which point of the model."""

from wpcal.match.taught import TaughtPoints, pair_points, read_taught

__all__ = ["TaughtPoints", "pair_points", "read_taught"]
