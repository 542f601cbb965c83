"""What a person or a robot touched: the table, the kinds of rows, pairs of points, and what programs hold of them."""

from wpcal.taught.pairs import read_pairs
from wpcal.taught.resolve import named_axes, touches_of
from wpcal.taught.table import TaughtPoints, pair_points, read_taught

__all__ = ["TaughtPoints", "named_axes", "pair_points", "read_pairs", "read_taught", "touches_of"]
