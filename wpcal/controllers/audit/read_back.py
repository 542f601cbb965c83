"""Read programs back with the grammars of their languages: the poses, the moves between them, and where these lead."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from wpcal.controllers.language.grammar import ENCODING, Grammar, Step
from wpcal.controllers.registry import grammar_of_file
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.moves.interpolation import Moves, turns_between
from wpcal.taught.programs import BASE

STEP_MM = 1.0  #: Places along a move: as fine as weld poses are compared with the part before they are written.
STEP_RAD = np.radians(2.0)  #: Turns of a tool of 300 mm move its end by 10 mm in a step.
LARGEST_MOVE_MM = 20_000.0  #: No robot makes longer moves; they are not followed.


@dataclass(frozen=True, slots=True, eq=False)
class ReadPose:
    """One pose of a program as a controller would take it."""

    name: str  #: Of the point, or its number.
    line: int | None
    p_base: FloatArray  #: shape (3,). Tool centre point in `base`, mm.
    R_base: FloatArray  #: shape (3, 3). Axes of the tool in `base`.
    #: False if the file does not say where its user frame is: position and axes are then in that frame.
    in_base: bool = True


def require_grammar(path: Path) -> Grammar:
    """Return the grammar of a file by its suffix; `InputError` in one line when no controller has one."""
    grammar = grammar_of_file(path)
    if grammar is None:
        raise InputError(f"{path}: no language is known whose programs are {path.suffix or 'without a suffix'} files")
    return grammar


def is_weld_program(path: Path) -> bool:
    """Tell by the suffix whether the poses of a file can be read back."""
    grammar = grammar_of_file(path)
    return grammar is not None and path.suffix.lower() in grammar.poses_in


def read_poses_back(
    raw: bytes, path: Path, T_base_part: RigidTransform | None, *, is_carried: bool = False
) -> list[ReadPose]:
    """Return the poses of a program's file in `base`.

    Raises
    ------
    InputError : When no grammar knows the suffix.
    FormatError
        When the file breaks its format, or a point of a weld program cannot be used. Joint values are left out, and so
        are points of other programs that have no coordinates.
    """
    found = require_grammar(path).read(raw.decode(ENCODING), str(path))
    poses = []
    for point in found.points:
        line = point.line or None
        if point.joints is not None or (point.fault and T_base_part is None):
            continue
        if point.fault and not (is_carried and np.isfinite(point.p_mm).all()):
            raise FormatError(f"point {point.name}: {point.fault}", path=str(path), line=line)
        T = None if point.at_flange else _frame_of(point.frame, found.frames, T_base_part)
        if T is None:
            poses.append(ReadPose(point.name, line, point.p_mm, point.R, in_base=False))
        else:
            poses.append(ReadPose(point.name, line, T.apply(point.p_mm), T.R @ point.R))
    return poses


def _frame_of(
    frame: str | None, carried: Mapping[str, RigidTransform], T_base_part: RigidTransform | None
) -> RigidTransform | None:
    if frame == BASE:
        return RigidTransform.identity(target="base", source="frame")
    return carried.get(frame or "", T_base_part)


def read_moves(raw: bytes, path: Path) -> list[list[Step]]:
    """Return the moves of a program; in each list one leads to the next.

    Only what is between two poses of one file, or of a pair of files, is read: the first move of a procedure comes from
    wherever its caller left the tool. Loops over the points of an array are not followed.

    Raises `InputError` when no grammar knows the suffix.
    """
    return require_grammar(path).chains_of(raw, path)


def places_between(
    poses: Sequence[ReadPose], chains: Sequence[Sequence[Step]]
) -> tuple[FloatArray, FloatArray, list[ReadPose]]:
    """Return where the tool is between the poses of a program.

    Returns `p, R`: ndarray, shapes (m, 3) and (m, 3, 3). In `base`.
    Returns `to`: list of ReadPose. The end of the move of each place.
    """
    named = {pose.name.lower(): pose for pose in poses}
    by_name: Mapping[str, ReadPose] = {
        **{f"x{name}": pose for name, pose in named.items()},
        **named,
    }  # folds name points without their X
    rows = list[tuple[ReadPose, ReadPose, FloatArray]]()
    for chain in chains:
        for before, step in pairwise(chain):
            known = [by_name.get(name.lower()) for name in (before[-1], *step)]
            start, end = known[0], known[-1]
            if start is None or end is None or None in known:
                continue
            if np.linalg.norm(end.p_base - start.p_base) > LARGEST_MOVE_MM:
                continue
            middle = known[1] if len(known) == 3 else None
            rows.append((start, end, np.full(3, np.nan) if middle is None else middle.p_base))
    if not rows:
        return np.zeros((0, 3)), np.zeros((0, 3, 3)), []
    starts, ends, via = zip(*rows, strict=True)
    p0, p1 = (np.array([pose.p_base for pose in side]) for side in (starts, ends))
    R0, R1 = (np.array([pose.R_base for pose in side]) for side in (starts, ends))
    turn = turns_between(R0, R1)
    moves = Moves.between(p0, R0, p1, turn, np.array(via))
    length = np.maximum(np.linalg.norm(moves.chord, axis=1), moves.sweep * np.linalg.norm(moves.u, axis=1))
    steps = np.maximum(length / STEP_MM, np.linalg.norm(turn, axis=1) / STEP_RAD)
    counts = np.maximum(np.ceil(steps).astype(np.int64) - 1, 0)
    own = np.repeat(np.arange(len(counts)), counts)
    number = np.arange(len(own)) - np.repeat(np.cumsum(counts) - counts, counts)
    share = (number + 1) / (counts[own] + 1)
    at = moves.select(own)
    return at.positions(share), at.rotations(share), [ends[row] for row in own]
