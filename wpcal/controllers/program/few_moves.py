"""Weld programs with the fewest lines and arcs that keep to their seams."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from wpcal.controllers.program import WeldPath, WeldProgram
from wpcal.controllers.program.spin import spun
from wpcal.core.arrays import FloatArray, frozen
from wpcal.robot.moves import MovePath, PathTolerance, fit_moves
from wpcal.robot.moves.course import Course
from wpcal.robot.moves.fit import USUAL_TOLERANCE
from wpcal.robot.torch.attitude import ToolAxis, TorchSettings, tool_rotations, wire_directions
from wpcal.seam.seam import Seam

AXIS = {ToolAxis.X: 0, ToolAxis.Z: 2}  #: The column of a tool's axes along the wire.
ROUND_OFF_RAD = 1e-9  #: Of a spin that is just within its range.


def fit_program(
    program: WeldProgram, tolerance: PathTolerance | None = None, *, spin_is_free: bool = True
) -> WeldProgram:
    """Replace the poses along every seam by lines and arcs.

    `spin_is_free`: Whether the moves choose the turn about the wire, within the range of the torch. False: the tool
    keeps to the turn that it has at every frame.

    Returns: With the same ways between the seams. Where the tool has another turn about the wire at the end of a seam,
    so has its retract.
    """
    tolerance = tolerance or USUAL_TOLERANCE
    paths = tuple(_fitted(path, program.torch, tolerance, spin_is_free=spin_is_free) for path in program.paths)
    return replace(program, paths=paths, tolerance=tolerance)


def _fitted(path: WeldPath, torch: TorchSettings, tolerance: PathTolerance, *, spin_is_free: bool) -> WeldPath:
    if path.is_woven:
        return path  # a line to every point of the weave
    p, R = path.p_base[path.weld_rows], path.R_base[path.weld_rows]
    if spin_is_free and torch.spin_range_rad > 0.0:
        free = with_moves(path, fit_seam(path.seam, p, R, torch, tolerance, spin_is_free=True))
        if np.abs(spin_from_travel(free, torch)).max() <= torch.spin_range_rad + ROUND_OFF_RAD:
            return free
    if torch.spin_range_rad == 0.0:  # a bent neck is free as it is turned, and in no other way
        tolerance = replace(tolerance, side_rad=min(tolerance.side_rad, tolerance.wire_rad))
    return with_moves(path, fit_seam(path.seam, p, R, torch, tolerance, spin_is_free=False))


def fit_seam(
    seam: Seam, p: FloatArray, R: FloatArray, torch: TorchSettings, tolerance: PathTolerance, *, spin_is_free: bool
) -> MovePath:
    """Return the fewest lines and arcs along a seam.

    `p`: shape (n, 3). Tool centre points at its frames, in `base`, mm.
    `R`: shape (n, 3, 3). Axes of the tool there.
    """
    return fit_moves(
        p,
        R,
        s_mm=seam.frames.s_mm,
        headings=seam.frames.R[:, :, 0],
        axis=AXIS[torch.tool_axis],
        standoff_mm=torch.standoff_mm + seam.more_wire_mm,
        tolerance=tolerance,
        spin_is_free=spin_is_free,
    )


def seam_course(path: WeldPath, torch: TorchSettings, tolerance: PathTolerance, step_mm: float) -> Course:
    """Return points along a seam at small steps, with the torch as it is asked for."""
    frames = path.seam.frames
    R = tool_rotations(frames.R, torch, path.seam.lean_rad, path.seam.spin_rad)
    return Course.along(
        frames.p - torch.standoff_mm * wire_directions(R, torch.tool_axis),
        R,
        s_mm=frames.s_mm,
        headings=frames.R[:, :, 0],
        axis=AXIS[torch.tool_axis],
        standoff_mm=torch.standoff_mm,
        most_mm=tolerance.mm,
        step_mm=step_mm,
    )


def with_moves(path: WeldPath, moves: MovePath) -> WeldPath:
    """Return a path whose poses along the seam are those of lines and arcs.

    The approach and the retract keep their places and get the orientations of the first and the last pose.
    """
    return replace(_along(path, moves.p, moves.R), moves=moves)


def _along(path: WeldPath, p: FloatArray, R: FloatArray) -> WeldPath:
    rows = path.weld_rows
    p = np.concatenate([path.p_base[: rows.start], p, path.p_base[rows.stop :]])
    return replace(path, p_base=frozen(p), R_base=frozen(np.concatenate([R[:1], R, R[-1:]])))


def to_every_point(path: WeldPath, torch: TorchSettings) -> WeldPath:
    """Return a path with a line to every frame of the seam, and the turns about the wire that its moves have there."""
    frames = path.seam.frames
    R = tool_rotations(frames.R, torch, path.seam.lean_rad, path.seam.spin_rad)
    if torch.spin_range_rad > 0.0:
        R = spun(R, spin_from_travel(path, torch), torch.tool_axis)
    p = frames.p - (torch.standoff_mm + path.seam.more_wire_mm) * wire_directions(R, torch.tool_axis)
    return replace(_along(path, p, R), moves=None)


def spin_from_travel(path: WeldPath, torch: TorchSettings) -> FloatArray:
    """Return how far the tool is turned about the wire from the direction of travel.

    Returns ndarray, shape (n,). At every frame of the seam, rad, within half a turn.
    """
    _, R, frame, _ = path.stations()
    R = R[np.searchsorted(frame, np.arange(len(path.seam.frames)))]
    travel = tool_rotations(path.seam.frames.R, torch, path.seam.lean_rad, path.seam.spin_rad)
    side, wire = travel[:, :, 1], wire_directions(R, torch.tool_axis)
    across = R[:, :, 1]
    sine, cosine = np.einsum("ij,ij->i", np.cross(side, across), wire), np.einsum("ij,ij->i", side, across)
    return np.asarray(np.arctan2(sine, cosine), dtype=np.float64)
