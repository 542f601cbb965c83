"""Judge where programs weld: the wire keeps to the line of its seam, or beside it as the bead does that it lays."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from scipy.spatial import cKDTree

from wpcal.controllers.run.recorder import Motion
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.planning.cell.cell import Cell

OFF_MM = 1.0  #: Moves leave their seam by the tolerance of the path, of some hundredths of a millimetre.
OFF_RAD = np.radians(5.0)  #: The wire leaves its planned direction by 0.5 degrees.
LEAST_TURNS = 0.1  #: A weave changes its side at more than this share of its points, a line aslant once.
STEP_MM = 0.5  #: Between places of a line: from the wire to the nearest one is hardly farther than to the line.

Placed = tuple[Motion, FloatArray]  #: A motion with poses of the tip of the wire on its way, shape (n, 4, 4).


@dataclass(frozen=True, slots=True, eq=False)
class Track:
    """A seam, or a stretch of it as planned."""

    name: str
    #: `p`, `R`: shapes (n, 3) and (n, 3, 3). Places, mm, and axes: of the seam or, of a plan, of the tool.
    p: FloatArray
    R: FloatArray
    is_planned: bool = False  #: Whether the wire is to be on it as these tools are; on a seam there may be beads.
    back_mm: float = 0.0  #: How far the tip is kept back along the wire.

    @classmethod
    def dense(cls, name: str, p: FloatArray, R: FloatArray, *, is_planned: bool = False, back_mm: float = 0.0) -> Track:
        """Return a line with places at steps of `STEP_MM`, through `p` and `R` of shapes (n, 3) and (n, 3, 3)."""
        s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
        at = np.union1d(s, np.arange(0.0, s[-1], STEP_MM))
        fine = np.stack([np.interp(at, s, own) for own in np.concatenate([p, R.reshape(len(R), 9)], axis=1).T], axis=1)
        axes = fine[:, 3:].reshape(-1, 3, 3)
        return cls(name, fine[:, :3], axes / np.linalg.norm(axes, axis=1, keepdims=True), is_planned, back_mm)


def planned_line(name: str, cell: Cell, q: FloatArray) -> Track:
    """Return the line of the tool in the part through states of a plan, shape (n, k), rad and mm."""
    T = cell.tool_in_part(q)
    return Track.dense(name, T[:, :3, 3], T[:, :3, :3], is_planned=True)


def tools_in_part(cell: Cell, legs: Iterable[tuple[Motion, FloatArray | None]]) -> Iterator[Placed]:
    """Yield motions with the poses of the tool in the part on their way.

    `legs`: Motions with their states, shape (n, k), rad and mm; those whose states are not known are left out.
    """
    yield from ((motion, cell.tool_in_part(states)) for motion, states in legs if states is not None)


@dataclass(frozen=True, slots=True, eq=False)
class _Run:
    """What is welded between two marks."""

    motions: Sequence[Motion]  #: The one that leads to each of n poses.
    line: Track
    at: IntArray  #: shape (n,). The nearest places of the line.
    off: FloatArray  #: shape (n, 3). From there to the tip, in the axes of the line, mm.
    wire: FloatArray  #: shape (n, 3). The direction of the wire in these axes.

    def fault(self, *, is_alone: bool) -> tuple[Motion, str] | None:
        """Return the motion that is farthest off the line, and by how much; None where none is."""
        middle = np.zeros(3) if is_alone else np.median(self.off, axis=0)
        off_mm, turned = np.linalg.norm(self.off - middle, axis=1), np.arccos(np.clip(self.wire[:, 2], -1.0, 1.0))
        row = int(np.argmax(off_mm))
        if off_mm[row] > OFF_MM + _weave_mm(self.off - middle):
            what = f"the wire is {off_mm[row]:.1f} mm off the line of {self.line.name}"
        elif self.line.is_planned and turned.max() > OFF_RAD:
            row = int(np.argmax(turned))
            what = f"the wire is turned by {np.degrees(turned[row]):.0f} deg from its direction on {self.line.name}"
        else:
            return None
        return self.motions[row], what


def _weave_mm(off: FloatArray) -> float:
    """Return half the width of a weave that is made of points; 0 where offsets (n, 3), mm, do not go to and fro."""
    across = off @ np.linalg.svd(off, full_matrices=False)[2][0]
    low, high = np.quantile(across, (0.1, 0.9)).tolist()
    turns = np.count_nonzero(np.diff(np.sign(across[np.abs(across) > OFF_MM / 2])))
    return (high - low) / 2.0 if turns > len(off) * LEAST_TURNS and -low > high / 2.0 > -low / 4.0 else 0.0


def off_line_faults(placed: Iterable[Placed], lines: Sequence[Track]) -> Iterator[tuple[Motion, str]]:
    """Yield of each run the motion that is farthest off its line, and by how much.

    `placed`: Motions in the order of the program, in the frame of the lines.
    """
    if not lines:
        return
    owner = np.repeat(np.arange(len(lines)), [len(line.p) for line in lines])
    places = cKDTree(np.concatenate([line.p for line in lines]))

    def lines_near(p: FloatArray) -> list[Track]:
        around = places.query_ball_point(p, places.query(p)[0] + OFF_MM)
        return [lines[row] for row in np.unique(owner[np.concatenate(around).astype(int)])]

    groups = (list(group) for seam, group in groupby(placed, key=lambda each: each[0].seam) if seam)
    runs = [_run(group, lines_near) for group in groups]
    for run in runs:
        others = [(each.at.min(), each.at.max()) for each in runs if each.line is run.line and each is not run]
        is_beside = any(low < run.at.max() and run.at.min() < high for low, high in others)
        if (found := run.fault(is_alone=run.line.is_planned or not is_beside)) is not None:
            yield found


def _run(placed: Sequence[Placed], lines_near: Callable[[FloatArray], Sequence[Track]]) -> _Run:
    T = np.concatenate([poses for _, poses in placed])
    found = [(each, *cKDTree(each.p).query(T[:, :3, 3])) for each in lines_near(T[:, :3, 3])]
    line, _, at = min(found, key=lambda one: float(np.median(one[1])))
    if line.is_planned:  # it is welded from end to end, and a ring has both ends at one place
        for tips, rows, end in ((T[:, :3, 3], at, 0), (T[::-1, :3, 3], at[::-1], len(line.p) - 1)):
            rows[: max(int(np.argmax(np.linalg.norm(tips - tips[0], axis=1) > STEP_MM)), 1)] = end
    off = np.einsum("nij,ni->nj", line.R[at], T[:, :3, 3] + line.back_mm * T[:, :3, 2] - line.p[at])
    wire = np.einsum("nij,ni->nj", line.R[at], T[:, :3, 2])
    motions = [motion for motion, poses in placed for _ in poses]
    return _Run(motions, line, at, off, wire)
