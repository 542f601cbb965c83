"""Judge programs of two robots: both texts are executed, their moves are paired, and both arms are swept together.

A move of one robot begins and ends with the move of the same mark of the other one, or of the same line where one
program moves both. Between their ends the torch keeps to its line or arc in the part, or moves by the joints, while
robot 2 moves by the joints or leads the part on a line. Where the joints lead through the air, the wire is a body of
the torch; where the cell states a home, both go from there to the first point.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import zip_longest
from pathlib import Path

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.controllers.judge.arc import arc_faults
from wpcal.controllers.judge.asked import SAME_DEG, SAME_MM, SAME_RAD
from wpcal.controllers.judge.execute import Files, execute, interpreted, texts_of
from wpcal.controllers.judge.in_cell import CellSweep
from wpcal.controllers.judge.swept import Meeting
from wpcal.controllers.judge.written import WrittenWrongError
from wpcal.controllers.language.grammar import Does
from wpcal.controllers.program.arc import SEAM_MARKS
from wpcal.controllers.program.coordinated_program import CoordinatedProgram, SyncProgram
from wpcal.controllers.registry import grammar_of_file
from wpcal.controllers.run.recorder import Motion, Recorder, Trace, pulses_of
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import GeometryError
from wpcal.core.same_bits import inverse_pose
from wpcal.core.tangent import log_rotation
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.shape import JOINTS
from wpcal.robot.kinematics.inverse import nearest_joints
from wpcal.robot.moves.interpolation import Moves

ROBOT = re.compile(r".*_R([12])")  #: The stem of a program of robot 1 or 2; all others only start both.
ASKED = "not the next joints of the plan, or not on its line or arc in the part, or no stop where the plan has one"
SEAM_ENDS = {Does.START, Does.END, Does.DRY}
STILL_RAD = np.radians(SAME_DEG)  #: Of all axes: they stand.


@dataclass(frozen=True, slots=True, eq=False)
class _Asked:
    """Where both robots should come together, and along what in the part."""

    q: FloatArray  #: shape (12,). rad.
    move: Moves | None = None  #: One line or arc; None off the seam.
    has_joints: bool = False  #: Whether it is a move by the joints of both.
    stops: bool = True  #: Whether they stop there: off the seam, and at its ends.


def require_in_step(
    files: Mapping[str, str],
    program: SyncProgram | CoordinatedProgram,
    cell: Cell,
    part: TriangleMaterial | None = None,
) -> None:
    """Require that the texts of each language lead through the plan and nowhere else, and meet nothing on the way.

    `part`: In `part`, in the hand of robot 2.
    Raises `WrittenWrongError` with the first line that does something else.
    """
    languages: dict[str, dict[str, str]] = {}
    for name, text in files.items():
        if (controller := interpreted(name)) is not None:
            languages.setdefault(controller.name, {})[name] = text
    tools, asked = (program.controller.tool_name, program.controller.tool_number), list(_asked_of(program))
    for texts in languages.values():
        found = in_step(texts, cell, asked[0].q, tools=tools, part=part)
        _require(found, asked, set(map(str, tools)), next(iter(texts)))


def _require(found: InStep, asked: Sequence[_Asked], tools: set[str], file: str) -> None:
    for place, line, what in found.faults:
        raise _wrong(place, line, what)
    legs = [leg for row, leg in enumerate(found.legs()) if not row or _moves(leg[1])]
    for row, (motion, q) in enumerate(legs):
        if row >= len(asked) or q is None or not _is_as(asked[row], motion, q, found.sweep.cell, tools):
            raise _wrong(motion.place.file, motion.place.line, f"{found.other(motion)}{ASKED}")
    if len(legs) < len(asked):
        raise WrittenWrongError(f"{file}, its end: {ASKED}; nothing is written")
    for meeting in found.meetings():
        raise _wrong(meeting.motion.place.file, meeting.motion.place.line, meeting.what)


def _wrong(file: str, line: int, what: str) -> WrittenWrongError:
    return WrittenWrongError(f"{file}, line {line}: {what}; nothing is written")


def _asked_of(program: SyncProgram | CoordinatedProgram) -> Iterator[_Asked]:
    """Yield where both robots come together, without rests."""
    if isinstance(program, SyncProgram):
        stops = {0, program.arc_on, program.arc_off, len(program) - 1}
        for row, q in enumerate(np.concatenate(program.joints, axis=1)):
            yield _Asked(q, has_joints=True, stops=row in stops)
        return
    axes, moves, on_seam = np.concatenate([program.joints1, program.joints2], axis=1), program.path.moves, 0
    assert moves is not None
    yield _Asked(axes[0])
    last = axes[0]
    for step in program.steps(0.0):
        row, on_seam = on_seam, on_seam + step.on_seam
        if np.abs(axes[step.to] - last).max() > STILL_RAD:
            move = moves.arrays.select(np.array([row])) if step.on_seam else None
            yield _Asked(axes[step.to], move, stops=step.stops)
        last = axes[step.to]


def _moves(q: FloatArray | None) -> bool:
    return q is None or bool(np.ptp(q, axis=0).max() > STILL_RAD)


def _is_as(asked: _Asked, motion: Motion, q: FloatArray, cell: Cell, tools: set[str]) -> bool:
    """Tell whether a move with states (n, 12) leads to where it should, and along its line or arc in the part."""
    if not np.isfinite(q).all() or (asked.stops and motion.place.blends):
        return False
    if asked.has_joints:
        return motion.kind == "J" and bool(np.abs(q[-1] - asked.q).max() <= STILL_RAD)
    is_so = motion.kind == "J" or motion.place.tool in tools
    if motion.goal is not None:
        is_so = bool(np.abs(motion.T_flange_tool - cell.T_flange_tool.matrix).max() <= SAME_RAD)
    ends = np.array([q[-1], asked.q])
    return is_so and _is_near(*cell.tool_in_part(ends)) and _is_near(*cell.part_places(ends)) and _is_on(asked, q, cell)


def _is_near(T: FloatArray, other: FloatArray) -> bool:
    turned = np.linalg.norm(log_rotation(T[:3, :3].T @ other[:3, :3]))
    return bool(np.linalg.norm(T[:3, 3] - other[:3, 3]) <= SAME_MM and turned <= SAME_RAD)


def _is_on(asked: _Asked, q: FloatArray, cell: Cell) -> bool:
    """Tell whether states (n, 12) are on the line or arc in the part, if there is one."""
    if asked.move is None:
        return True
    p = asked.move.select(np.zeros(len(q), dtype=np.int64)).positions(np.linspace(0.0, 1.0, len(q)))
    return bool(np.linalg.norm(cell.tool_in_part(q)[:, :3, 3] - p, axis=1).max() <= SAME_MM)


@dataclass(frozen=True, slots=True, eq=False)
class InStep:
    """The common moves of two robots, as their texts have them."""

    torch: Sequence[Motion]  #: The joints of robot 2 are the external axes of their places.
    with_line: Mapping[tuple[str, int], str]  #: By file and line of robot 1: where robot 2 is.
    sweep: CellSweep
    start: FloatArray  #: shape (12,). Near to where both begin, rad.
    faults: Sequence[tuple[str, int, str]]  #: What was not followed, and moves without one of the other robot.

    def legs(self) -> Iterator[tuple[Motion, FloatArray | None]]:
        """Yield the moves with their states."""
        return self.sweep.legs(self.torch, self.start)

    def meetings(self) -> Iterator[Meeting]:
        """Yield where something meets something."""
        for each in self.sweep.meetings(self.torch, self.start):
            yield Meeting(each.motion, f"{self.other(each.motion)}{each.what}")

    def other(self, motion: Motion) -> str:
        """Say where robot 2 is; empty where one program moves both."""
        return self.with_line.get((motion.place.file, motion.place.line), "")


def in_step(
    files: Files, cell: Cell, start: FloatArray, *, tools: Sequence[str | int], part: TriangleMaterial | None = None
) -> InStep:
    """Execute programs of two robots that belong together, and pair their moves.

    `part`: In `part`, in the hand of robot 2.
    `start`: shape (12,). Near to where both begin, rad.
    `tools`: Names and numbers of the torch.
    """
    texts = texts_of(files)
    robots = [{name: text for name, text in texts.items() if _robot(Path(name)) == robot} for robot in ("1", "2")]
    holder, is_one = Recorder(pulses_of(cell.arm2)), not all(robots)
    torch = execute(
        texts if is_one else robots[0],
        tools=tools,
        T_flange_tool=cell.T_flange_tool.matrix,
        T_base_frame=cell.T_part.matrix,  # of frames that are coupled to robot 2
        recorder=Recorder(pulses_of(cell.arm)),
        leader=holder if is_one else None,
    )
    held = holder.trace if is_one else execute(robots[1], recorder=holder)
    faults = [(each.place.file, each.place.line, each.text) for each in (*torch.unknowns, *held.unknowns)]
    faults += _complaints(texts)
    faults += ((place.file, place.line, what) for place, what in arc_faults(torch))
    if sum(each.does in SEAM_ENDS for each in torch.events) != len(SEAM_MARKS):
        faults.append((next(iter(texts)), 1, "the comments at the start and at the end of the seam are not there once"))
    pairs = list(_joined(_paired(torch, held, faults), cell, start[JOINTS:], faults))
    lines = {
        (one.place.file, one.place.line): f"with {two.place.file}, line {two.place.line}: "
        for one, two in pairs
        if not is_one
    }
    sweep = CellSweep(
        cell,
        part,
        start[JOINTS:],
        has_moving_axes=True,
        follows=True,
        is_carried=not is_one,  # one program for both has poses in the base of each robot
        holder_on_line=any(motion.kind == "L" for motion in held.motions),
    )
    return InStep([one for one, _ in pairs], lines, sweep, start, faults)


def _joined(
    pairs: Iterable[tuple[Motion, Motion]], cell: Cell, q2: FloatArray, faults: list[tuple[str, int, str]]
) -> Iterator[tuple[Motion, Motion]]:
    """Yield moves of the torch, whose external axes are the joints of robot 2, with its moves.

    `q2`: shape (6,). Near to where robot 2 begins, rad.
    """
    for one, two in pairs:
        try:
            end = _joints_of(two, cell, q2)
        except GeometryError as error:
            faults.append((two.place.file, two.place.line, str(error)))
            return
        via = () if two.via_joints is None else tuple(two.via_joints.tolist())
        if via and not _is_between(np.radians(via), q2, end):
            faults.append((two.place.file, two.place.line, "robot 2 does not move evenly by the joints"))
        q2 = end
        blends = one.place.blends or two.place.blends
        place = replace(one.place, blends=blends, external=tuple(np.degrees(q2).tolist()), via_external=via)
        yield replace(one, place=place), two


def _robot(path: Path) -> str:
    found = ROBOT.fullmatch(path.stem)
    return "" if found is None else found[1]


def is_second(path: Path) -> bool:
    """Tell whether a program is that of robot 2, which holds the part."""
    return _robot(path) == "2"


def _complaints(texts: Mapping[str, str]) -> Iterator[tuple[str, int, str]]:
    for name, text in texts.items():
        grammar = grammar_of_file(Path(name))
        if grammar is not None and grammar.judge_step is not None:
            yield from ((name, line or 1, what) for what, line in grammar.judge_step(text.splitlines(), Path(name)))


def _paired(torch: Trace, held: Trace, faults: list[tuple[str, int, str]]) -> Iterator[tuple[Motion, Motion]]:
    """Yield the moves of both robots that belong together, up to the first without the other."""
    for one, two in zip_longest(torch.motions, held.motions):
        if one is None or two is None or _mark(one, two) != _mark(two, one):
            places = [each.place for each in (one, two) if each is not None]
            where = " and ".join(f"{place.file}, line {place.line}" for place in places[1:])
            with_other = f"with {where}: " if where else ""
            faults.append((places[0].file, places[0].line, f"{with_other}a move without that of the other robot"))
            return
        yield one, two


def _mark(one: Motion, two: Motion) -> str | int:
    return one.place.line if one.place.file == two.place.file else one.place.mark


def _joints_of(motion: Motion, cell: Cell, near: FloatArray) -> FloatArray:
    """Return the joints of robot 2 at the end of a move, shape (6,), rad."""
    if motion.joints is not None:
        return np.asarray(np.radians(motion.joints))
    if motion.goal is None:
        raise GeometryError("nobody knows where robot 2 goes")
    flange = (motion.goal @ inverse_pose(motion.T_flange_tool))[None]
    return np.asarray(nearest_joints(cell.arm2, flange, near[None])[0])


def _is_between(q: FloatArray, before: FloatArray, end: FloatArray) -> bool:
    way = end - before
    share = (q - before) @ way / max(way @ way, STILL_RAD**2)
    return bool(np.abs(before + share * way - q).max() <= STILL_RAD)
