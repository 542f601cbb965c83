"""Seams as lines and circular arcs: the fewest moves of a robot that keep to a path.

Call `fit_moves` with the poses of a tool along a path, as plain arrays. It returns a `MovePath`: the few poses that a
program states, and one `Line` or `Arc` for each move from the first pose on. Every controller language writes these
moves in its own words, and everything else asks the `MovePath` where the tool really is between them:

>>> import numpy as np
>>> from wpcal.robot.moves import Line, fit_moves
>>> x = np.linspace(0.0, 150.0, 16)  # a straight seam, mm
>>> p = np.stack([x, 0.0 * x, 0.0 * x], axis=1)
>>> path = fit_moves(p, np.repeat(np.diag([1.0, -1.0, -1.0])[None], 16, axis=0))
>>> path.moves, len(path)  # one move between two poses
((Line(to=1),), 2)
>>> path.poses_at([75.0])[0].tolist()  # where the tool is, 75 mm along the seam
[[75.0, 0.0, 0.0]]

`fit` searches the moves, `course` is the path that they have to keep to, `interpolation` is what controllers do on a
line and on an arc, with sources, `sweep` the places at which a move of a tool is compared with a part.
"""

from wpcal.robot.moves.fit import PathTolerance, fit_moves
from wpcal.robot.moves.move import Arc, Line, Move, MovePath
from wpcal.robot.moves.sweep import Reaching, Swept, sweep, sweep_moves

__all__ = ["Arc", "Line", "Move", "MovePath", "PathTolerance", "Reaching", "Swept", "fit_moves", "sweep", "sweep_moves"]
