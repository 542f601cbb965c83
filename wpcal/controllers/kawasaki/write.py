"""Kawasaki AS: one file ``NAME.as`` with a program per seam, one that calls them all, and the transformation values.

O, A, T in degrees with ``R = Rz(O) Ry(A) Rz(T)``; lengths in mm. Points are relative to ``wp_part``, the part as
calibrated, which every program makes its ``BASE``. A transformation value has no configuration: the arm keeps the one
that it comes with. Joint moves of a plan go to precision points (``#wpj0001`` in ``.JOINTS``), which state all axes: a
seam then keeps the configuration of the move before it. Axes of a positioner follow the six of the arm, in both kinds.

References: The form of files, ``BASE``, ``TOOL``, ``SPEED … MM/S ALWAYS``, ``ACCURACY``, ``BREAK``, ``LMOVE``,
``C1MOVE`` and ``C2MOVE`` follow public programs of Kawasaki robots (docs/how-to/kawasaki.md).
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from functools import partial

import numpy as np

from wpcal.controllers.kawasaki.arc import conditions, weld_moves
from wpcal.controllers.language.emit import Around, WeldWriter
from wpcal.controllers.language.naming import NameRules, own_name, reserved_words
from wpcal.controllers.language.rounding import rounded_frame, texts, zyz_degrees
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe_path, part_frame
from wpcal.controllers.program.planned import ALONE, PlannedMoves
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform

NAMES = NameRules("AS", 15, reserved_words(__file__))  #: Names have up to 15 characters: controllers cut longer ones.
MM_DECIMALS = 5
DEG_DECIMALS = 6  #: As for the other controllers with 32-bit numbers, which resolve 1e-4 mm and 1e-5 deg.
as_frame = partial(rounded_frame, mm_decimals=MM_DECIMALS, deg_decimals=DEG_DECIMALS, is_zyz=True)
LONGEST_COMMENT = 76
JOINT_PERCENT = 5  #: The speed of the only joint move. Slow, because the arm can come from anywhere.
ACCURACY_MM = 1  #: Distance from a corner at which the tool may leave the path: the default least step of seams.
PROGRAM = "weld_"  #: The name of a program is this and the name of its seam.
PART, SAFE_POINT = "wp_part", "wp_safe"
JOINTS = "#wpj"
"""The name of a precision point of a plan is this and its number."""


def write_as(program: WeldProgram) -> dict[str, str]:
    """Write an AS file, ``NAME.as``.

    Raises `InputError` when AS does not allow the tool's name, has no condition for a weld, or axes move along a seam.
    """
    _refuse_coordination(program.planned)
    return _As(program).files()


def _refuse_coordination(planned: PlannedMoves | None) -> None:
    if planned is not None and planned.follows:
        raise InputError(
            "AS: the positioner turns along a seam, and no public source states such moves of AS; plan with "
            "--position any to weld with the positioner at rest, or write RAPID, KRL, INFORM or FANUC"
        )
    if planned is not None and planned.rail is not None:
        raise InputError(
            f"AS: no public source states whether positions move with a rail ({planned.rail}); write RAPID, KRL, "
            "INFORM or FANUC"
        )


def without_repeats(lines: Iterable[str]) -> list[str]:
    """Leave out every ``SPEED … ALWAYS`` that is in force already."""
    kept, now = list[str](), ""
    for line in lines:
        if line.startswith("  SPEED ") and line.endswith(" ALWAYS"):
            if line == now:
                continue
            now = line
        kept.append(line)
    return kept


def as_speed(mm_s: float) -> str:
    """Write a speed."""
    return f"{mm_s:g} MM/S"


def transformations(p: FloatArray, R: FloatArray) -> list[str]:
    """Write poses as six numbers: p of shape (n, 3), mm, and R of shape (n, 3, 3), in any one frame."""
    turns = texts(zyz_degrees(R, decimals=DEG_DECIMALS), DEG_DECIMALS)
    return [" ".join([*at, *turn]) for at, turn in zip(texts(p, MM_DECIMALS), turns, strict=True)]


def as_frame_text(T: RigidTransform) -> str:
    """Write one frame."""
    return transformations(T.t_mm[None], T.R[None])[0]


class _As(WeldWriter):
    format, names, longest_comment, zone_mm = "as", NAMES, LONGEST_COMMENT, ACCURACY_MM
    starts_in_air, sets_tool = False, True
    first = f"{JOINT_PERCENT}"

    def __init__(self, program: WeldProgram) -> None:
        super().__init__(program)
        self.main, self.stems = self.own_names(max(program.label_width + 1, len(PROGRAM)))
        self.conditions = conditions(program)
        self.T_base_frame = as_frame(program.T_base_part)

    speed_of = staticmethod(as_speed)

    @property
    def frames(self) -> list[str]:
        tool = own_name(self.program.controller.tool_name, NAMES, what="tool")
        return [f"  BASE {PART}", f"  TOOL {tool}", "  CP ON", f"  ACCURACY {ACCURACY_MM} ALWAYS"]

    def files(self) -> dict[str, str]:
        program, between = self.program, self.between()
        points, tool = [f"{PART} {as_frame_text(self.T_base_frame)}"], program.tool_data
        points += [] if tool is None else [f"{program.controller.tool_name} {as_frame_text(as_frame(tool))}"]
        if program.safe_point is not None:
            points += self._points([SAFE_POINT], program.safe_point)
        seams = list[str]()
        for (_, last), path in zip(between, program.paths, strict=False):
            labels = self.labels(path)
            seams += [f".PROGRAM {PROGRAM}{self.stems[path.seam.name]}()", *self._seam(path, labels, last), ".END"]
            points += self._points(labels, path)
        for row, path in enumerate(program.paths):
            stem = self.stems[path.seam.name]
            if lines := self.alone(row, [f"  CALL {PROGRAM}{stem}", "  BASE NULL"]):
                seams += [f".PROGRAM {ALONE}{stem}()", *self.run([*self.frames, *lines]), ".END"]
        calls = self._calls([before for before, _ in between])
        head = [f".PROGRAM {self.main}()", *self.post.header(self._about())]
        lines = [
            *head,
            *self.run(calls),
            *self.post.footer(),
            ".END",
            *seams,
            ".TRANS",
            *points,
            ".END",
            *self._joints(),
            "",
        ]
        return {f"{self.main}.as": "\r\n".join(lines)}

    def _calls(self, between: Sequence[Sequence[str]]) -> list[str]:
        calls = [f"  CALL {PROGRAM}{stem}" for stem in self.stems.values()]
        if self.program.safe_point is not None:
            first = self.post.air_move(SAFE_POINT, speed=self.first, joint=True)
            return [*self.frames, *first, *calls, f"  BASE {PART}", *self.air_moves([SAFE_POINT]), "  BASE NULL"]
        if self.planned is None:
            return calls
        ways = zip(between, [*calls, "  BASE NULL"], strict=True)
        return [*self.frames, *(line for way, call in ways for line in (*way, call))]

    def _joints(self) -> list[str]:
        """Return the section of the joints that a plan goes to: the axes of the arm, then those of the positioner."""
        if self.planned is None:
            return []
        lines = list[str]()
        for moves, numbers in self.planned.numbered():
            outer = self.planned.external_texts(moves.external, DEG_DECIMALS)
            rows = zip(numbers, texts(np.degrees(moves.joints), DEG_DECIMALS), outer, strict=True)
            lines += [f"{JOINTS}{number:04d} {' '.join([*row, *axes])}" for number, row, axes in rows]
        return [".JOINTS", *lines, ".END"]

    def _points(self, labels: list[str], poses: WeldPath | SafePoint) -> list[str]:
        values = transformations(*poses.poses_in(self.T_base_frame))
        if self.planned is None or not isinstance(poses, WeldPath) or poses.external is None:
            return [f"{label} {value}" for label, value in zip(labels, values, strict=True)]
        outer = self.planned.external_texts(poses.external, DEG_DECIMALS)
        rows = [" ".join([label, value, *axes]) for label, value, axes in zip(labels, values, outer, strict=True)]
        return rows[poses.before :]  # a plan goes to joints before a seam

    def _about(self) -> list[str]:
        program, planned = self.program, self.planned
        axes = [] if planned is None else [f"JT{row} = {name}" for row, name in enumerate(planned.turning, start=7)]
        text = [
            f"points are relative to {PART}, {part_frame(program)}; mm; R = Rz(O) Ry(A) Rz(T), deg",
            f"written with {MM_DECIMALS} and {DEG_DECIMALS} decimals: within 0.00001 mm and 0.000001 deg",
            "the configuration is not known: the arm keeps the one it comes with"
            if planned is None
            else "the configuration is that of the joint move before each seam: the arm keeps it",
            *([f"external axes: {', '.join(axes)}; each is after the six values of a point, deg"] if axes else []),
            f"the transformation {program.controller.tool_name} (the torch) must be on the controller",
            *self._arc_in_words(),
        ]
        return self.about(text)

    def _arc_in_words(self) -> list[str]:
        """Say which conditions of the controller the program sets, and which it needs."""
        own = self.conditions.values()
        if not own:
            return ["the arc burns from ARC ON to ARC OFF"]
        told = []
        if written := sorted({each.weld for each in own if each.lines}):
            told.append(f"W1SET and W2SET replace weld conditions of the controller: {', '.join(map(str, written))}")
        if needed := sorted({each.weld for each in own if not each.lines}):
            told.append(f"weld conditions that must be on the controller: {', '.join(map(str, needed))}")
        return [*told, "gas, and the delay before the torch moves, are those of the controller"]

    def joint_move(self, number: int) -> list[str]:
        percent = 0.0 if self.planned is None else self.planned.joint_percent
        return self.post.joint_move(f"{JOINTS}{number:04d}", speed=f"{percent:.0f}")

    def _seam(self, path: WeldPath, labels: list[str], to_start: list[str]) -> list[str]:
        own = self.conditions.get(path.seam.name)
        speed = {"speed": as_speed(self.program.weld_speed_mm_s(path))}
        moves = self.seam(path, labels, Around(on=partial(list, own.lines if own else ()), start=speed))
        head = self.comments([path.seam.name, describe_path(path)], mark="; ")
        return without_repeats([*head, *self.frames, *to_start, *moves])

    def weld_moves(self, path: WeldPath, along: Sequence[str]) -> list[str]:
        return weld_moves(path, along, path.stops(ACCURACY_MM), self.conditions.get(path.seam.name))
