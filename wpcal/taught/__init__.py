"""What a person or a robot touched: tables, kinds of rows, pairs of points, and points stored in robot programs."""

from wpcal.taught.kinds import TouchKind
from wpcal.taught.pairs import read_pairs
from wpcal.taught.programs import JointValues, ProgramPoint, ProgramPoints, ProgramReader, TaughtProgram
from wpcal.taught.resolve import named_axes, touches_of
from wpcal.taught.table import TaughtPoints, pair_points, read_taught, taught_csv
from wpcal.taught.user_frames import ProgramReading, points_in_base

__all__ = [
    "JointValues",
    "ProgramPoint",
    "ProgramPoints",
    "ProgramReader",
    "ProgramReading",
    "TaughtPoints",
    "TaughtProgram",
    "TouchKind",
    "named_axes",
    "pair_points",
    "points_in_base",
    "read_pairs",
    "read_taught",
    "taught_csv",
    "touches_of",
]
