"""The poses that a finished program leads to, in its order, and which of two programs' poses belong together."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from wpcal.calibrate.solve.least_squares import kabsch
from wpcal.controllers.judge.execute import execute, interpreted, programs_of, text_at
from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.machine import Place, rigid
from wpcal.controllers.run.recorder import Motion, Trace
from wpcal.core.arrays import BoolArray, FloatArray
from wpcal.core.errors import InputError
from wpcal.core.input_file import read_bytes
from wpcal.core.same_bits import inverse_pose
from wpcal.seam.record_check import FARTHEST_MM

NEAR_MM = 25.0  #: A pose that has another name is the same point, corrected, within this distance.
NUMBERED = re.compile(r"^[ \t]*\d+:")  #: Numbers of lines change when one is added.


@dataclass(frozen=True, slots=True, eq=False)
class ProgramPose:
    """One pose of a program."""

    place: Place
    text: str  #: The instruction, without the number of its line.
    T: FloatArray  #: T_base_tool, shape (4, 4).
    seam: int  #: From 1 on in the order of the program; 0 off the seams.
    is_via: bool = False  #: The middle of an arc.

    @property
    def key(self) -> tuple[str, str, bool]:
        """What the pose is called in its program; a pendant may spell it with other capitals."""
        return self.place.file.lower(), self.text.lower(), self.is_via

    @property
    def where(self) -> str:
        """File and line."""
        return f"{self.place.file}, line {self.place.line}"


@dataclass(frozen=True, slots=True, eq=False)
class ProgramText:
    """A program of one language: its files, and where it leads."""

    files: Mapping[str, bytes]
    poses: tuple[ProgramPose, ...]
    tools: frozenset[str]  #: Names or numbers of the tools with which it moves.
    unread: tuple[str, ...] = ()  #: What was not followed, by file and line.
    beside: Mapping[str, bytes] = field(default_factory=dict)  #: Other files of the program, which move nothing.

    @property
    def suffixes(self) -> set[str]:
        """The suffixes of its files, lower case."""
        return {Path(name).suffix.lower() for name in self.files}


def read_program(path: Path, *, like: ProgramText | None = None) -> ProgramText:
    """Read a program: a folder, or one file and those beside it that belong to it.

    `like`: The program as it was written. Of a folder, files of other suffixes are left out.

    Raises `InputError` when there is no program, or more than one language, or one of them cannot be executed.
    """
    found = _files_at(path, like)
    files = {name: data for name, data in found.items() if name in programs_of(found)}
    languages = {c.name for name in files if (c := interpreted(name)) is not None}
    if len(languages) != 1:
        what = "no program in a language that wpcal executes" if not languages else "programs in more than one language"
        raise InputError(f"{path}: {what}; give the folder or the file of one program")
    with np.errstate(all="ignore"):  # of numbers that are none the poses tell
        trace = execute(files)
    unread = tuple(f"{each.place.file}, line {each.place.line}: {each.text}" for each in trace.unknowns)
    poses = tuple(_poses(trace, files))
    for pose in poses:
        if not float(np.abs(pose.T).max()) < FARTHEST_MM:
            raise InputError(f"{pose.where}: a pose that is no number, or more than {FARTHEST_MM:g} mm away")
    beside = {name: data for name, data in found.items() if name not in files}
    return ProgramText(files, poses, frozenset(pose.place.tool for pose in poses), unread, beside)


def _files_at(path: Path, like: ProgramText | None) -> dict[str, bytes]:
    names = set() if like is None else {name.lower() for name in (*like.files, *like.beside)}
    suffixes = {Path(name).suffix for name in names}
    if not path.exists():
        raise InputError(f"{path}: no such file or folder; expected the program as it came back from the robot")
    is_folder = path.is_dir()
    return {
        each.name: read_bytes(each)
        for each in sorted((path if is_folder else path.parent).iterdir())
        if each.is_file() and (is_folder or each == path or each.name.lower() in names)
        if not suffixes or each.suffix.lower() in suffixes
    }


def _poses(trace: Trace, files: Mapping[str, bytes]) -> Iterator[ProgramPose]:
    """Yield poses; moves to joints have none.

    Along a seam are those between its marks. Where the arc is on before the first of them, the weld begins at the one
    before.
    """
    motions = iter(trace.motions)
    seam, count, is_dry, found = 0, 0, False, list[ProgramPose]()
    for event in trace.events:
        if event.does is Does.MOVE:
            motion = next(motions)
            if seam and found and not found[-1].seam and (is_dry or motion.arc_on):
                found[-1] = replace(found[-1], seam=seam)
            found += _poses_of(motion, seam, files)
        elif event.does in (Does.START, Does.DRY) and not seam:
            count += 1
            seam, is_dry = count, event.does is Does.DRY
        elif event.does in (Does.END, Does.DRY, Does.STOP):
            seam = 0
    yield from found


def _poses_of(motion: Motion, seam: int, files: Mapping[str, bytes]) -> list[ProgramPose]:
    text = NUMBERED.sub("", text_at(motion.place, files)).strip()
    ends = ((motion.via, True), (motion.goal, False))
    return [ProgramPose(motion.place, text, T, seam, is_via) for T, is_via in ends if T is not None]


def seams_beside(poses: Sequence[ProgramPose]) -> list[int]:
    """Return the seam of the program that each pose is on, or comes just before or after; 0 for all others."""
    own = [pose.seam for pose in poses]
    return [
        seam or max(own[row + 1 : row + 2], default=0) or max(own[max(row - 1, 0) : row], default=0)
        for row, seam in enumerate(own)
    ]


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """Which poses of two programs are the same point."""

    old: tuple[int, ...]  #: Rows of the program as written.
    new: tuple[int, ...]  #: The rows of the changed program that belong to them.
    deleted: tuple[int, ...]
    added: tuple[int, ...]


def pair_poses(old: Sequence[ProgramPose], new: Sequence[ProgramPose]) -> Pairs:
    """Find the poses that belong together: by their names, then by their places.

    Order does not count: seams may be welded in another one. A pose that was renamed, or whose instruction was changed
    otherwise, is found by its place among those that are left.
    """
    found = dict(_by_name(old, new))
    left_old = [row for row in range(len(old)) if row not in found]
    taken = set(found.values())
    left_new = [row for row in range(len(new)) if row not in taken]
    found.update(_by_place(old, new, left_old, left_new))
    rows, taken = sorted(found), set(found.values())
    return Pairs(
        tuple(rows),
        tuple(found[row] for row in rows),
        tuple(row for row in range(len(old)) if row not in found),
        tuple(row for row in range(len(new)) if row not in taken),
    )


def _by_name(old: Sequence[ProgramPose], new: Sequence[ProgramPose]) -> Iterator[tuple[int, int]]:
    """Pair poses of one name, those that appear more than once in their order. A single file may have been renamed."""
    counts, rows = (Counter[Any](), Counter[Any]()), (dict[Any, int](), dict[Any, int]())
    is_one = all(len({pose.place.file for pose in poses}) == 1 for poses in (old, new))
    for side, poses in enumerate((old, new)):
        for row, pose in enumerate(poses):
            key = pose.key[1:] if is_one else pose.key
            counts[side][key] += 1
            rows[side][key, counts[side][key]] = row
    for key, row in rows[0].items():
        if counts[0][key[0]] == counts[1][key[0]]:
            yield row, rows[1][key]


def _by_place(
    old: Sequence[ProgramPose], new: Sequence[ProgramPose], left_old: Sequence[int], left_new: Sequence[int]
) -> Iterator[tuple[int, int]]:
    if not left_old or not left_new:
        return
    a, b = (np.array([poses[row].T[:3, 3] for row in rows]) for poses, rows in ((old, left_old), (new, left_new)))
    apart = np.linalg.norm(a[:, None] - b[None], axis=2)
    other = np.array([[(old[i].seam > 0) != (new[j].seam > 0) for j in left_new] for i in left_old])
    cost = np.minimum(apart + NEAR_MM * other, 2.0 * NEAR_MM)
    for i, j in np.column_stack(linear_sum_assignment(cost)).tolist():
        if cost[i, j] < NEAR_MM:
            yield left_old[i], left_new[j]


def common_motion(old: FloatArray, new: FloatArray) -> tuple[FloatArray, bool] | None:
    """Return the motion that many poses share, shape (4, 4), and whether it is one of the tool; None if more stand.

    `old`, `new`: shape (n, 4, 4). A motion D of the frame gives ``new = D old``, one X of the tool ``new = old X``.
    """
    stand = float(_agree(old, new).mean()) if len(old) >= LEAST_POSES else 1.0
    if stand > 0.5:
        return None
    for is_tool in (False, True):
        a, b = (inverse_pose(old), inverse_pose(new)) if is_tool else (old, new)
        begun = b @ inverse_pose(a)
        shared = [_agree(T @ a, b, factor=ROUGHLY) for T in begun]
        rows = max(shared, key=np.sum)
        if rows.mean() > max(stand, LEAST_SHARE):
            T = _aligned(a[rows], b[rows])
            rows = _agree(T @ a, b)  # without those that were corrected by a little besides
            T = _aligned(a[rows], b[rows]) if rows.any() else T
            return (inverse_pose(T) if is_tool else T), is_tool
    return None


LEAST_SHARE = 1 / 3  #: Of all poses, that this many move together to the last digit is no accident.
LEAST_POSES = 4  #: Fewer share nothing that means a frame.
SAME_MM = 0.03
"""Positions within this are the same: programs round to 0.001 mm and 0.001°, at 1 m from the part's frame."""
SAME_TURN = 5e-4  #: The same for the elements of rotations.
ROUGHLY = 5.0  #: Times these, before a motion is fitted to many poses.
ARM_MM = 300.0  #: The axes of a pose count as points this far from it when poses are aligned.


def _agree(a: FloatArray, b: FloatArray, *, factor: float = 1.0) -> BoolArray:
    off = np.linalg.norm(a[:, :3, 3] - b[:, :3, 3], axis=1) <= factor * SAME_MM
    return np.asarray(off & (np.abs(a[:, :3, :3] - b[:, :3, :3]).max(axis=(1, 2)) <= factor * SAME_TURN))


def _aligned(a: FloatArray, b: FloatArray) -> FloatArray:
    """Return the motion T with T a ≈ b by least squares over the poses and their axes."""
    x, y = (np.concatenate([T[:, :3, 3], *(T[:, :3, 3] + ARM_MM * T[:, :3, k] for k in range(3))]) for T in (a, b))
    return rigid(*kabsch(x, y, np.full(len(x), 1.0 / len(x))))
