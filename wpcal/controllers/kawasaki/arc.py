"""Arc instructions of Kawasaki AS: ``LWS``, ``LWC``, ``C1WC``, ``C2WC``, ``LWE``, and weld conditions.

The moves themselves weld. ``LWS`` goes to the start of a seam and strikes the arc there. ``LWC point ,n`` and
``C1WC``/``C2WC`` weld with condition n. ``LWE point ,n,m`` welds to the end and fills the crater with condition m. No
end of an arc is known that ends the weld too, so a seam that ends in an arc has a ``LWE`` to the same point after it.

``W1SET n = speed, current, voltage, width, frequency`` sets condition n: cm/min, A, V, mm, Hz. ``W2SET m = time,
current, voltage`` sets a crater: s, A, V. With a job in the weld data, condition n is that job, as the controller
has it.

References: Public programs and post-processors that weld with these instructions (see docs/how-to/kawasaki.md, which
also states what none of them confirms).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

from wpcal.controllers.program import WeldPath, WeldProgram
from wpcal.controllers.program.arc import end_time_s, has_weave, needed, refuse
from wpcal.robot.moves import Arc, Move

LANGUAGE = "AS"
VALUES = "without a job the values are written"
MOST_CONDITIONS = 99  #: A program with more different welds is refused: no public program has a higher number.
CM_PER_MIN = 6.0  #: Of a mm/s.


@dataclass(frozen=True, slots=True)
class Conditions:
    """The weld and crater conditions of one seam."""

    weld: int  #: Number of the weld condition.
    crater: int | None  #: Number of the crater condition; None for a seam without crater filling.
    lines: tuple[str, ...]  #: The instructions that set them; empty if the controller has them.


@dataclass(slots=True)
class _Numbers:
    """Numbers of conditions: the same values get the same number; those of jobs stay free."""

    taken: frozenset[int]
    known: dict[str, int] = field(default_factory=dict)

    def number_of(self, values: str) -> int:
        if values not in self.known:
            used = self.taken | set(self.known.values())
            self.known[values] = next(number for number in range(1, len(used) + 2) if number not in used)
        return self.known[values]


def conditions(program: WeldProgram) -> Mapping[str, Conditions]:
    """Return the conditions of every seam by its name; empty for a dry run.

    Raises `InputError` when the weld data of a seam states neither a job nor current and voltage, a weave that AS does
    not have, or a weave and a job.
    """
    if program.arc is None:
        return {}
    jobs = frozenset(path.values.job for path in program.paths if path.values.job is not None)
    welds, craters = _Numbers(jobs), _Numbers(jobs)
    return {path.seam.name: _conditions(path, program, welds, craters) for path in program.paths}


def _conditions(path: WeldPath, program: WeldProgram, welds: _Numbers, craters: _Numbers) -> Conditions:
    job, time_s = path.values.job, end_time_s(path)
    if job is not None:
        if has_weave(path):
            why = f"weld condition {job} of the controller has the weave; state null, or no job"
            raise refuse(path, "weave", language=LANGUAGE, why=why)
        return Conditions(job, job if time_s else None, ())
    current = needed(path, "current_a", language=LANGUAGE, why=VALUES)
    voltage = needed(path, "voltage_v", language=LANGUAGE, why=VALUES)
    speed = program.weld_speed_mm_s(path)
    text = f"{speed * CM_PER_MIN:.1f},{current:.0f},{voltage:.1f},{_weave(path, speed)}"
    weld = _allowed(welds.number_of(text), path)
    lines = [f"  W1SET {weld} = {text}"]
    if not time_s:
        return Conditions(weld, None, tuple(lines))
    if path.values.crater is not None:
        current, voltage = path.values.crater.current_a or current, path.values.crater.voltage_v or voltage
    text = f"{time_s:.2f},{current:.0f},{voltage:.1f}"
    crater = _allowed(craters.number_of(text), path)
    return Conditions(weld, crater, (*lines, f"  W2SET {crater} = {text}"))


def _allowed(number: int, path: WeldPath) -> int:
    if number > MOST_CONDITIONS:
        raise refuse(path, "job", language=LANGUAGE, why=f"more than {MOST_CONDITIONS} different weld conditions")
    return number


def _weave(path: WeldPath, speed_mm_s: float) -> str:
    """Return width, frequency and, if its number is stated, the pattern of a weave."""
    values = path.values
    if values.weave is None:
        if values.weave_data is not None:
            raise refuse(path, "weave_data", language=LANGUAGE, why="a weave needs width_mm and length_mm, too")
        return "0,0"
    if values.weave.dwell_left_s or values.weave.dwell_right_s:
        raise refuse(path, "weave", language=LANGUAGE, why="a weld condition has no dwells; state 0")
    pattern = values.weave_data or ""
    if pattern and not pattern.isdigit():
        raise refuse(path, "weave_data", language=LANGUAGE, why="expected the number of a weave pattern")
    hertz = values.weave.frequency_hz(speed_mm_s)
    return f"{values.weave.width_mm:.1f},{hertz:.1f}{f',{int(pattern)}' if pattern else ''}"


def weld_moves(path: WeldPath, along: Sequence[str], stops: Sequence[bool], own: Conditions | None) -> list[str]:
    """Return the moves along a seam, with or without the arc."""
    lines, moves = [], list(zip(path.weld_moves, stops, strict=True))
    for number, (move, stop) in enumerate(moves, 1):
        is_last = number == len(moves)
        lines += _dry(move, along) if own is None else _welding(move, along, own, is_last=is_last)
        if stop and not (is_last and own is not None):
            lines.append("  BREAK")
    return lines


def _dry(move: Move, along: Sequence[str]) -> list[str]:
    if isinstance(move, Arc):
        return [f"  C1MOVE {along[move.via]}", f"  C2MOVE {along[move.to]}"]
    return [f"  LMOVE {along[move.to]}"]


def _welding(move: Move, along: Sequence[str], own: Conditions, *, is_last: bool) -> list[str]:
    end = f"  LWE {along[move.to]} ,{own.weld}{'' if own.crater is None else f',{own.crater}'}"
    if isinstance(move, Arc):
        arc = [f"  C1WC {along[move.via]} ,{own.weld}", f"  C2WC {along[move.to]} ,{own.weld}"]
        return [*arc, end] if is_last else arc
    return [end] if is_last else [f"  LWC {along[move.to]} ,{own.weld}"]
