"""States between those of a weld, so that straight moves in the joints keep the wire on lines in the part.

A seam is sampled coarsely, and a controller moves the wire on lines and arcs. A trajectory in the joints leaves these
lines between two states, most where the torch turns quickly. There it gets more states, solved by Newton's method.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import inverse_pose, product, solve
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.shape import JOINTS

ON_LINE_MM = 0.02  #: How far the wire may leave a line: less than half of the usual tolerance of a path.
STEPS = 4  #: Of Newton's method: it starts within some tenths of a millimetre, and doubles its digits with each.
SOLVED = 1e-6  #: mm and rad: what is left where Newton's method found the place.


def states_on_lines(cell: Cell, q: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return states between which straight moves in the axes keep the tip of the wire on lines in the part.

    Parameters
    ----------
    q : shape (n, k). Neighbouring states of a weld with its approach and retract, rad and mm.

    Returns
    -------
    q : ndarray, shape (m, k)
        The given states and those between them; a place that Newton's method does not find within the limits is on the
        straight move in the axes.
    at : ndarray, shape (m,). Their places, in steps from the first.
    """
    tool = _in_part(cell, q)
    middle = _in_part(cell, (q[:-1] + q[1:]) / 2)[:, :3, 3]
    off = np.linalg.norm(middle - (tool[:-1, :3, 3] + tool[1:, :3, 3]) / 2, axis=1)
    parts = np.maximum(np.ceil(np.sqrt(off / ON_LINE_MM)), 1.0).astype(int)  # the distance shrinks with the square
    row = np.repeat(np.arange(len(parts)), parts)
    share = (np.arange(len(row)) - np.repeat(np.cumsum(parts) - parts, parts)) / parts[row]
    between = np.flatnonzero(share > 0.0)
    found = q[row] + share[:, None] * (q[row + 1] - q[row])
    if len(between):
        one, t = row[between], share[between]
        p = tool[one, :3, 3] + t[:, None] * (tool[one + 1, :3, 3] - tool[one, :3, 3])
        turn = Rotation.from_matrix(tool[one, :3, :3])
        by = (turn.inv() * Rotation.from_matrix(tool[one + 1, :3, :3])).as_rotvec()
        found[between] = _solved(cell, found[between], p, turn * Rotation.from_rotvec(t[:, None] * by))
    return np.concatenate([found, q[-1:]]), np.append(row + share, float(len(parts)))


def _in_part(cell: Cell, q: FloatArray) -> FloatArray:
    return product(inverse_pose(cell.part_places(q)), cell.tool_places(q))


def _solved(cell: Cell, start: FloatArray, p_part: FloatArray, R_part: Rotation) -> FloatArray:
    """Return states with the tool at places in the part, near given states of shape (n, k)."""
    q = start.copy()
    T_base_part = product(inverse_pose(cell.base_places(q)), cell.part_places(q))
    goal = np.einsum("nij,nj->ni", T_base_part[:, :3, :3], p_part) + T_base_part[:, :3, 3]
    attitude = Rotation.from_matrix(T_base_part[:, :3, :3]) * R_part
    left = np.full((len(q), 6), np.inf)
    for _ in range(STEPS):
        tool = product(cell.arm.forward(q[:, :JOINTS]), cell.T_flange_tool.matrix)
        turn = (attitude * Rotation.from_matrix(tool[:, :3, :3]).inv()).as_rotvec()
        left = np.concatenate([turn, goal - tool[:, :3, 3]], axis=1)
        J = cell.arm.jacobian(q[:, :JOINTS], point=cell.T_flange_tool.t_mm)
        step = solve(J, left[:, :, None])[0][:, :, 0]
        q[:, :JOINTS] += np.where(np.isfinite(step), step, 0.0)
    low, high = cell.limits
    good = (np.abs(left).max(axis=1) < SOLVED) & ((q >= low) & (q <= high)).all(axis=1)
    return np.where(good[:, None], q, start)
