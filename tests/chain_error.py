"""How far the closed chain of two robots is open: an independent measure of plans that are closed by construction."""

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.tangent import log_rotation
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.closed_chain import SeamPath


def chain_error(
    cell: Cell, path: SeamPath, state: FloatArray, R_seam_tool: FloatArray
) -> tuple[FloatArray, FloatArray]:
    r"""Return what the closed chain is off at every point (Hou 2018, eq. 5, f3).

    .. math::
        T_{base1,flange1}\, T_{flange1,tool} = T_{base1,base2}\, T_{base2,flange2}\, T_{flange2,part}\, T_{part,seam}\,
        R_{seam,tool}

    Parameters
    ----------
    cell : Cell
    path : SeamPath
        n points.
    state : FloatArray
        n states.
    R_seam_tool : ndarray, shape (n, 3, 3)
        Target axes of the tool in the seam frame.

    Returns
    -------
    off_mm, off_rad : ndarray, shape (n,)
        Distance of the wire's tip from the weld point, and angle between the torch and its target attitude.
    """
    T_world_tool, T_world_part = cell.tool_places(state[:, :6]), cell.part_places(state)
    weld = np.einsum("nij,nj->ni", T_world_part[:, :3, :3], path.p) + T_world_part[:, :3, 3]
    target = T_world_part[:, :3, :3] @ path.R @ R_seam_tool
    off_mm = np.linalg.norm(T_world_tool[:, :3, 3] - weld, axis=1)
    off_rad = np.linalg.norm(log_rotation(np.swapaxes(target, 1, 2) @ T_world_tool[:, :3, :3]), axis=1)
    return np.asarray(off_mm, dtype=np.float64), np.asarray(off_rad, dtype=np.float64)
