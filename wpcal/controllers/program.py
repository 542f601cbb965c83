"""A weld program before it is written in a language: tool poses along seams, with approach and retract."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from wpcal import __version__
from wpcal.controllers.spin import spun, unwinding_spin
from wpcal.controllers.torch import TorchSettings, tool_rotations, wire_directions
from wpcal.core.arrays import BoolArray, FloatArray, frozen
from wpcal.core.errors import GeometryError, InputError
from wpcal.core.transform import RigidTransform
from wpcal.moves import Arc, Line, Move, MovePath, PathTolerance
from wpcal.results.folder import FinishedCalibration
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.posture import Posture, posture
from wpcal.seam.seam import Seam

NOT_CHECKED = "NOT CHECKED: the arm, fixtures, cables, the way to the first point. RUN IT DRY FIRST"
"""Said in the header of every program and on the console."""

USUAL_ZONE_MM = 1.0
"""Distance from a corner at which most languages let the tool leave the path."""


@dataclass(frozen=True, slots=True)
class MotionSettings:
    """How the torch approaches, welds and retracts.

    Parameters
    ----------
    approach_mm, retract_mm : float
        Distance from the seam, back along the wire. 50 mm clears a nozzle of common size.
    speed_mm_s : float
        Along the seam. 8 mm/s is common for a MAG fillet with a throat of 4 to 5 mm.
    air_speed_mm_s : float
        Of approach and retract.

    Raises
    ------
    InputError
        When a speed is not positive, a distance is negative, or a number is not finite.
    """

    approach_mm: float = 50.0
    retract_mm: float = 50.0
    speed_mm_s: float = 8.0
    air_speed_mm_s: float = 100.0

    def __post_init__(self) -> None:
        for name in ("approach_mm", "retract_mm", "speed_mm_s", "air_speed_mm_s"):
            value = getattr(self, name)
            is_speed = name.endswith("_s")
            if not 0.0 <= value < math.inf or (is_speed and value == 0.0):
                raise InputError(f"{name}: expected {'a positive number' if is_speed else '0 or more'}, got {value:g}")


@dataclass(frozen=True, slots=True)
class ControllerSettings:
    """Names and numbers that only the controller knows.

    Parameters
    ----------
    program_name : str
    tool_name : str
        For languages that name tools.
    tool_number, frame_number : int
        For languages that number tools and frames.
    configurations : mapping of str to str
        The arm's configuration as the pendant shows it, for languages that cannot leave it open, by name of the format;
        the name "" is used for every other format. Never guessed.

    Raises
    ------
    InputError
        When a name is empty or a number is negative.
    """

    program_name: str = "WPCAL"
    tool_name: str = "tTorch"
    tool_number: int = 1
    frame_number: int = 1
    configurations: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not (self.program_name.strip() and self.tool_name.strip()):
            raise InputError("the names of the program and of the tool must not be empty")
        if self.tool_number < 0 or self.frame_number < 0:
            raise InputError(f"tool {self.tool_number}, frame {self.frame_number}: expected numbers of 0 or more")


@dataclass(frozen=True, slots=True, eq=False)
class WeldPath:
    """The tool along one seam: the way to it, k poses along the seam, the way from it.

    Parameters
    ----------
    seam : Seam
        With n frames in `base`.
    p_base : ndarray, shape (a + k + b, 3)
        Tool centre points in `base`, mm.
    R_base : ndarray, shape (a + k + b, 3, 3)
        Columns are the axes of the tool in `base`.
    u95_mm : ndarray, shape (n,), or None
        The 95 % error at the frames of the seam, mm.
    before, after : int
        a and b: poses of the way to the seam, the last of them the approach, and of the way from it, the first of them
        the retract. Where there are more than one, all moves between them are linear.
    joints : ndarray, shape (a + k + b, 6), or None
        Shown angles of the arm at the poses, rad; None if no arm is given.
    moves : MovePath or None
        The lines and arcs along the seam, with the poses `weld_rows`. None: a line to every frame of the seam, k = n.
    """

    seam: Seam
    p_base: FloatArray
    R_base: FloatArray
    u95_mm: FloatArray | None
    before: int = 1
    after: int = 1
    joints: FloatArray | None = None
    moves: MovePath | None = None

    def __len__(self) -> int:
        return len(self.p_base)

    @property
    def has_arcs(self) -> bool:
        """Whether one of the moves along the seam is an arc."""
        return any(isinstance(move, Arc) for move in self.weld_moves)

    @property
    def weld_moves(self) -> tuple[Move, ...]:
        """The moves along the seam; their rows are counted from its first pose, which is row 0."""
        return tuple(map(Line, range(1, self.weld_count))) if self.moves is None else self.moves.moves

    def stops(self, blend_mm: float) -> tuple[bool, ...]:
        """Tell at the end of which of the moves along the seam the tool stops: at corners of lines and arcs, and last.

        Parameters
        ----------
        blend_mm : float
            Size of the zone in which a program lets the tool leave a corner, mm.
        """
        if self.moves is None:
            return (*[False] * (self.weld_count - 2), True)
        return self.moves.stops(blend_mm)

    def stations(self) -> tuple[FloatArray, FloatArray, FloatArray, BoolArray]:
        """Return where the tool is at every frame of the seam, and at the poses along it.

        Returns
        -------
        p, R : ndarray, shapes (m, 3) and (m, 3, 3)
            In `base`, as a controller interpolates between the poses.
        frame : ndarray, shape (m,)
            Number of the frame of the seam at this place, with a fraction between two frames.
        is_pose : ndarray of bool, shape (m,)
            Whether it is one of the poses along the seam.
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

    def poses_in(self, T_base_frame: RigidTransform) -> tuple[FloatArray, FloatArray]:
        """Return positions (a + k + b, 3), mm, and axes (a + k + b, 3, 3) of the tool in another frame."""
        return poses_in(self.p_base, self.R_base, T_base_frame)

    def labels(self, stem: str, *, width: int) -> list[str]:
        """Name the poses: ``stem_to01`` …, ``stem_appr``, ``stem_0001`` …, ``stem_retr``, ``stem_up01`` …."""
        way_to = [f"{stem}_to{number:02d}" for number in range(1, self.before)]
        along = [f"{stem}_{number:0{width}d}" for number in range(1, self.weld_count + 1)]
        way_from = [f"{stem}_up{number:02d}" for number in range(1, self.after)]
        return [*way_to, f"{stem}_appr", *along, f"{stem}_retr", *way_from]


def poses_in(p_base: FloatArray, R_base: FloatArray, T_base_frame: RigidTransform) -> tuple[FloatArray, FloatArray]:
    """Express poses of the tool in another frame.

    Parameters
    ----------
    p_base : ndarray, shape (n, 3)
        In `base`, mm.
    R_base : ndarray, shape (n, 3, 3)
        Axes of the tool in `base`.
    T_base_frame : RigidTransform

    Returns
    -------
    p, R : ndarray, shapes (n, 3) and (n, 3, 3)
        In the frame.
    """
    T = T_base_frame.inverse()
    return T.apply(p_base), T.R @ R_base


@dataclass(frozen=True, slots=True, eq=False)
class SafePoint:
    """Where a program starts and ends: a pose above the part.

    Parameters
    ----------
    p_base : ndarray, shape (1, 3)
        Tool centre point in `base`, mm.
    R_base : ndarray, shape (1, 3, 3)
        Axes of the tool in `base`.
    joints : ndarray, shape (1, 6), or None
        Shown angles of the arm, rad; None if no arm is given.
    """

    p_base: FloatArray
    R_base: FloatArray
    joints: FloatArray | None = None

    def poses_in(self, T_base_frame: RigidTransform) -> tuple[FloatArray, FloatArray]:
        """Return the position (1, 3), mm, and the axes (1, 3, 3) in another frame."""
        return poses_in(self.p_base, self.R_base, T_base_frame)


@dataclass(frozen=True, slots=True, eq=False)
class WeldProgram:
    """All that is needed to write a program in any language.

    Parameters
    ----------
    paths : tuple of WeldPath
    T_base_part : RigidTransform
    torch : TorchSettings
    motion : MotionSettings
    controller : ControllerSettings
    calibration : dict
        The record of ``calibration.json``.
    part_glb : bytes or None
        The part's triangles as `wpcal.brep.mesh_glb.read_part_glb` reads them, for formats that show the part.
    safe_point : SafePoint or None
        Where the program starts and ends. With it, every move between two seams is linear and was checked.
    checked : tuple of str
        Lines that say what was compared with the part; empty if nothing was.
    arm : Arm or None
        The arm whose joints the poses have.
    tolerance : PathTolerance or None
        How far the lines and arcs of the paths may be from the seams; None for a line to every frame.
    """

    paths: tuple[WeldPath, ...]
    T_base_part: RigidTransform
    torch: TorchSettings = field(default_factory=TorchSettings)
    motion: MotionSettings = field(default_factory=MotionSettings)
    controller: ControllerSettings = field(default_factory=ControllerSettings)
    calibration: dict[str, Any] = field(default_factory=dict)
    part_glb: bytes | None = None
    safe_point: SafePoint | None = None
    checked: tuple[str, ...] = ()
    arm: Arm | None = None
    tolerance: PathTolerance | None = None

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
) -> WeldProgram:
    """Place the torch on every frame of the seams.

    Parameters
    ----------
    finished : FinishedCalibration
        With the seams to export.
    torch : TorchSettings, optional
    motion : MotionSettings, optional
    controller : ControllerSettings, optional

    Raises
    ------
    GeometryError
        When a seam has fewer than two frames.
    """
    torch, motion = torch or TorchSettings(), motion or MotionSettings()
    paths = [_path(seam, u95, torch, motion) for seam, u95 in zip(finished.seams, finished.u95_mm, strict=True)]
    return WeldProgram(
        tuple(paths),
        finished.T_base_part,
        torch,
        motion,
        controller or ControllerSettings(),
        finished.calibration,
        finished.part_glb,
    )


def _path(seam: Seam, u95_mm: FloatArray | None, torch: TorchSettings, motion: MotionSettings) -> WeldPath:
    if len(seam.frames) < 2:
        raise GeometryError(f"seam {seam.name}: expected at least 2 frames to weld along, got {len(seam.frames)}")
    R = tool_rotations(seam.frames.R, torch, seam.lean_rad)
    R = spun(R, unwinding_spin(R, torch.tool_axis, torch.spin_range_rad), torch.tool_axis)
    wire = wire_directions(R, torch.tool_axis)
    p = seam.frames.p - (torch.stick_out_mm + seam.more_wire_mm) * wire
    appr, retr = p[:1] - motion.approach_mm * wire[:1], p[-1:] - motion.retract_mm * wire[-1:]
    rows = np.concatenate([[0], np.arange(len(R)), [-1]])
    return WeldPath(seam, frozen(np.concatenate([appr, p, retr])), frozen(R[rows]), u95_mm)


def describe(program: WeldProgram) -> list[str]:
    """Return the lines that every program file states: origin, verdict, torch and motion."""
    record, torch = program.calibration, program.torch
    lines = [f"written by wpcal {__version__} from calibration.json and seams.json"]
    if "verdict" in record:
        lines.append(f"calibration {record['verdict']}, tolerance {record['tolerance_mm']:g} mm")
        if "judgement" in record:
            lines.append(record["judgement"]["sentence"])
    lines += [
        f"wire leaves the tip along +{torch.tool_axis.value} of the tool, z_sense inward",
        f"work angle {math.degrees(torch.work_rad):g} deg, travel {math.degrees(torch.travel_rad):g} deg (+ push)",
        f"turn about the wire: {'least' if program.tolerance is None else 'as few moves need it'}, "
        f"within {math.degrees(torch.spin_range_rad):g} deg of the travel direction",
        f"stick-out {torch.stick_out_mm:g} mm, approach {program.motion.approach_mm:g} mm, "
        f"retract {program.motion.retract_mm:g} mm",
    ]
    if program.tolerance is not None:
        lines.append(describe_moves(program))
        if corners := sum(sum(path.stops(USUAL_ZONE_MM)[:-1]) for path in program.paths):
            most = program.tolerance.mm
            lines.append(f"stops at corners, where a zone would cut by more than {most:g} mm: {corners}")
    if program.arm is not None and (postures := program.posture_of(program.groups[0])) is not None:
        axis_1 = "behind" if postures.is_behind[0] else "in front of"
        lower_arm = "behind" if postures.is_behind_lower_arm[0] else "in front of"
        lines.append(
            f"the arm {program.arm.name} follows all moves within its joint limits, in one branch: wrist {axis_1} "
            f"axis 1, {lower_arm} the lower arm"
        )
    return [*lines, *(program.checked or ["NOT CHECKED for collisions with the part"]), NOT_CHECKED]


def describe_moves(program: WeldProgram) -> str:
    """Return one line about the lines and arcs of a program: how far they are from the seams at most."""
    tolerance = program.tolerance
    moves = [path.moves for path in program.paths if path.moves is not None]
    off_mm, off_rad = max(each.off_mm for each in moves), max(each.off_rad for each in moves)
    allowed = "" if tolerance is None else f" (allowed: {tolerance.mm:g} mm, {math.degrees(tolerance.wire_rad):g} deg)"
    return f"lines and arcs: the wire is at most {off_mm:.3f} mm and {math.degrees(off_rad):.2f} deg off{allowed}"


def describe_path(path: WeldPath) -> str:
    """Return one line about a seam: what it is, its points or moves, and its 95 % error."""
    seam = path.seam
    text = f"{seam.joint.value} {seam.weld.value}, {seam.length_mm:.1f} mm, {_count(path)}"
    if seam.more_wire_mm:
        text += f", wire {seam.more_wire_mm:g} mm longer than usual: the tool stays back by it"
    return text if path.u95_mm is None else f"{text}, 95 % error up to {path.u95_mm.max():.3f} mm"


def _count(path: WeldPath) -> str:
    if path.moves is None:
        return f"{path.weld_count} points"
    arcs = sum(isinstance(move, Arc) for move in path.weld_moves)
    counts = ((len(path.weld_moves) - arcs, "line"), (arcs, "arc"))
    return " and ".join(f"{count} {what}{'s' if count > 1 else ''}" for count, what in counts if count)
