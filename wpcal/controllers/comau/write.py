"""Comau PDL2: one program ``NAME.pdl`` with the frame of the calibrated part, its positions, and a routine per seam.

A position is ``POS(x, y, z, e1, e2, e3, '')`` in mm with Euler angles in degrees, ``R = Rz(e1) Ry(e2) Rz(e3)``; an
empty text of the configuration keeps the present one. Positions are relative to ``wp_part``, which the program makes
``$UFRAME``. Speeds are in m/s. How the tool turns on a line (``$ORNT_TYPE``) is not a turn about one axis in any of the
modes, so wpcal writes a line to every frame of a seam and no arcs.

PDL2 itself has no arc instructions: an output switches the arc, or the routines ``arc_start(job)`` and ``arc_end`` of a
program ``wp_arc`` of the user.

References: Comau, PDL2 Programming Language Manual, CR00758049 (POSITION, POS, MOVE, MOVEFLY, $UFRAME, $LIN_SPD,
$TERM_TYPE, $FLY_DIST, $PROG_SPD_OVR, EXPORTED FROM, DELAY).
"""

from __future__ import annotations

from collections.abc import Sequence

from wpcal.controllers.language.emit import ArcSwitch, WeldWriter
from wpcal.controllers.language.naming import NameRules, reserved_words
from wpcal.controllers.language.post import metres_per_second
from wpcal.controllers.language.rounding import rounded_frame, texts, zyz_degrees
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe_path, part_frame
from wpcal.core.arrays import FloatArray

NAMES = NameRules("PDL2", 32, reserved_words(__file__))  #: Identifiers have up to 32 characters.
MM_DECIMALS = 5
DEG_DECIMALS = 6  #: As for the other controllers with 32-bit numbers, which resolve 1e-4 mm and 1e-5 deg.
LONGEST_COMMENT = 76
JOINT_PERCENT = 10  #: The speed of the only joint move. Slow, because the arm can come from anywhere.
FLY_MM = 0.5  #: Half of the default least step of seams: blends of neighbours touch and do not overlap.
ROUTINE = "weld_"  #: The name of a routine is this and the name of its seam.
PART, SAFE_POINT = "wp_part", "wp_safe"
SWITCH = ArcSwitch(
    language="PDL2",
    start="arc_start({job})",
    end="arc_end",
    on="$DOUT[{output}] := TRUE",
    off="$DOUT[{output}] := FALSE",
    wait="DELAY {milliseconds}",
    by_output="$DOUT[{output}] switches the arc",
    by_calls="arc_start(job) and arc_end are routines of your program wp_arc",
)


def positions(p: FloatArray, R: FloatArray) -> list[str]:
    """Write poses: p of shape (n, 3), mm, and R of shape (n, 3, 3), in any one frame."""
    turns = texts(zyz_degrees(R, decimals=DEG_DECIMALS), DEG_DECIMALS)
    rows = zip(texts(p, MM_DECIMALS), turns, strict=True)
    return [f"POS({', '.join([*at, *turn])}, '')" for at, turn in rows]


class _Pdl2(WeldWriter):
    format, names, longest_comment, zone_mm = "pdl2", NAMES, LONGEST_COMMENT, FLY_MM
    first = f"{JOINT_PERCENT}"

    def __init__(self, program: WeldProgram) -> None:
        super().__init__(program)
        self.main, self.stems = self.own_names(max(program.label_width + 1, len(ROUTINE)))
        self.T_base_frame = rounded_frame(
            program.T_base_part, mm_decimals=MM_DECIMALS, deg_decimals=DEG_DECIMALS, is_zyz=True
        )

    speed_of = staticmethod(metres_per_second)

    def files(self) -> dict[str, str]:
        points, routines, calls = self._points(), list[str](), list[str]()
        for path in self.program.paths:
            name = f"{ROUTINE}{self.stems[path.seam.name]}"
            routines += [f"ROUTINE {name}", "BEGIN", *self._seam(path), f"END {name}"]
            calls.append(f"  {name}")
        if self.program.safe_point is not None:
            first = self.post.air_move(SAFE_POINT, speed=self.first, joint=True)
            calls = [*first, *calls, *self.air_moves([SAFE_POINT])]
        calls = self.run(calls)
        lines = [
            f"PROGRAM {self.main} HOLD",
            *self.post.header(self._about()),
            "VAR",
            *(f"  {name} : POSITION" for name in points),
            *self._exported(),
            *routines,
            "BEGIN",
            *(f"  {name} := {value}" for name, value in points.items()),
            f"  $UFRAME := {PART}",
            "  $SPD_OPT := SPD_LIN",
            "  $TERM_TYPE := FINE",
            "  $FLY_TYPE := FLY_CART",
            f"  $FLY_DIST := {FLY_MM:g}",
            *calls,
            *self.post.footer(),
            f"END {self.main}",
            "",
        ]
        return {f"{self.main}.pdl": "\r\n".join(lines)}

    def _exported(self) -> list[str]:
        """Declare the routines of the user."""
        if self.program.arc is None or self.program.arc.output is not None:
            return []
        return ["ROUTINE arc_start(job : INTEGER) EXPORTED FROM wp_arc", "ROUTINE arc_end EXPORTED FROM wp_arc"]

    def _points(self) -> dict[str, str]:
        """Return the positions by their names: the frame first."""
        found = {PART: positions(self.T_base_frame.t_mm[None], self.T_base_frame.R[None])[0]}
        for poses in self.program.groups:
            labels = [SAFE_POINT] if isinstance(poses, SafePoint) else self.labels(poses)
            found |= dict(zip(labels, positions(*poses.poses_in(self.T_base_frame)), strict=True))
        return found

    def _about(self) -> list[str]:
        program = self.program
        text = [
            f"positions are relative to {PART}, {part_frame(program)}; mm; R = Rz(e1) Ry(e2) Rz(e3), deg",
            f"written with {MM_DECIMALS} and {DEG_DECIMALS} decimals: within 0.00001 mm and 0.000001 deg",
            "the configuration is not known: the arm keeps the one it comes with",
            f"set $BASE and $TOOL before this program; {SWITCH.in_words(program.arc)}",
        ]
        return self.about(text)

    def _seam(self, path: WeldPath) -> list[str]:
        head = self.comments([path.seam.name, describe_path(path)], mark="  -- ")
        return [*head, *self.seam(path, self.labels(path), SWITCH.around(path, self.program.arc))]

    def weld_moves(self, path: WeldPath, along: Sequence[str]) -> list[str]:
        speed = f"  $LIN_SPD := {metres_per_second(self.program.weld_speed_mm_s(path))}"
        return [speed, *super().weld_moves(path, along)]

    def weld_move(self, path: WeldPath, via: str, to: str, *, stops: bool, is_last: bool) -> list[str]:
        how = f"CIRCULAR TO {to} VIA {via}" if via else f"LINEAR TO {to}"
        return [f"  MOVE {how}" if stops else f"  MOVEFLY {how} ADVANCE"]


write_pdl2 = _Pdl2.written
