"""What a program says about itself in its header, in words that every language shares."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.controllers.program import WeldPath, WeldProgram
from wpcal.controllers.program.arc import arc_in_words
from wpcal.controllers.program.planned import PlannedMoves
from wpcal.core.arrays import FloatArray
from wpcal.core.version import __version__
from wpcal.core.wording import listed
from wpcal.robot.moves import Arc, Move, PathTolerance
from wpcal.seam.seam import SeamFrames
from wpcal.weld.runs import WeldRun
from wpcal.weld.values import WeldValues, describe_weld

SHARP_RAD = float(np.radians(30.0))
"""A seam that turns by more between two steps has a corner there, as where seams are found."""
OFF_RAD = float(np.radians(0.5))
"""A torch that is less off the direction of travel goes with it: half a degree is what moves may be off, too."""


@dataclass(frozen=True, slots=True)
class TurnedCorner:
    """One corner of a run."""

    at_mm: float  #: Length from the start of the seam.
    turn_rad: float  #: By how much the seam turns there.
    #: `low_mm`, `high_mm`: Between these lengths the torch turns round the corner.
    low_mm: float
    high_mm: float
    #: Largest angle between the x of the seam's frame, which the torch keeps to, and the direction of travel.
    off_rad: float

    def __str__(self) -> str:
        """Say it as the comment of a program."""
        turn, off = np.degrees([self.turn_rad, self.off_rad])
        return (
            f"corner of {turn:.0f} deg at {self.at_mm:.1f} mm: the torch turns from {self.low_mm:.1f} to "
            f"{self.high_mm:.1f} mm, up to {off:.0f} deg off the travel"
        )


def find_turned_corners(frames: SeamFrames) -> tuple[TurnedCorner, ...]:
    """Return the corners of a seam at which a torch turns before and after the corner.

    A seam of two straight steps in one direction has none:

    >>> x, R = np.array([[0.0, 0, 0], [5, 0, 0], [9, 0, 0]]), np.tile(np.eye(3), (3, 1, 1))
    >>> find_turned_corners(SeamFrames(x[:, 0], x, R, np.full(3, 1.5), "part"))
    ()
    """
    chords = np.diff(frames.p, axis=0)
    lengths = np.linalg.norm(chords, axis=1)
    if len(chords) < 2 or not lengths.all():
        return ()
    travel = chords / lengths[:, None]
    turns = _angles(travel[:-1], travel[1:])
    x = frames.R[:, :, 0]
    before, after = travel[[0, *range(len(travel))]], travel[[*range(len(travel)), -1]]
    sides = _angles(x, before), _angles(x, after)
    off, most = np.minimum(*sides), np.maximum(*sides)
    rows, along = np.flatnonzero(turns > SHARP_RAD) + 1, np.flatnonzero(off <= OFF_RAD)
    low = np.concatenate([[0], along])[np.searchsorted(along, rows, "right")]
    high = np.concatenate([along, [len(off) - 1]])[np.searchsorted(along, rows)]
    ends, of = np.unique(np.stack([low, high]), axis=1, return_inverse=True)
    farthest = np.array([off[first : last + 1].max() for first, last in ends.T.tolist()])
    found = []
    for row, first, last, far in zip(rows.tolist(), low.tolist(), high.tolist(), farthest[of.ravel()], strict=True):
        if first < last:
            at, begin, end = (float(frames.s_mm[one]) for one in (row, first, last))
            found.append(TurnedCorner(at, float(turns[row - 1]), begin, end, float(max(far, most[row]))))
    return tuple(found)


def _angles(a: FloatArray, b: FloatArray) -> FloatArray:
    across = np.linalg.norm(np.cross(a, b), axis=1)
    return np.asarray(np.arctan2(across, np.einsum("ij,ij->i", a, b)), dtype=np.float64)


UNCHECKED = "NOT CHECKED for collisions with the part"
NOT_CHECKED = "NOT CHECKED: the arm, fixtures, cables, the way to the first point. RUN IT DRY FIRST"
"""Said in the header of every program and on the console."""
PLAN_NOT_CHECKED = (
    "NOT CHECKED: cables, hoses, clamps that the cell does not have, the way of the weave",
    "NOT CHECKED: the way from where the arm is to home, the first target. RUN IT DRY FIRST",
)
"""The same for a plan."""
POSES_ONLY = "poses only: this file switches no arc and keeps no speed; what reads it must"
SPEEDS = ("weld", "air")  #: Along a seam, and on all other lines and arcs.
SIDES = ("in front of", "behind")
USUAL_ZONE_MM = 1.0  #: Distance from a corner at which most of the languages let the tool leave the path.


def describe(program: WeldProgram, *, has_arc: bool = True) -> list[str]:
    """Return the lines that every program file states; without `has_arc`, its format holds poses only."""
    record = program.calibration
    source = "calibration.json and seams.json" if program.planned is None else "the plan in plan.json"
    lines = [f"written by wpcal {__version__} from {source}"]
    if "verdict" in record:
        lines.append(f"calibration {record['verdict']}, tolerance {record['tolerance_mm']:g} mm")
        if "judgement" in record:
            lines.append(record["judgement"]["sentence"])
    lines += _of_plan(program, program.planned) if program.planned is not None else _of_seams(program)
    woven = describe_woven_data(path.run for path in program.paths)
    unchecked = PLAN_NOT_CHECKED if program.planned is not None else (NOT_CHECKED,)
    told = speeds_in_words(max(map(program.weld_speed_mm_s, program.paths)), program.motion.air_speed_mm_s)
    told.append(arc_in_words(program.arc) if has_arc else POSES_ONLY)
    return [*lines, *told, *(program.checked or [UNCHECKED]), *woven, *unchecked]


def speeds_in_words(*mm_s: float) -> list[str]:
    """Say in a header which speeds, as `SPEEDS`, no line of its program exceeds."""
    return [f"{what} speed <= {most:g} mm/s" for what, most in zip(SPEEDS, mm_s, strict=True)]


def stated_speeds(text: str) -> list[float]:
    """Return the largest speeds along a seam and in the air that the header of a program states, mm/s; none: empty."""
    found = [re.search(rf"{what} speed <= (\d+\.?\d*) mm/s", text, re.IGNORECASE) for what in SPEEDS]
    return [float(each[1]) for each in found if each is not None]


def _of_plan(program: WeldProgram, planned: PlannedMoves) -> list[str]:
    lines = [*planned.about]
    if program.tool_data is not None:
        lines.append("SETS THE TOOL DATA to this tool: a tool centre point that was measured is overwritten")
    return lines if program.tolerance is None else [*lines, describe_moves(program, program.tolerance)]


def _spread(angles_rad: FloatArray) -> str:
    low, high = (f"{round(math.degrees(angle), 1):g}" for angle in (angles_rad.min(), angles_rad.max()))
    return low if low == high else f"{low} to {high}"


def _of_seams(program: WeldProgram) -> list[str]:
    torch = program.torch
    work, travel = np.concatenate([torch.angles(path.seam.lean_rad) for path in program.paths], axis=1)
    lines = [
        f"wire leaves the tip along +{torch.tool_axis.value} of the tool, z_sense inward",
        f"work angle {_spread(work)} deg, travel {_spread(travel)} deg (+ push)",
        f"turn about the wire: {'least' if program.tolerance is None else 'as few moves need it'}, "
        f"within {math.degrees(torch.spin_range_rad):g} deg of the travel direction",
        f"tool centre point {torch.standoff_mm:g} mm back from the tip, approach {program.motion.approach_mm:g} mm, "
        f"retract {program.motion.retract_mm:g} mm",
    ]
    if program.is_corrected:
        lines.append("its frame is corrected by the touch program beside it, which calls it: start that one")
    if program.tolerance is not None:
        lines.append(describe_moves(program, program.tolerance))
        if corners := sum(sum(path.stops(USUAL_ZONE_MM)[:-1]) for path in program.paths):
            most = program.tolerance.mm
            lines.append(f"stops at corners, where a zone would cut by more than {most:g} mm: {corners}")
    if program.arm is not None and (postures := program.posture_of(program.groups[0])) is not None:
        axis_1, lower_arm = SIDES[int(postures.is_behind[0])], SIDES[int(postures.is_behind_lower_arm[0])]
        lines.append(
            f"the arm {program.arm.name} follows all moves within its joint limits, in one branch: wrist {axis_1} "
            f"axis 1, {lower_arm} the lower arm"
        )
    return lines + [f"NOT WELDED: {why}" for why in program.left_out.values()]


def describe_woven_data(runs: Iterable[WeldRun | None]) -> list[str]:
    """Say that data of the controller may not weave where the points already do; no line if there are none."""
    named = {}
    for run in runs:
        if run is not None and run.is_woven:
            values = run.weld.values
            data = (("weld_data", values.weld_data), ("job", values.job))
            if words := [f"{name} {value}" for name, value in data if value is not None]:
                named[run.weld.name] = f"{run.weld.name} ({', '.join(words)})"
    if not named:
        return []
    what = "weaves of points: these data of the controller must have no weave of their own, or there are two"
    return [f"NOT CHECKED: {what}: {listed(named.values())}"]


def part_frame(program: WeldProgram) -> str:
    """Say what the frame is that positions are relative to."""
    planned = program.planned
    if planned is None:
        return "the part as calibrated"
    if planned.follows:
        return "the part, which the positioner carries"
    return "the base of the robot, as the part turns" if planned.turning else "the part as in the cell"


def describe_moves(program: WeldProgram, allowed: PathTolerance) -> str:
    """Return one line about the lines and arcs of a program: how far they are from the seams at most."""
    fitted = [path.moves for path in program.paths if path.moves is not None]
    points = [path.seam.name for path in program.paths if path.moves is None and not path.is_woven]
    told = []
    if fitted:
        mm, deg = max(moves.off_mm for moves in fitted), math.degrees(max(moves.off_rad for moves in fitted))
        limits = f"(allowed: {allowed.mm:g} mm, {math.degrees(allowed.wire_rad):g} deg)"
        told.append(f"lines and arcs: the wire is at most {mm:.3f} mm and {deg:.2f} deg off {limits}")
    if points:
        told.append(f"a line to every point of {listed(points)}, where longer ones would meet the part")
    return "; ".join(told) or "lines to every point of the weaves"


def describe_path(path: WeldPath) -> str:
    """Return one line about a seam: what it is, its points or moves, and its 95 % error."""
    seam = path.seam
    count = f"{path.weld_count} points" if path.moves is None else counted_moves(path.weld_moves)
    text = f"{seam.joint.value} {seam.weld.value}, {seam.length_mm:.1f} mm, {count}"
    if path.run is not None:
        words = [describe_weld(path.values), *_settings(path.values, path.speed_mm_s)]
        if path.run.is_tack:
            words.insert(0, "tack weld")
        if path.run.is_woven:
            words.append(f"weave of points, wire {path.run.speed_ratio:.3g} times as fast")
        text = ", ".join([*words, text])
    if seam.more_wire_mm:
        text += f", wire {seam.more_wire_mm:g} mm longer than usual: the tool stays back by it"
    if path.u95_mm is not None:
        text += f", 95 % error up to {path.u95_mm.max():.3f} mm"
    frames = seam.frames if path.run is None or path.run.middle is None else path.run.middle
    return "; ".join([text, *map(str, find_turned_corners(frames))])


def errors_mm(path: WeldPath) -> list[float | None]:
    """Return the 95 % error at each pose; None off the seam, or where it is not known."""
    along = [None] * path.weld_count if path.u95_mm is None else path.u95_mm.tolist()
    return [*[None] * path.before, *along, *[None] * path.after]


def _settings(values: WeldValues, planned_mm_s: float | None) -> list[str]:
    """Return current, voltage, wire feed and speed, that of a plan if any, as a person types them into a schedule."""
    numbers = (
        (values.current_a, "A"),
        (values.voltage_v, "V"),
        (values.wire_feed_m_min, "m/min wire"),
        (values.speed_mm_s if planned_mm_s is None else round(planned_mm_s, 1), "mm/s"),
    )
    return [f"{number:g} {unit}" for number, unit in numbers if number is not None]


def counted_moves(moves: Sequence[Move]) -> str:
    """Return how many lines and arcs there are, in words."""
    arcs = sum(isinstance(move, Arc) for move in moves)
    counts = ((len(moves) - arcs, "line"), (arcs, "arc"))
    return " and ".join(f"{count} {what}{'s' if count > 1 else ''}" for count, what in counts if count)
