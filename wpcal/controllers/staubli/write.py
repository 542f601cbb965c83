"""Staubli VAL3: an application (``.pjx``, ``.dtx``, ``start.pgx``, ``stop.pgx``) with the part's frame and points.

rx, ry, rz in degrees are rotations about moving axes, ``R = Rx(rx) Ry(ry) Rz(rz)``; lengths in mm. Points are children
of the frame ``fPart``. The configuration is written as *same*: the arm keeps the present one. In a plan it is that of
the joint move before each seam. The tool is not declared: the application does not start until a person declares the
torch. VAL3 has no arc instructions of its own: a digital output of the user (``doArc``) switches the arc, or the user's
programs ``arcStart(nJob)`` and ``arcEnd()``, which are added to the application as the tool is.

References: Staubli, VAL3 Reference Manual (pointRx, jointRx, frame, mdesc; configuration ssame, esame, wsame; dio,
call, delay, waitEndMove).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from wpcal.controllers.language.emit import ArcSwitch, WeldWriter
from wpcal.controllers.language.naming import NameRules, own_name, reserved_words, safe_name, safe_names
from wpcal.controllers.language.post import whole_template
from wpcal.controllers.language.rounding import rounded, texts, zyx_degrees
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import part_frame
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform

NAMES = NameRules("VAL3", 15, reserved_words(__file__))  #: Names of variables have up to 15 characters.
MOST_POINTS = 9999  #: Elements of an array.
MM_DECIMALS = 5
DEG_DECIMALS = 6  #: As for the other controllers with 32-bit numbers, which resolve 1e-4 mm and 1e-5 deg.
BLEND_MM = 0.5  #: Half of the default least step of seams: blends of neighbours touch and do not overlap.
PLANNED_MM_S = 500  #: Limit of the tip in the joint moves of a plan: the joints limit most of them.
JOINT_PERCENT = 10  #: The speed of joint moves. Slow, because the arm can come from anywhere.
MOTION = "m"  #: The name of the motion of a seam with a speed of its own is this and the name of the seam.
JOINTS = "jPlan"  #: The joints that a plan goes to between seams, in one array.
SAFE_POINT = "wpSafe"  #: The point above the part at which the program starts and ends.
SAME = 'shoulder="ssame" elbow="esame" wrist="wsame" fatherId="fPart[0]"'
LONGEST_COMMENT = 100
STAND = "  waitEndMove()"
SWITCH = ArcSwitch(
    language="VAL3",
    start="call arcStart({job})",
    end="call arcEnd()",
    on="doArc=true",
    off="doArc=false",
    wait="delay({seconds})",
    by_output="and the dio doArc, linked to output {output}, which switches the arc",
    by_calls="and the programs arcStart(nJob) and arcEnd()",
)


def write_val3(program: WeldProgram) -> dict[str, str]:
    """Write a VAL3 application: ``NAME.pjx``, ``NAME.dtx``, ``start.pgx``, ``stop.pgx``.

    Raises `InputError` when a seam has too many points, or VAL3 does not allow the tool's name.
    """
    for path in program.paths:
        if len(path) > MOST_POINTS:
            raise InputError(f"VAL3: seam {path.seam.name} has {len(path)} points, an array at most {MOST_POINTS}")
    return _Val3(program).files()


def _filled(template: str, **names: object) -> str:
    return "\n".join([*whole_template("val3", template, names), ""])


def _beside(taken: Sequence[str]) -> NameRules:
    return NameRules(NAMES.language, NAMES.longest, " ".join(taken))


def _motion(speed_mm_s: float, blend: str, *, percent: int = 100, zone_mm: float = BLEND_MM) -> str:
    limits = f'accel="{percent}" vel="{percent}" decel="{percent}" tmax="{speed_mm_s:g}" rmax="100"'
    return f'{limits} blend="{blend}" leave="{zone_mm:g}" reach="{zone_mm:g}"'


def _zone(mm: float) -> str:
    """Return the name of the motion with this zone."""
    return f"mJointZ{mm:g}".replace(".", "_")


def _angles(R: FloatArray) -> FloatArray:
    """Return rx, ry, rz: the transpose of Rx(a) Ry(b) Rz(c) is Rz(-c) Ry(-b) Rx(-a)."""
    return rounded(-zyx_degrees(np.swapaxes(R, -1, -2), decimals=DEG_DECIMALS), DEG_DECIMALS)


def _val3_frame(T: RigidTransform) -> RigidTransform:
    """Return the frame with the written digits: its rounding then does not move the points in the base."""
    a, b, c = np.radians(_angles(T.R))
    return RigidTransform(rotation_from_zyx(-a, -b, -c).T, rounded(T.t_mm, MM_DECIMALS), T.target, T.source)


def _keyed(keys: Sequence[str], row: Sequence[str]) -> str:
    return " ".join(f'{key}="{value}"' for key, value in zip(keys, row, strict=True))


def _coordinates(p: FloatArray, R: FloatArray) -> list[str]:
    rows = zip(texts(p, MM_DECIMALS), texts(_angles(R), DEG_DECIMALS), strict=True)
    return [_keyed(("x", "y", "z", "rx", "ry", "rz"), [*at, *turn]) for at, turn in rows]


Datum = tuple[str, str, tuple[str, ...]]  #: Name, type and values.


class _Val3(WeldWriter):
    format, names, longest_comment, zone_mm = "val3", NAMES, LONGEST_COMMENT, BLEND_MM
    calls_seams = False
    air, first = "mAir", "mJoint"

    def files(self) -> dict[str, str]:
        program, name = self.program, safe_name(self.program.controller.program_name, NAMES)
        self.tool = own_name(program.controller.tool_name, NAMES, what="tool")
        taken = [NAMES.keywords, self.tool.lower(), *(_zone(mm).lower() for mm in self._zones_mm())]
        self.stems = safe_names([path.seam.name for path in program.paths], _beside(taken))
        own = [path.seam.name for path in program.paths if path.run is not None]  # with a speed of their own
        motions = [f"{MOTION}{self.stems[name]}" for name in own]
        taken += [stem.lower() for stem in self.stems.values()]
        self.motions = dict(zip(own, safe_names(motions, _beside(taken)).values(), strict=True))
        self.T_base_frame = _val3_frame(program.T_base_part)
        data = _filled("database", data=self._data())
        code = [line.replace("]]>", "]] >") for line in self._start()]  # what would end the section
        return {
            f"{name}.pjx": _filled("project", name=name),
            f"{name}.dtx": data,
            "start.pgx": _filled("program", name="start", code=code),
            "stop.pgx": _filled("program", name="stop", code=["  resetMotion()"]),
        }

    def _data(self) -> list[Datum]:
        """Return name, type and values of the data."""
        T = self.T_base_frame
        frame = f'{_coordinates(T.t_mm[None], T.R[None])[0]} fatherId="world[0]"'
        data: list[Datum] = [("fPart", "frame", (frame,)), *self._motions()]
        if any(path.moves is None for path in self.program.paths):
            data.append(("nPoint", "num", ()))  # of a loop over all points of a seam
        if self.planned is not None:
            rows = texts(np.degrees(np.concatenate([moves.joints for moves in self.planned.air])), DEG_DECIMALS)
            data.append((JOINTS, "jointRx", tuple(_keyed([f"j{n}" for n in range(1, 7)], row) for row in rows)))
        for poses in self.program.groups:
            name = SAFE_POINT if isinstance(poses, SafePoint) else self.stems[poses.seam.name]
            points = [f"{value} {SAME}" for value in _coordinates(*poses.poses_in(T))]
            data.append((name, "pointRx", tuple(points[self._skipped(poses) :])))
        return data

    def _motions(self) -> Iterator[Datum]:
        """Yield how the robot moves: in the air, by the joints, and along seams."""
        motion = self.program.motion
        values = {
            "mAir": _motion(motion.air_speed_mm_s, "off"),
            "mJoint": self._joint_motion("off"),
            "mWeld": _motion(motion.speed_mm_s, "cartesian"),
            **{_zone(mm): self._joint_motion("joint", mm) for mm in self._zones_mm()},
        }
        own = [path for path in self.program.paths if path.run is not None]
        values |= {self._motion(path): _motion(self.program.weld_speed_mm_s(path), "cartesian") for path in own}
        return ((name, "mdesc", (value,)) for name, value in values.items())

    def _joint_motion(self, blend: str, zone_mm: float = BLEND_MM) -> str:
        if self.planned is None:
            return _motion(self.program.motion.air_speed_mm_s, blend, percent=JOINT_PERCENT)
        return _motion(PLANNED_MM_S, blend, percent=round(self.planned.joint_percent), zone_mm=zone_mm)

    def _zones_mm(self) -> Sequence[float]:
        return () if self.planned is None else self.planned.zones_mm

    def _skipped(self, poses: WeldPath | SafePoint) -> int:
        """Return how many poses are no points: a plan goes to joints before a seam."""
        return 0 if self.planned is None or isinstance(poses, SafePoint) else poses.before

    def _motion(self, path: WeldPath) -> str:
        return "mWeld" if path.run is None else self.motions[path.seam.name]

    def _start(self) -> list[str]:
        program, safe, between = self.program, self.program.safe_point is not None, self.between()
        lines, stand = self.post.header(self._about()), [] if self.planned is None else [STAND]
        lines += self.post.hook("before_run")
        lines += [*self.post.air_move(SAFE_POINT, speed="mJoint", joint=True), STAND] if safe else []
        for (way, _), path in zip(between, program.paths, strict=False):
            skipped, name = self._skipped(path), self.stems[path.seam.name]
            points = [f"{name}[{row - skipped}]" for row in range(len(path))]
            around = SWITCH.around(path, program.arc, [STAND])
            lines += [*way, *stand, *self.seam(path, points, around), STAND]
        lines += [*between[-1][0], *stand, *([*self.air_moves([SAFE_POINT]), STAND] if safe else [])]
        return [*lines, *self.post.hook("after_run"), *self.post.footer()]

    def _about(self) -> list[str]:
        program, planned = self.program, self.planned
        text = [
            *(planned.standing_axes("VAL3") if planned is not None else ()),
            f"points are children of fPart, {part_frame(program)}; mm; R = Rx(rx) Ry(ry) Rz(rz), deg",
            f"written with {MM_DECIMALS} and {DEG_DECIMALS} decimals: within 0.00001 mm and 0.000001 deg",
            "the configuration is not known: the arm keeps the one it comes with (same)"
            if planned is None
            else "the configuration is that of the joint move before each seam: the arm keeps it (same)",
            f"declare the tool {self.tool} in this application; {SWITCH.in_words(program.arc)}",
        ]
        return self.about(text)

    def joint_move(self, number: int) -> list[str]:
        mm, _ = self.zone(number)
        return self.post.joint_move(f"{JOINTS}[{number - 1}]", speed=_zone(mm) if mm else "mJoint")

    def weld_moves(self, path: WeldPath, along: Sequence[str]) -> list[str]:
        if path.moves is not None:
            return super().weld_moves(path, along)
        first, last = (along[row].rpartition("[")[2][:-1] for row in (1, -1))
        move = f"    movel({self.stems[path.seam.name]}[nPoint],{self.tool},{self._motion(path)})"
        return [f"  for nPoint={first} to {last}", move, "  endFor", STAND]

    def weld_move(self, path: WeldPath, via: str, to: str, *, stops: bool, is_last: bool) -> list[str]:
        how = f"{to},{self.tool},{self._motion(path)}"
        return [f"  movec({via},{how})" if via else f"  movel({how})", *([STAND] if stops else [])]
