"""Judge the poses of written programs: finite, inside reach, out of material, and those that were asked for."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from scipy.spatial import KDTree

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.rays import START_MM
from wpcal.controllers.audit.arc import arc_faults, count_switches
from wpcal.controllers.audit.fault import Fault
from wpcal.controllers.audit.read_back import ReadPose, is_weld_program, places_between, read_moves, read_poses_back
from wpcal.controllers.judge.asked import SAME_MM, SAME_RAD
from wpcal.controllers.judge.written import WrittenWrongError, programs_of, require_as_asked
from wpcal.controllers.language.grammar import Step
from wpcal.controllers.language.post import blocks_of, own_arc_templates
from wpcal.controllers.program import WeldProgram
from wpcal.controllers.program.arc import SEAM_MARKS
from wpcal.controllers.program.reachable_spin import ArmAtTool
from wpcal.controllers.registry import find_controller
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import ErrorCode, InputError, WpcalError
from wpcal.core.tangent import log_rotation
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.inverse import turn_into_limits
from wpcal.robot.torch.attitude import ToolAxis, wire_directions
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape
from wpcal.seam.judge.material import find_poses_in_material
from wpcal.seam.record_check import FARTHEST_MM, ROTATION_ATOL

MOVES_AT_ONCE = 100  #: Of which all places are in one array: a file with absurd moves needs some 100 MB.
ALL_SWITCHES = 4  #: Beginning and end of a seam, start and end of the arc: with all of them a program can be judged.


Poses = tuple[FloatArray, FloatArray]
"""Positions (n, 3), mm, and axes (n, 3, 3) in `base`."""


@dataclass(frozen=True, slots=True, eq=False)
class Surroundings:
    """What the poses of a program are compared with."""

    T_base_part: RigidTransform | None = None  #: The user frame of poses whose frame is not in the file.
    part: TriangleMaterial | None = None  #: In `base`.
    arm: Arm | None = None
    T_flange_tool: RigidTransform | None = None  #: With `arm`.
    torch: TorchShape = USUAL_TORCH
    tool_axis: ToolAxis = ToolAxis.Z
    standoff_mm: float = 0.0
    start_mm: float = START_MM  #: From where on the wire is felt: farther on seams that are modelled as beads.
    #: Digital output that switches the arc; None for that which the header of a program states.
    arc_output: int | None = None

    def __str__(self) -> str:
        """Say what is compared."""
        done = ["finite", "rotations", "user frames"]
        if self.arm is not None:
            done.append(f"inside the reach of {self.arm.name}")
        if self.part is not None:
            done.append(f"out of material with {self.torch}, also between poses")
        return ", ".join(done)


def audit_program(raw: bytes, path: Path, around: Surroundings) -> list[Fault]:
    """Return the faults of one file of a program."""
    try:
        poses = read_poses_back(raw, path, around.T_base_part)
    except WpcalError as error:
        return [Fault.of(error, str(path))]
    faults = list(pose_faults(poses, around))
    if not faults and around.part is not None:
        faults = list(_move_faults(poses, read_moves(raw, path), around))
    return [*faults, *arc_faults(raw, path, around.arc_output)]


def pose_faults(poses: Sequence[ReadPose], around: Surroundings) -> Iterator[Fault]:
    """Yield the faults of poses that were read back."""
    sound = []
    for pose in poses:
        what = _what_is_no_pose(pose)
        if what:
            yield _fault(pose, what)
        elif pose.in_base:
            sound.append(pose)
        elif around.T_base_part is not None:
            yield _fault(pose, "is recorded without a tool")
    if not sound:
        return
    p, R = np.array([pose.p_base for pose in sound]), np.array([pose.R_base for pose in sound])
    if around.arm is not None:
        for row in _beyond_reach(p, R, around.arm, around.T_flange_tool):
            yield _fault(sound[row], f"no joint angles within the limits of {around.arm.name} reach it")
    if around.part is not None:
        wire = wire_directions(R, around.tool_axis)
        tips = p + around.standoff_mm * wire
        found = find_poses_in_material(around.part, tips, -wire, around.torch, start_mm=around.start_mm)
        for row, solid, part in zip(found.row.tolist(), found.solid, found.part, strict=True):
            what = f"the {part.value} of {around.torch} is inside {solid!r}"
            yield _fault(sound[row], what, ErrorCode.POSE_IN_MATERIAL)


def _move_faults(poses: Sequence[ReadPose], chains: Sequence[Sequence[Step]], around: Surroundings) -> Iterator[Fault]:
    """Yield the faults between sound poses, one for each move."""
    sound, told = [pose for pose in poses if pose.in_base], set[str]()
    moves = [pair for chain in chains for pair in pairwise(chain)]
    for first in range(0, len(moves), MOVES_AT_ONCE):
        p, R, ends = places_between(sound, moves[first : first + MOVES_AT_ONCE])
        if not ends or around.part is None:
            continue
        wire = wire_directions(R, around.tool_axis)
        tips = p + around.standoff_mm * wire
        found = find_poses_in_material(around.part, tips, -wire, around.torch, start_mm=around.start_mm)
        for row, solid, part in zip(found.row.tolist(), found.solid, found.part, strict=True):
            if ends[row].name not in told:
                told.add(ends[row].name)
                x, y, z = tips[row]
                what = f"on the move there, at base {x:.1f}, {y:.1f}, {z:.1f} mm, the {part.value} of {around.torch}"
                yield _fault(ends[row], f"{what} is inside {solid!r}", ErrorCode.POSE_IN_MATERIAL)


def _what_is_no_pose(pose: ReadPose) -> str:
    p, R = pose.p_base, pose.R_base
    if not (np.isfinite(p).all() and np.isfinite(R).all()):
        return "expected finite numbers"
    if np.abs(p).max() >= FARTHEST_MM:
        return f"expected coordinates of less than {FARTHEST_MM:g} mm, got {', '.join(f'{v:g}' for v in p)}"
    if np.abs(R.T @ R - np.eye(3)).max() > ROTATION_ATOL or np.linalg.det(R) < 0.0:
        return "its orientation is not a rotation"
    return ""


def _fault(pose: ReadPose, what: str, code: str = ErrorCode.INPUT) -> Fault:
    return Fault(what, pose.line, field=f"point {pose.name}", code=code)


def _beyond_reach(p: FloatArray, R: FloatArray, arm: Arm, T_flange_tool: RigidTransform | None) -> list[int]:
    """Return the poses that no branch of the arm reaches within its limits."""
    at_tool = ArmAtTool(arm, T_flange_tool or RigidTransform.identity(target="flange", source="tool"), np.zeros(6))
    joints = turn_into_limits(arm, at_tool.branches(p, R), at_tool.near)
    return np.flatnonzero(~np.isfinite(joints).all(axis=-1).any(axis=-1)).tolist()


def written_files(files: Mapping[str, str | bytes]) -> dict[str, bytes]:
    """Return the files of a program whose poses can be read back, as bytes."""
    named = {name: data.encode("utf-8") if isinstance(data, str) else data for name, data in files.items()}
    return {name: data for name, data in named.items() if is_weld_program(Path(name))}


def check_written(files: Mapping[str, str | bytes], program: WeldProgram, *, name: str) -> int:
    """Read written files back, and refuse them if their poses are not those of the program.

    Raises
    ------
    WrittenWrongError
        When a file cannot be read, a pose is missing, or there is a pose that was not asked for, and no template of
        the user made the files.
    InputError : The same with templates of the user.
    """
    try:
        return _check_written(files, program, name)
    except WrittenWrongError as error:
        if program.controller.templates is None:
            raise
        raise InputError(f"{program.controller.templates}: the templates break the program: {error}") from None


def _check_written(files: Mapping[str, str | bytes], program: WeldProgram, name: str) -> int:
    """Read written files back."""
    _refuse_wrong_arcs(files, program, name)
    if programs_of(files):
        return require_as_asked(files, program, name=name) if program.controller.templates is None else 0
    own = written_files(files)
    if not own:
        return 0
    read: list[ReadPose] = []
    is_carried = program.planned is not None and program.planned.follows
    for file, data in own.items():
        try:
            read += read_poses_back(data, Path(file), program.T_base_part, is_carried=is_carried)
        except WpcalError as error:
            what = f"{name}: the written program cannot be read back: {error}; nothing is written"
            raise WrittenWrongError(what) from None
    if not read:
        return 0
    first = [0 if program.planned is None else path.before for path in program.paths]  # plans go there in joints
    asked_p = [path.p_base[row:] for path, row in zip(program.paths, first, strict=True)]
    asked_R = [path.R_base[row:] for path, row in zip(program.paths, first, strict=True)]
    if program.safe_point is not None:
        asked_p.append(program.safe_point.p_base)
        asked_R.append(program.safe_point.R_base)
    asked = np.concatenate(asked_p), np.concatenate(asked_R)
    found = np.array([pose.p_base for pose in read]), np.array([pose.R_base for pose in read])
    require_poses(asked, found, name)
    return len(read)


def require_poses(asked: Poses, found: Poses, name: str) -> None:
    """Refuse a program whose poses, read back, are not those that were asked for; `name` is that of the format."""
    for these, others, what in ((asked, found, "is missing in"), (found, asked, "was not asked for, but is in")):
        row = first_without_match(*these, *others) if len(others[0]) else 0
        if row is not None:
            x, y, z = these[0][row]
            place = f"{name}: the pose at base {x:.3f}, {y:.3f}, {z:.3f} mm"
            raise WrittenWrongError(f"{place} {what} the written program, read back; nothing is written")


def _refuse_wrong_arcs(files: Mapping[str, str | bytes], program: WeldProgram, name: str) -> None:
    """Refuse files in which the arc is on or off in the wrong place, unless templates switch it in their own words."""
    output = None if program.arc is None else program.arc.output
    own_words = program.arc is not None and program.controller.templates is not None
    for file, data in files.items():
        raw = data.encode("utf-8") if isinstance(data, str) else data
        if own_words and 0 < len(count_switches(raw, Path(file), output)) < ALL_SWITCHES:
            continue
        faults = arc_faults(raw, Path(file), output)
        if faults:
            what = f"{name}: {file}, line {faults[0].line}: {faults[0].message}; nothing is written"
            raise WrittenWrongError(what)


def unjudged_parts(files: Mapping[str, str | bytes], program: WeldProgram, *, name: str) -> tuple[str, ...]:
    """Say what could not be checked: a language without a grammar, and arcs that templates write in their own words."""
    controller, folder = find_controller(name), program.controller.templates
    if controller is not None and controller.grammar is None:
        return (f"the written program: {name} has no grammar with which it could be read back",)
    if folder is None:
        return ()
    if program.arc is None:
        own = own_arc_templates(name, folder)
        return (f"whether {' and '.join(own)} switch the arc in this dry run",) if own else ()
    found = Counter[str]()
    for file, data in files.items():
        found += count_switches(data.encode() if isinstance(data, str) else data, Path(file), program.arc.output)
    if not blocks_of(name):
        return ()
    if found["begin seam"] != len(program.paths) or found["end seam"] != len(program.paths):
        return (f"where the arc burns: {folder / name} leaves out the comments {' and '.join(SEAM_MARKS)}",)
    unknown = [what for what in ("start", "end") if not found[f"{what} arc"]]
    what = " or ".join(f"{one}s" for one in unknown)
    return (f"where the arc burns: no instruction that wpcal knows {what} it in {folder / name}",) if what else ()


def first_without_match(p: FloatArray, R: FloatArray, other_p: FloatArray, other_R: FloatArray) -> int | None:
    """Return the first pose that none of other poses equals; None if each has one.

    `p`, `other_p`: shapes (n, 3) and (m, 3). In `base`, mm.
    `R`, `other_R`: ndarray, shapes (n, 3, 3) and (m, 3, 3).
    """
    if not np.isfinite(other_p).all() or not np.isfinite(p).all():
        return int(np.argmin(np.isfinite(p).all(axis=1)))
    near = KDTree(other_p).query_ball_point(p, SAME_MM)
    for row, candidates in enumerate(near):
        turns = np.linalg.norm(log_rotation(R[row].T @ other_R[candidates]), axis=-1) if candidates else np.zeros(0)
        if not (turns <= SAME_RAD).any():
            return row
    return None
