"""Judge where programs weld: the wire keeps to the line of its seam, or beside it as the bead does that it lays."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby

import numpy as np
from scipy.spatial import cKDTree

from wpcal.controllers.run.recorder import Motion
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.planning.cell.cell import Cell

OFF_MM = 1.0  #: Moves leave their seam by the tolerance of the path, of some hundredths of a millimetre.
OFF_RAD = np.radians(5.0)  #: The wire leaves its planned direction by 0.5 degrees.
STEP_MM = 1.0  #: Between places of a line: frames turn little from one to the next.

Placed = tuple[Motion, FloatArray]  #: A motion with poses of the tip of the wire on its way, shape (n, 4, 4).


@dataclass(frozen=True, slots=True, eq=False)
class SeamLine:
    """A seam, or a stretch of it as planned."""

    name: str
    #: `p`, `R`: shapes (n, 3) and (n, 3, 3). Places, mm, and axes: of the seam or, of a plan, of the tool.
    p: FloatArray
    R: FloatArray
    is_planned: bool = False  #: Whether the wire is to be on it as these tools are; on a seam there may be beads.
    back_mm: float = 0.0  #: How far the tip is kept back along the wire.

    @classmethod
    def dense(
        cls, name: str, p: FloatArray, R: FloatArray, *, is_planned: bool = False, back_mm: float = 0.0
    ) -> SeamLine:
        """Return a line with places at steps of `STEP_MM`, through `p` and `R` of shapes (n, 3) and (n, 3, 3)."""
        s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(p, axis=0), axis=1))])
        at = np.union1d(s, np.arange(0.0, s[-1], STEP_MM))
        columns = np.concatenate([p, R.reshape(len(R), 9)], axis=1).T
        fine = np.stack([np.interp(at, s, column) for column in columns], axis=1)
        axes = fine[:, 3:].reshape(-1, 3, 3)
        return cls(name, fine[:, :3], axes / np.linalg.norm(axes, axis=1, keepdims=True), is_planned, back_mm)


def planned_line(name: str, cell: Cell, q: FloatArray) -> SeamLine:
    """Return the line of the tool in the part through states of a plan, shape (n, k), rad and mm."""
    T = cell.tool_in_part(q)
    return SeamLine.dense(name, T[:, :3, 3], T[:, :3, :3], is_planned=True)


def tools_in_part(cell: Cell, legs: Iterable[tuple[Motion, FloatArray | None]]) -> Iterator[Placed]:
    """Yield motions with the poses of the tool in the part on their way.

    `legs`: Motions with their states, shape (n, k), rad and mm; those whose states are not known are left out.
    """
    yield from ((motion, cell.tool_in_part(states)) for motion, states in legs if states is not None)


@dataclass(frozen=True, slots=True, eq=False)
class _Run:
    """What is welded between two marks."""

    motions: Sequence[Motion]
    owner: IntArray  #: shape (n,). Which of them leads to a pose.
    line: int
    at: IntArray  #: shape (n,). The nearest places of the line.
    off: FloatArray  #: shape (n, 3). From there to the tip, in the axes of the line, mm.
    wire: FloatArray  #: shape (n, 3). The direction of the wire in these axes.

    def beyond(self) -> str:
        """Say with which stand-off the wire would be on the line; empty where with none."""
        back = np.median(-np.einsum("ni,ni->n", self.off, self.wire))
        left = np.linalg.norm(self.off + back * self.wire, axis=1).max()
        return f"; it is on it with a stand-off {back:.1f} mm longer" if back > OFF_MM and left <= OFF_MM else ""


def off_line_faults(placed: Iterable[Placed], lines: Sequence[SeamLine]) -> Iterator[tuple[Motion, str]]:
    """Yield of each run the motion that is farthest off its line, and by how much.

    `placed`: Motions in the order of the program, in the frame of the lines.
    """
    if not lines:
        return
    trees = [cKDTree(line.p) for line in lines]
    runs = [_run(list(group), lines, trees) for seam, group in groupby(placed, key=lambda each: each[0].seam) if seam]
    for run in runs:
        line = lines[run.line]
        is_alone = line.is_planned or not any(_are_beside(run, other) for other in runs if other is not run)
        middle = np.zeros(3) if is_alone else np.median(run.off, axis=0)
        off_mm = np.linalg.norm(run.off - middle, axis=1)
        row = int(np.argmax(off_mm))
        if off_mm[row] > OFF_MM:
            what = f"the wire is {off_mm[row]:.1f} mm off the line of {line.name}{run.beyond()}"
            yield run.motions[int(run.owner[row])], what
            continue
        turned = np.arccos(np.clip(run.wire[:, 2], -1.0, 1.0))
        row = int(np.argmax(turned))
        if line.is_planned and turned[row] > OFF_RAD:
            what = f"the wire is turned by {np.degrees(turned[row]):.0f} deg from its direction on {line.name}"
            yield run.motions[int(run.owner[row])], what


def _run(placed: Sequence[Placed], lines: Sequence[SeamLine], trees: Sequence[cKDTree]) -> _Run:
    T = np.concatenate([poses for _, poses in placed])
    found = [tree.query(T[:, :3, 3]) for tree in trees]
    own = int(np.argmin([np.median(distance) for distance, _ in found]))
    line, at = lines[own], np.array(found[own][1])
    if line.is_planned:
        at[[0, -1]] = 0, len(line.p) - 1  # it is welded from end to end
    off = np.einsum("nij,ni->nj", line.R[at], T[:, :3, 3] + line.back_mm * T[:, :3, 2] - line.p[at])
    ends = (at == 0) | (at == len(line.p) - 1)
    off[:, 0] = np.where(ends, off[:, 0], 0.0)  # within a step of the line
    wire = np.einsum("nij,ni->nj", line.R[at], T[:, :3, 2])
    owner = np.repeat(np.arange(len(placed)), [len(poses) for _, poses in placed])
    return _Run([motion for motion, _ in placed], owner, own, at, off, wire)


def _are_beside(run: _Run, other: _Run) -> bool:
    return run.line == other.line and run.at.min() < other.at.max() and other.at.min() < run.at.max()
