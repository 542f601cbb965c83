"""A program of two robots in coordinated motion before it is written in a language.

Robot 1 welds on lines and arcs in the frame of the part, which robot 2 holds and moves. Both begin and end each move
together. Everything about the weld itself (moves along the seam, labels, weld data) is a `WeldPath`, as for one robot.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from wpcal.controllers.program import ControllerSettings, WeldPath
from wpcal.controllers.program.arc import ArcSettings, arc_in_words, seam_marks
from wpcal.controllers.program.describe import describe_path, speeds_in_words
from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import InputError
from wpcal.core.version import __version__
from wpcal.planning.cell.cell import Cell
from wpcal.planning.plan.coordinated import CoordinatedRun
from wpcal.planning.plan.run import AIR_SPEED_MM_S
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.inverse import Posture, posture
from wpcal.robot.moves import Arc
from wpcal.seam.seam import Seam
from wpcal.weld.runs import WeldRun, weld_runs
from wpcal.weld.seam_weld import SeamWeld

ROBOTS = (1, 2)  #: Robot 1 carries the torch, robot 2 carries the part.


@dataclass(frozen=True, slots=True, eq=False)
class SyncProgram:
    """Joint targets of two robots with marks 1 to N.

    Raises `InputError` when shapes differ, there are fewer than two targets, or a time is not positive.
    """

    seam: str  #: As in the part, any text.
    arms: tuple[Arm, Arm]  #: Of robots 1 and 2.
    joints: tuple[FloatArray, FloatArray]  #: shape (N, 6). Shown angles at the marks, rad, unwrapped.
    seconds: FloatArray  #: shape (N - 1,). From each mark to the next.
    #: `arc_on`, `arc_off`: Rows (from 0) at which the arc starts and stops.
    arc_on: int
    arc_off: int
    notes: tuple[str, ...] = ()  #: For a person to read first: speed, clearance, what was checked.
    #: Names and numbers; the tool is that of robot 1.
    controller: ControllerSettings = field(default_factory=ControllerSettings)

    def __post_init__(self) -> None:
        n = len(self.seconds) + 1
        for robot, q, arm in zip(ROBOTS, self.joints, self.arms, strict=True):
            if q.shape != (n, len(arm.joints)) or n < 2:
                raise InputError(f"robot {robot}: {n - 1} times need joints of shape ({n}, 6), got {q.shape}")
        if not (np.isfinite(self.seconds).all() and (self.seconds > 0).all()):
            raise InputError("the time between two marks must be positive")
        if not 0 <= self.arc_on < self.arc_off < n:
            raise InputError(f"arc on at row {self.arc_on}, off at {self.arc_off}: expected rows of the {n} in order")

    def __len__(self) -> int:
        return len(self.seconds) + 1

    @property
    def marks(self) -> range:
        """Numbers of the marks, one per target."""
        return range(1, len(self) + 1)

    @property
    def label_width(self) -> int:
        """Digits of the number in a label, as in programs of `wpcal export`."""
        return max(4, len(str(len(self))))


ID_STEP = 10  #: Between the numbers of marks, as people write them: a mark can be put between two.
SPEED_RESERVE = 1.5  #: Of robot 2 above what it needs: the path of a joint move is longer than its chord.
NOT_CHECKED = "NOT CHECKED: cables, hoses, what the cell does not have, the way to the first point. RUN IT DRY FIRST"


class CoordinatedStep(NamedTuple):
    """One move of both robots."""

    to: int
    via: int | None
    on_seam: bool
    stops: bool
    mark: int


@dataclass(frozen=True, slots=True, eq=False)
class CoordinatedProgram:
    """Targets of both robots and their common moves.

    Raises `InputError` when the path has no lines and arcs, or the arrays do not have one row for every pose.
    """

    cell: Cell  #: Arms, bases, the tool of robot 1, and the place of the part on the flange of robot 2.
    path: WeldPath  #: Of robot 1, with m poses in `part` (not in `base`) and its angles there.
    joints2: FloatArray  #: shape (m, 6). Shown angles of robot 2 at the same poses, rad.
    #: `speed_mm_s`, `air_speed_mm_s`: Of the torch in the part: along the seam, and to and from it.
    speed_mm_s: float
    air_speed_mm_s: float
    notes: tuple[str, ...]  #: For a person to read first.
    #: The tool is that of robot 1. `frame_number` is the frame of the held part, where a language has one.
    controller: ControllerSettings = field(default_factory=ControllerSettings)
    arc: ArcSettings | None = None  #: None for a dry run.

    def __post_init__(self) -> None:
        count = len(self.path)
        if self.path.moves is None or self.path.joints is None:
            raise InputError(f"seam {self.seam}: lines and arcs, and joints at their ends, are needed")
        if not len(self.joints2) == len(self.path.joints) == count:
            raise InputError(f"seam {self.seam}: {count} poses need as many joints of both robots")

    @property
    def seam(self) -> str:
        """The name of the seam."""
        return self.path.seam.name

    @property
    def joints1(self) -> FloatArray:
        """Shown angles of robot 1 at the poses, shape (m, 6), rad."""
        return np.zeros((0, 6)) if self.path.joints is None else self.path.joints

    @property
    def marks(self) -> tuple[str, str]:
        """The comments at the start and at the end of the seam."""
        return seam_marks(self.arc)

    @property
    def postures(self) -> tuple[Posture, Posture]:
        """Postures of both arms at the poses."""
        return posture(self.cell.arm, self.joints1), posture(self.cell.arm2, self.joints2)

    @property
    def label_width(self) -> int:
        """Digits of the number in a label, as in programs of `wpcal export`."""
        return max(4, len(str(len(self.path))))

    def steps(self, blend_mm: float) -> list[CoordinatedStep]:
        """Return the common moves from the first pose on: to the start of the seam, along it, and away from it."""
        first, rows = self.path.weld_rows.start, self.path.weld_rows
        found = [CoordinatedStep(first, None, False, True, 0)]  # without length if there is no approach
        for move, stops in zip(self.path.weld_moves, self.path.stops(blend_mm), strict=True):
            via = first + move.via if isinstance(move, Arc) else None
            found.append(CoordinatedStep(first + move.to, via, True, stops, 0))
        if self.path.after:
            found.append(CoordinatedStep(rows.stop, None, False, True, 0))
        return [step._replace(mark=ID_STEP * number) for number, step in enumerate(found, 1)]

    @property
    def holder_speed_mm_s(self) -> float:
        """The speed of robot 2 on its fastest move along the seam, of its flange or of the part, and a half more.

        Both robots take the time of the slower one, which is then the torch.
        """
        assert self.path.moves is not None
        ends = self.path.moves.ends
        rows = self.path.weld_rows.start + ends
        seconds = np.diff(self.path.moves.s_mm[ends]) / self.speed_mm_s
        flange, part = self.cell.arm2.forward(self.joints2[rows]), self.part_in_base2()[rows]
        ways = [np.linalg.norm(np.diff(T[:, :3, 3], axis=0), axis=1) for T in (flange, part)]
        return float(max(SPEED_RESERVE * (np.max(ways, axis=0) / seconds).max(), self.air_speed_mm_s))

    def tool_in_base1(self) -> FloatArray:
        """Return the poses of the tool in the base of robot 1, shape (m, 4, 4), mm."""
        return np.asarray(self.cell.arm.forward(self.joints1) @ self.cell.T_flange_tool.matrix)

    def part_in_base2(self) -> FloatArray:
        """Return the poses of the part in the base of robot 2, shape (m, 4, 4), mm."""
        return np.asarray(self.cell.arm2.forward(self.joints2) @ self.cell.T_part.matrix)


def build_coordinated_program(
    found: CoordinatedRun,
    seam: Seam,
    *,
    controller: ControllerSettings | None = None,
    weld: SeamWeld | None = None,
    arc: ArcSettings | None = None,
) -> CoordinatedProgram:
    """Return the program of a coordinated run.

    Raises `InputError` when the weld data has more than one bead or stretch: a plan is one bead along the whole seam.
    """
    run, cell = found.run, found.cell
    ends = [q for q in (found.approach, found.retract) if q is not None]
    T_tool = _tool_in_part(found, ends)
    p, R = list(found.moves.p), list(found.moves.R)
    joints1, joints2 = list(found.joints1), list(found.joints2)
    if found.approach is not None:
        p, R = [T_tool[0][:3, 3], *p], [R[0], *R]
        joints1, joints2 = [found.approach, *joints1], [joints2[0], *joints2]
    if found.retract is not None:
        p, R = [*p, T_tool[-1][:3, 3]], [*R, R[-1]]
        joints1, joints2 = [*joints1, found.retract], [*joints2, joints2[-1]]
    path = WeldPath(
        seam,
        frozen(p),
        frozen(R),
        None,
        before=int(found.approach is not None),
        after=int(found.retract is not None),
        joints=frozen(joints1),
        moves=found.moves,
        run=None if weld is None else _only_run(seam, weld),
    )
    return CoordinatedProgram(
        cell=cell,
        path=path,
        joints2=frozen(joints2),
        speed_mm_s=run.schedule.speed_mm_s,
        air_speed_mm_s=AIR_SPEED_MM_S,
        notes=_notes(found, path, arc),
        controller=controller or ControllerSettings(program_name=f"WPCAL_{seam.name}"),
        arc=arc,
    )


def _tool_in_part(found: CoordinatedRun, joints1: list[FloatArray]) -> list[FloatArray]:
    """Return the poses of the tool in the part where the run begins and ends, each 4 by 4, mm."""
    cell = found.cell
    rows = [found.joints2[0]] * (found.approach is not None) + [found.joints2[-1]] * (found.retract is not None)
    held = [cell.T_world_base2.matrix @ cell.arm2.forward(q[None])[0] @ cell.T_part.matrix for q in rows]
    tools = [cell.T_world_base.matrix @ cell.arm.forward(q[None])[0] @ cell.T_flange_tool.matrix for q in joints1]
    return [np.linalg.inv(part) @ tool for part, tool in zip(held, tools, strict=True)]


def _only_run(seam: Seam, weld: SeamWeld) -> WeldRun:
    runs = weld_runs(seam, weld)
    if len(runs) != 1 or runs[0].bead is not None or runs[0].seam.length_mm != seam.length_mm:
        raise InputError(
            f"weld {seam.name}: {len(runs)} beads or stretches; a plan of two robots is one bead along the whole seam: "
            f"wpcal welds … --set {seam.name}:passes=1"
        )
    return replace(runs[0], seam=seam)


def tacks_left_out(weld: SeamWeld) -> str:
    """Say that the tack welds of a weld are not in a plan of two robots."""
    return f"tack welds of {weld.name} ({len(weld.tacks_mm)}) are not in this plan of two robots: weld them first"


UNSWEPT = "NOT CHECKED: this text"
SWEPT = "checked: this text, executed and swept: both arms, torch and wire, the held part and the bodies of the cell"
"""What the judge lets a program say that has no fault."""


def swept_notes(notes: Sequence[str]) -> tuple[str, ...]:
    """Return what a program says of itself once its text is swept."""
    return tuple(note.replace(UNSWEPT, SWEPT) for note in notes)


def _notes(found: CoordinatedRun, path: WeldPath, arc: ArcSettings | None) -> tuple[str, ...]:
    moves, turned = found.moves, math.degrees(found.part_turned_rad)
    off = f"{moves.off_mm:.3f} mm and {math.degrees(moves.off_rad):.2f} deg"
    weld = None if path.run is None else path.run.weld
    return (
        f"written by wpcal {__version__} from plan.json: coordinated motion, the part in the hand of robot 2",
        f"seam {path.seam.name}: {describe_path(path)}",
        *([] if weld is None or not weld.tacks_mm else [tacks_left_out(weld)]),
        found.run.schedule.describe(),
        f"in the part the wire is at most {off} off the seam (allowed: {moves.most_mm:g} mm, 0.5 deg)",
        f"the part is at most {turned:.2f} deg and {found.part_off_mm:.1f} mm from where the plan has it",
        f"{UNSWEPT}; its moves as planned: {found.check.verdict.value}; {found.check.describe()}",
        *speeds_in_words(found.run.schedule.speed_mm_s, AIR_SPEED_MM_S),
        arc_in_words(arc),
        NOT_CHECKED.replace(", the way to the first point", "") if found.cell.goes_from_home else NOT_CHECKED,
    )
