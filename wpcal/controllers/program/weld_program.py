"""A weld program before it is written in a language: tool poses along seams, with approach and retract."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.controllers.program.arc import ArcSettings, seam_marks
from wpcal.controllers.program.planned import PlannedMoves
from wpcal.controllers.program.spin import spun, unwinding_spin
from wpcal.core.arrays import BoolArray, FloatArray, frozen
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.motion import AIR_SPEED_MM_S, APPROACH_MM, weld_speed
from wpcal.core.options import opt
from wpcal.core.transform import RigidTransform
from wpcal.results.folder import FinishedCalibration
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.inverse import Posture, posture
from wpcal.robot.moves import Arc, Line, Move, MovePath, PathTolerance
from wpcal.robot.torch.attitude import TorchSettings, tool_rotations, wire_directions
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape
from wpcal.seam.seam import Seam
from wpcal.weld.runs import RunChoice, WeldRun, laid_runs
from wpcal.weld.seam_weld import SeamWeld
from wpcal.weld.values import WeldValues


@dataclass(frozen=True, slots=True)
class MotionSettings:
    """How the torch approaches, welds and retracts.

    Raises `InputError` when a speed is not positive, a distance is negative, or a number is not finite.
    """

    approach_mm: float = opt(APPROACH_MM, "Along the wire, before the seam.")
    retract_mm: float = opt(APPROACH_MM, "Along the wire, after the seam.")
    speed_mm_s: float = weld_speed()
    air_speed_mm_s: float = opt(AIR_SPEED_MM_S, "Speed of approach and retract.", above=0)

    def __post_init__(self) -> None:
        for name in ("approach_mm", "retract_mm", "speed_mm_s", "air_speed_mm_s"):
            value = getattr(self, name)
            is_speed = name.endswith("_s")
            if not 0.0 <= value < math.inf or (is_speed and value == 0.0):
                raise InputError(f"{name}: expected {'a positive number' if is_speed else '0 or more'}, got {value:g}")


@dataclass(frozen=True, slots=True)
class ControllerSettings:
    """Names and numbers that only the controller knows.

    Raises `InputError` when a name is empty or a number is negative.
    """

    program_name: str = opt("WPCAL", "Name of the program in the controller.")
    tool_name: str = opt("tTorch", "If the controller's tools have names.")
    tool_number: int = opt(1, "If the tools have numbers.")
    frame_number: int = opt(1, "User frame of the part.")
    sets_tool: bool = opt(
        False,
        "For plans: the programs set the tool data to the tool of the cell, over a measured tool centre point.",
        "--set-tool",
    )
    zone_mm: float = opt(
        0.0,
        "Between joint moves in the air of a plan the tool may leave a corner by this, or less to be free; 0 stops, "
        "as the plan was made. Languages that bound no such zone stop.",
    )
    #: For languages that cannot leave the configuration open, by name of the format; "" is used for every other format.
    #: Never guessed.
    configurations: Mapping[str, str] = opt(
        None,
        'Configuration of the arm as the pendant shows it, for languages that state it: "N U T, 0, 0, 0". '
        "Without FORMAT it is used for every format. Repeatable.",
        "--config",
        default_factory=dict,
        many=True,
        metavar="[FORMAT=]CONFIG",
        read="wpcal.controllers.registry:parse_configurations",
    )
    templates: Path | None = opt(
        None,
        "Your templates of header, start and end of a weld, moves off the seams and footer: a folder with one folder "
        "per format, as --write-templates writes them. A template that is not there is ours.",
        "--template",
        metavar="FOLDER",
    )

    def __post_init__(self) -> None:
        if not (self.program_name.strip() and self.tool_name.strip()):
            raise InputError("the names of the program and of the tool must not be empty")
        if self.tool_number < 0 or self.frame_number < 0:
            raise InputError(f"tool {self.tool_number}, frame {self.frame_number}: expected numbers of 0 or more")
        if not 0.0 <= self.zone_mm < math.inf:
            raise InputError(f"zone_mm: expected 0 or more, got {self.zone_mm:g}")


class _Poses:
    """Poses of the tool in `base`."""

    __slots__ = ()
    p_base: FloatArray
    R_base: FloatArray

    def poses_in(self, T_base_frame: RigidTransform) -> tuple[FloatArray, FloatArray]:
        """Return their positions (n, 3), mm, and axes (n, 3, 3) in another frame."""
        T = T_base_frame.inverse()
        return T.apply(self.p_base), T.R @ self.R_base


@dataclass(frozen=True, slots=True, eq=False)
class WeldPath(_Poses):
    """The tool along one seam: the way to it, k poses along the seam, the way from it."""

    seam: Seam  #: With n frames in `base`.
    p_base: FloatArray  #: shape (a + k + b, 3). Tool centre points in `base`, mm.
    R_base: FloatArray  #: shape (a + k + b, 3, 3). Columns are the axes of the tool in `base`.
    u95_mm: FloatArray | None  #: shape (n,). The 95 % error at the frames of the seam, mm.
    #: `before`, `after`: a and b: poses of the way to the seam, the last of them the approach, and of the way from it,
    #: the first of them the retract. Where there are more than one, all moves between them are linear.
    before: int = 1
    after: int = 1
    #: shape (a + k + b, 6). Shown angles of the arm at the poses, rad; None if no arm is given.
    joints: FloatArray | None = None
    #: The lines and arcs along the seam, with the poses `weld_rows`. None: a line to every frame of the seam, k = n.
    moves: MovePath | None = None
    run: WeldRun | None = None  #: What is laid along the seam; None if no weld data is given.
    #: shape (a + k + b, e). External axes at the poses, rad, a rail in mm; None without a plan.
    external: FloatArray | None = None
    #: Along the seam, as a plan has it; None: that of the weld data, or of the program.
    speed_mm_s: float | None = None

    def __len__(self) -> int:
        return len(self.p_base)

    @property
    def values(self) -> WeldValues:
        """The values of the weld; all of them are None if no weld data is given."""
        return WeldValues() if self.run is None else self.run.weld.values

    @property
    def is_woven(self) -> bool:
        """Whether the points weave: no line may replace them."""
        return self.run is not None and self.run.is_woven

    @property
    def has_arcs(self) -> bool:
        """Whether one of the moves along the seam is an arc."""
        return any(isinstance(move, Arc) for move in self.weld_moves)

    @property
    def turns_along(self) -> bool:
        """Whether external axes move along the seam."""
        return self.external is not None and bool(np.ptp(self.external[self.weld_rows], axis=0).any())

    @property
    def weld_moves(self) -> tuple[Move, ...]:
        """The moves along the seam; their rows are counted from its first pose, which is row 0."""
        return tuple(map(Line, range(1, self.weld_count))) if self.moves is None else self.moves.moves

    def stops(self, blend_mm: float) -> tuple[bool, ...]:
        """Tell at the end of which of the moves along the seam the tool stops: at corners of lines and arcs, and last.

        `blend_mm`: Size of the zone in which a program lets the tool leave a corner, mm.
        """
        if self.moves is None:
            return (*[False] * (self.weld_count - 2), True)
        return self.moves.stops(blend_mm)

    def stations(self) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
        """Return where the tool is at every frame of the seam, and at the poses along it.

        Returns `p`, `R`: shapes (m, 3) and (m, 3, 3). In `base`, as a controller interpolates between the poses.
        Returns `frame`: shape (m,). Number of the frame of the seam at this place, with a fraction between two frames.
        Returns `is_pose`: shape (m,). Whether it is one of the poses along the seam.
        """
        if self.moves is None:
            rows, n = self.weld_rows, self.weld_count
            return self.p_base[rows], self.R_base[rows], np.arange(float(n)), np.ones(n, dtype=np.bool_)
        own = self.seam.frames.s_mm
        s = np.union1d(own, self.moves.s_mm)
        p, R = self.moves.poses_at(s)
        is_pose = np.isin(s, self.moves.s_mm)
        p[is_pose], R[is_pose] = self.moves.p, self.moves.R
        return p, R, np.interp(s, own, np.arange(len(own))), is_pose

    @property
    def weld_rows(self) -> slice:
        """The rows of the poses along the seam."""
        return slice(self.before, len(self) - self.after)

    @property
    def weld_count(self) -> int:
        """Number of poses along the seam."""
        return len(self) - self.before - self.after

    @property
    def roles(self) -> list[str]:
        """What each pose is: ``to``, ``approach``, ``weld``, ``retract`` or ``from``."""
        n = self.weld_count
        return [*["to"] * (self.before - 1), "approach", *["weld"] * n, "retract", *["from"] * (self.after - 1)]

    def labels(self, stem: str, *, width: int) -> list[str]:
        """Name the poses: ``stem_to01`` …, ``stem_appr``, ``stem_0001`` …, ``stem_retr``, ``stem_up01`` …."""
        way_to = [f"{stem}_to{number:02d}" for number in range(1, self.before)]
        along = [f"{stem}_{number:0{width}d}" for number in range(1, self.weld_count + 1)]
        way_from = [f"{stem}_up{number:02d}" for number in range(1, self.after)]
        approach, retract = [f"{stem}_appr"][: self.before], [f"{stem}_retr"][: self.after]
        return [*way_to, *approach, *along, *retract, *way_from]


@dataclass(frozen=True, slots=True, eq=False)
class SafePoint(_Poses):
    """Where a program starts and ends: a pose above the part."""

    p_base: FloatArray  #: shape (1, 3). Tool centre point in `base`, mm.
    R_base: FloatArray  #: shape (1, 3, 3). Axes of the tool in `base`.
    joints: FloatArray | None = None  #: shape (1, 6). Shown angles of the arm, rad; None if no arm is given.


@dataclass(frozen=True, slots=True, eq=False)
class WeldProgram:
    """All that is needed to write a program in any language."""

    paths: tuple[WeldPath, ...]
    #: The frame in which positions are written. The base itself in plans whose part turns on a positioner.
    T_base_part: RigidTransform
    torch: TorchSettings = field(default_factory=TorchSettings)
    motion: MotionSettings = field(default_factory=MotionSettings)
    controller: ControllerSettings = field(default_factory=ControllerSettings)
    calibration: dict[str, Any] = field(default_factory=dict)  #: The record of ``calibration.json``.
    #: The part's triangles as `wpcal.brep.mesh_glb.read_part_glb` reads them, for formats that show the part.
    part_glb: bytes | None = None
    #: Where the program starts and ends. With it, every move between two seams is linear and was checked.
    safe_point: SafePoint | None = None
    checked: tuple[str, ...] = ()  #: Lines that say what was compared with the part; empty if nothing was.
    #: Seams that were asked for and are not in the program, by name, and why.
    left_out: Mapping[str, str] = field(default_factory=dict)
    arm: Arm | None = None  #: The arm whose joints the poses have.
    #: How far the lines and arcs of the paths may be from the seams; None for a line to every frame.
    tolerance: PathTolerance | None = None
    arc: ArcSettings | None = None  #: How the arc is switched; None for a dry run without arc instructions.
    planned: PlannedMoves | None = None  #: The moves off the seams of a plan, of which `arm` is the arm.
    shape: TorchShape = USUAL_TORCH  #: With which it was compared with the part.
    is_corrected: bool = False  #: Whether a touch program corrects its frame, and calls it.

    @property
    def tool_data(self) -> RigidTransform | None:
        """T_flange_tool of the cell, if the program sets the tool data."""
        return self.planned.T_flange_tool if self.controller.sets_tool and self.planned is not None else None

    @property
    def marks(self) -> tuple[str, str]:
        """The comments at the start and at the end of every seam; those of a dry run stand for the instructions."""
        return seam_marks(self.arc)

    def weld_speed_mm_s(self, path: WeldPath) -> float:
        """Return the speed of the wire: that of the plan, of the weld data or of the program; faster if it weaves."""
        speed = path.speed_mm_s or path.values.speed_mm_s or self.motion.speed_mm_s
        return speed if path.run is None or not path.run.is_woven else round(speed * path.run.speed_ratio, 3)

    @property
    def label_width(self) -> int:
        """Digits of the number in a label, at least 4: all labels have the same length and sort by number."""
        return max(4, *(len(str(len(path))) for path in self.paths))

    @property
    def groups(self) -> tuple[WeldPath | SafePoint, ...]:
        """The safe point, if there is one, and the paths."""
        return self.paths if self.safe_point is None else (self.safe_point, *self.paths)

    def posture_of(self, poses: WeldPath | SafePoint) -> Posture | None:
        """Return the postures of the arm at poses of this program; None if no arm is given."""
        return None if self.arm is None or poses.joints is None else posture(self.arm, poses.joints)


def build_program(
    finished: FinishedCalibration,
    *,
    torch: TorchSettings | None = None,
    motion: MotionSettings | None = None,
    controller: ControllerSettings | None = None,
    welds: Mapping[str, SeamWeld] | None = None,
    arc: ArcSettings | None = None,
    choice: RunChoice | None = None,
) -> WeldProgram:
    """Place the torch on every frame of the seams.

    Raises `GeometryError` when a seam has fewer than two frames.
    Raises `InputError` when only tack welds are wanted and there are none, or a weave cannot be made of points.
    """
    if controller is not None and controller.sets_tool:
        raise InputError("--set-tool: only the cell of a plan knows the tool (wpcal plan)")
    if controller is not None and controller.zone_mm:
        raise InputError("--zone-mm: only a plan has joint moves that are swept in a cell (wpcal plan)")
    torch, motion = torch or TorchSettings(), motion or MotionSettings()
    runs = laid_runs(
        list(zip(finished.seams, finished.u95_mm, strict=True)), welds, choice or RunChoice(), motion.speed_mm_s
    )
    paths = [replace(_path(seam, u95, torch, motion), run=run) for seam, u95, run in runs]
    return WeldProgram(
        tuple(paths),
        finished.T_base_part,
        torch,
        motion,
        controller or ControllerSettings(),
        finished.calibration,
        finished.part_glb,
        arc=arc,
    )


def _path(seam: Seam, u95_mm: FloatArray | None, torch: TorchSettings, motion: MotionSettings) -> WeldPath:
    if len(seam.frames) < 2:
        raise GeometryError(f"seam {seam.name}: expected at least 2 frames to weld along, got {len(seam.frames)}")
    R = tool_rotations(seam.frames.R, torch, seam.lean_rad, seam.spin_rad)
    R = spun(R, unwinding_spin(R, torch.tool_axis, torch.spin_range_rad), torch.tool_axis)
    wire = wire_directions(R, torch.tool_axis)
    p = seam.frames.p - (torch.standoff_mm + seam.more_wire_mm) * wire
    appr, retr = p[:1] - motion.approach_mm * wire[:1], p[-1:] - motion.retract_mm * wire[-1:]
    rows = np.concatenate([[0], np.arange(len(R)), [-1]])
    return WeldPath(seam, frozen(np.concatenate([appr, p, retr])), frozen(R[rows]), u95_mm)
