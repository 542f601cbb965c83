"""Law: a limit is the number that is said, and the number itself lies on the side that is said.

Each row holds a judgement of one number, a comparison and the limit. The judgement is asked just below the limit, at
the limit and just above it. The limits are repeated here: parts that lie beside a limit are rare, and without this
table nothing else notices that a limit moved.
"""

import math
from types import SimpleNamespace as Some
from typing import Any

import numpy as np
import pytest

from tests.borders import check_border, refuses
from wpcal.calibrate.errors.prediction import Sigma, SigmaSource, TeachingError
from wpcal.calibrate.errors.robot_field import believed_freedom
from wpcal.calibrate.result import CalibrationResult
from wpcal.calibrate.solve.free_turns import on_line
from wpcal.calibrate.trust.diagnose import _is_explained, is_coplanar, require_plausible_units
from wpcal.calibrate.trust.held_motions import NamedAxis, _motion
from wpcal.calibrate.trust.left_out import Contradiction
from wpcal.calibrate.trust.residuals import ResidualEvidence
from wpcal.core.arrays import as_points
from wpcal.core.cells import column_name, number_in_cell
from wpcal.core.errors import whole_text
from wpcal.core.pairs import PointPairs
from wpcal.core.record_check import _check_unknown
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed, shown
from wpcal.robot.identify.error_summary import judge as judge_arm
from wpcal.robot.links.reading import Address, numbers, setting_name
from wpcal.robot.moves.interpolation import Moves
from wpcal.robot.tool_point import ToolPoint
from wpcal.robot.torch.attitude import TorchSettings
from wpcal.seam.find.play import is_play
from wpcal.seam.judge.held_fast import _RoundFace, _shoulders
from wpcal.seam.judge.leans import _is_small
from wpcal.seam.judge.rolling import _is_between
from wpcal.seam.member.clamped import Clamp, _is_on_axis_of, _meeting
from wpcal.seam.member.fasteners import _is_ring, _share_axis, _Turned
from wpcal.seam.member.heavy_bars import Bar
from wpcal.seam.options import Play
from wpcal.seam.seam import JointType, WeldType
from wpcal.weld.groove import Groove, _Layer
from wpcal.weld.passes import place_beads
from wpcal.weld.place import SeamPlace
from wpcal.weld.section import Section, section_of
from wpcal.weld.values import Stitch, WeldKind, WeldValues, stretches

X, Y, Z = np.eye(3)
DEG = math.pi / 180.0


def evidence(squares: float, chance: float = 1.0, freedom: int = 3) -> ResidualEvidence:
    return ResidualEvidence(squares, chance, freedom, 4, ())


def turn(omega: float, *, v: Any = (0.0, 0.0, 0.0), at: Any = (0.0, 0.0, 0.0), lean: float = 0.0) -> str:
    """Say a turn about an axis through `at`, near that of the hole H; the length is 100 mm."""
    axis = np.array([math.sin(lean), 0.0, math.cos(lean)])
    return _motion(np.concatenate([omega * axis, v]), np.array(at), 100.0, [NamedAxis("H", np.zeros(3), Z)])


def in_units(factor: float) -> None:
    p = 100.0 * np.eye(3)
    require_plausible_units(PointPairs(("A", "B", "C"), p, factor * p))


def calibrated(gap_mm: float) -> bool:
    return CalibrationResult.certified.fget(Some(touches=None, gap_mm=gap_mm))  # type: ignore[attr-defined]


FITS: dict[str, tuple[Any, str, float]] = {
    "residuals contradict a stated error by chance": (lambda p: evidence(1.0, p).contradicts_stated, "<", 0.01),
    "residuals of a hundredth say nothing": (lambda mm: evidence(4 * mm**2, 0.0).contradicts_stated, ">", 0.01),
    "residuals that a sigma explains": (lambda mm2: evidence(mm2).contradicts(0.5), ">~", 0.25 * 11.344866730144371),
    "degrees of freedom that can contradict": (lambda n: evidence(1e9, freedom=n).contradicts(0.5), ">=", 1),
    "a set is named": (lambda p: Contradiction(((2,),), (p,), 1, remains=False).named, ">=", 0.55),
    "a smaller set is not named": (lambda n: Contradiction(((2, 3),), (0.9,), n, remains=False).named, "<=", 2),
    "a fit is proven": (calibrated, "<=", 1e-6),
    "a stated error that a controller shows": (
        lambda mm: Sigma.stated(mm).source is SigmaSource.STATED, ">=", 0.01 / math.sqrt(12.0)
    ),
    "the least stated error": (refuses(lambda mm: TeachingError(sigma_mm=mm)), "<", 1e-6),
    "firm freedom": (lambda x: np.isinf(believed_freedom(np.array(1.0), np.array(2.0 / (x - 4.0)))), ">~", 1000.0),
    "coplanar points": (lambda z: is_coplanar(np.array([[9, 5, 0], [-9, 5, 0], [9, -5, 0], [-9, -5, 0], [0, 0, z],
                                                        [0, 0, -z]])), "<=", 0.02 * 10.0 / math.sqrt(2.0)),
    "points on one line": (lambda y: on_line(np.array([X, -X, y * Y, -y * Y]), np.full(4, 0.25)), "<=", 1e-6),
    "points in metres": (refuses(in_units), "<=~", 1030.0),
    "points in inches": (refuses(in_units), ">=~", 25.4 * 0.97),
    "a contradiction that a swap explains": (
        lambda mm2: _is_explained(mm2, 0.0, freedom=6, tests=4, sigma_mm=0.1), ">~", 0.01 * 20.24940205149007
    ),
    "a swap that the stated error allows": (
        lambda mm2: _is_explained(9.0, mm2, freedom=6, tests=4, sigma_mm=0.1), "<=~", 0.01 * 20.24940205149007
    ),
    "a swap says nothing of a hundredth": (
        lambda mm2: _is_explained(mm2, 0.0, freedom=6, tests=4, sigma_mm=None), ">", 1e-4
    ),
    "a part slides": (lambda w: "slides" in turn(w, v=(1.0, 0.0, 0.0)), "<=", 1e-6),
    "a turn is a screw": (lambda mm: "screws" in turn(100.0, v=(0.0, 0.0, mm)), ">", 0.1),
    "a turn has the axis of a hole": (lambda mm: "of H" in turn(100.0, at=(mm, 0.0, 0.0)), "<=", 0.1),
    "an axis leans": (lambda a: "of H" in turn(100.0, lean=a), "<=", math.acos(1.0 - 1e-6)),
}  # fmt: skip
"""Fits and what they are worth."""


def arm_errors(mm: float = 1.0, n: int = 7, better: float = 9.0) -> Any:
    left = np.full(n, mm)[:, None] * X
    return judge_arm(left + np.arange(1.0, n + 1)[:, None] * better * X, left)


def place(length: float, middle: float = 50.0) -> SeamPlace:
    return SeamPlace((0.0, 0.0, 0.0), (middle, 0.0, 0.0), length)


def fillet(deg: float) -> Section | None:
    return section_of(WeldValues(weld=WeldKind.FILLET, leg_mm=5.0), joint=JointType.TEE, weld=WeldType.FILLET,
                      normals_rad=math.pi - deg * DEG)  # fmt: skip


def butt(gap: float = 0.0, depth: float = 8.0, deg: float = 0.0, angle: float = 60.0) -> Section | None:
    values = WeldValues(
        weld=WeldKind.SINGLE_V, depth_mm=depth, root_gap_mm=gap, root_face_mm=2.0, groove_angle_deg=angle
    )
    return section_of(values, joint=JointType.BUTT, weld=WeldType.GROOVE, normals_rad=deg * DEG)


def groove(depth: float) -> Groove:
    return Groove(WeldKind.SINGLE_V, 60.0, 0.5, 1.0, 1.0, depth, 8.0, 0.0, 0.0, 0.0)


def sides(left: float, right: float) -> int:
    return _Layer(0.0, 1.0, (0.0, -math.tan(left * DEG)), (0.0, math.tan(right * DEG))).way


def arc(deg: float) -> bool:
    """Tell whether an arc of radius 100 mm is sound."""
    p = [[100.0 * math.cos(a), 100.0 * math.sin(a), 0.0] for a in (0.0, deg * DEG / 2, deg * DEG)]
    start, via, end = (np.array([one]) for one in p)
    return bool(Moves.between(start, np.eye(3)[None], end, np.zeros((1, 3)), via).is_sound[0])


WELDS: dict[str, tuple[Any, str, float]] = {
    "beads of a weld": (refuses(lambda n: place_beads(Section(5.0, 1.0), n)), ">", 200),
    "one bead at least": (refuses(lambda n: place_beads(Section(5.0, 1.0), n)), "<", 1),
    "stretches of a stitch": (refuses(lambda n: stretches(Stitch(0.1, 1.0), n - 0.9)), ">", 10_000),
    "a pitch is no shorter than its stretch": (refuses(lambda mm: stretches(Stitch(20.0, mm), 90.0)), "<", 20.0),
    "a stretch needs room": (refuses(lambda mm: stretches(Stitch(20.0, 30.0, mm), 90.0)), ">", 70.0),
    "a seam shorter than one stretch is welded whole": (lambda mm: len(stretches(Stitch(20.0, 30.0), mm)) == 1 and
                                                        stretches(Stitch(20.0, 30.0), mm)[0] == (0.0, mm), "<=", 20.0),
    "a straight seam": (lambda mm: place(100.0, mm).is_straight, "<=~", 50.1),
    "a seam that is too short to be straight": (lambda mm: place(100.0, mm).is_straight, ">=~", 49.9),
    "one place by length": (lambda mm: place(mm).is_same(place(100.0)), "<=", 100.1),
    "one place by middle": (lambda mm: place(100.0, mm).is_same(place(100.0)), "<=~", 50.1),
    "a seam that moved": (lambda mm: place(100.0, mm).moved_mm(place(100.0)) is not None, "<=", 60.0),
    "a short seam that moved": (lambda mm: place(10.0, mm).moved_mm(place(10.0)) is not None, "<=", 52.0),
    "a fillet is no slit": (fillet, ">=", 20.0),
    "a fillet is no flat": (fillet, "<=", 160.0),
    "plates of a butt joint are in one plane": (lambda deg: butt(deg=deg), "<", 20.0),
    "a wire gets through a root gap": (lambda mm: butt(mm).least_aim_mm == 0.0, ">", 1.2),
    "a groove has a depth": (lambda mm: "depth_mm" in groove(mm).values(), ">", 0.02),
    "a side that leans": (lambda deg: sides(deg, 0.0) == 1, ">=", 2.0),
    "a groove that becomes narrower": (lambda deg: sides(-deg, 1.9) == -1, ">=", 2.0),
    "sides that lean the same way": (lambda deg: sides(9.0, -deg) == 2, ">=", 2.0),
    "too few test poses": (lambda n: any("too few" in one for one in arm_errors(n=n).reasons), "<", 7),
    "too much is left": (lambda mm: any("are left" in one for one in arm_errors(mm).reasons), ">", 5.0),
    "a tool centre point": (lambda mm: ToolPoint(X, X, np.eye(3), np.full((4, 1), mm) * X, 6).refusal, ">", 10.0),
    "an arc is long enough": (arc, ">=", 4.0),
    "an arc is short enough": (arc, "<=", 200.0),
    "a work angle": (refuses(lambda deg: TorchSettings(work_rad=deg * DEG)), ">", 60.0),
    "a travel angle": (refuses(lambda deg: TorchSettings(travel_rad=deg * DEG)), ">", 45.0),
    "a turn about the wire": (refuses(lambda deg: TorchSettings(spin_range_rad=deg * DEG)), ">", 180.0),
    "a port": (refuses(lambda n: Address.parse(f"a:{n}")), ">=", 65536),
    "port zero": (lambda n: not refuses(Address.parse)(f"a:{n:02d}") if n >= 0 else False, ">", 0),
    "numbers that a controller answers": (refuses(lambda n: numbers([1.0] * n)), ">", 12),
    "a name that a controller answers": (refuses(lambda n: setting_name("a" * n)), ">", 64),
}  # fmt: skip
"""Welds, grooves, moves, and what a controller answers."""


def turned(**known: float) -> _Turned:
    sizes = {"shank": 0.0, "bore": 5.0, "widest": 17.5, "low": 0.0, "high": 15.0, "head": 0.0}
    return _Turned(np.zeros(3), Z, **{**sizes, **known})


def on_axis(off: float = 0.0, lean: float = 0.0) -> bool:
    frame = np.array([[[off, 0.0, 3.0], X, Y, [math.sin(lean), 0.0, math.cos(lean)]]])
    return bool(_share_axis(Some(face_frame=frame), np.array([0]), np.zeros(3), Z)[0])


def clamp(off: float = 0.0, lean: float = 0.0) -> Clamp:
    return Clamp((0, 1), np.array([off, 0.0, 5.0]), np.array([math.sin(lean), 0.0, math.cos(lean)]), -2.0, 3.0, 0, 1, 0)


def at_heights(*heights: float) -> np.ndarray:
    return np.array([[7.0, 1.0, 5.0 + one] for one in heights])


def bar(thick: float = 40.0, wide: float = 50.0, long: float = 900.0, across: float = 50.0) -> Bar:
    return Bar(thick, wide, long, across)


def holes(low: float) -> Any:
    return Some(low=np.array([0.0, low]), high=np.array([10.0, low + 5.0]))


PLAY = (Play(0.4, 0.5, 0.6, 3),)
SEAT = _RoundFace(True, 10.0, 20.0, 15.0, 15.0)


def shoulder(mm: float, end: float = 9.0) -> bool:
    beside = [_RoundFace(True, 0.0, end, 0.0, mm), _RoundFace(True, 21.0, 25.0, 0.0, 40.0)]
    return _shoulders(SEAT, beside, 1)


MEMBERS: dict[str, tuple[Any, str, float]] = {
    "a ring of the largest nut": (lambda mm: _is_ring(turned(bore=mm, widest=30.0)), "<=", 26.0),
    "a ring is low": (lambda mm: _is_ring(turned(high=mm)), "<=", 15.0),
    "a ring is narrow": (lambda mm: _is_ring(turned(widest=mm)), "<=", 17.5),
    "a ring has a bore": (lambda mm: _is_ring(turned(bore=mm, high=0.0, widest=0.0)), ">", 0.0),
    "faces on one axis": (on_axis, "<=", 0.2),
    "faces along one axis": (lambda sine: on_axis(lean=math.asin(sine)), "<=", 2e-3),
    "bolts on one axis": (lambda mm: _is_on_axis_of(clamp(mm), clamp()), "<=", 0.4),
    "bolts along one axis": (lambda sine: _is_on_axis_of(clamp(lean=math.asin(sine)), clamp()), "<=", 2e-3),
    "most of a seam in a plane": (lambda n: clamp().holds(at_heights(*[0] * n, *[9] * (100 - n)), 1.0), ">=", 90),
    "a seam beside a plane": (lambda mm: clamp().holds(at_heights(0.0, 0.0, 0.0, mm), 1.0), "<=", 1.0),
    "a seam above a clamp": (lambda mm: clamp().holds(at_heights(mm, mm, mm), 1.0), "<=", 4.0),
    "a seam below a clamp": (lambda mm: clamp().holds(at_heights(mm, mm, mm), 1.0), ">=", -3.0),
    "a hole begins where another ends": (lambda mm: _meeting(holes(mm), 0, 1) == (mm + 10.0) / 2, "<=", 12.0),
    "a hole begins before another ends": (lambda mm: _meeting(holes(mm), 0, 1) == (mm + 10.0) / 2, ">=", 8.0),
    "a heavy bar": (lambda kg: bar(thick=kg / 7.85e-3 / 50.0).is_heavy, ">=", 10.0),
    "a bar is no plate": (lambda mm: bar(wide=mm, long=9e3).is_heavy, "<=", 160.0),
    "a bar is long": (lambda mm: bar(long=mm).is_heavy, ">=", 300.0),
    "a frame of bars": (lambda mm: bar(across=mm).is_frame, ">=", 150.0),
    "a thick slab": (lambda mm: bar(mm, math.inf, 900.0, 900.0).is_slab, ">=", 20.0),
    "a large slab": (lambda mm: bar(30.0, math.inf, mm, 500.0).is_slab, ">=", 500.0),
    "the widest play": (lambda mm: is_play(PLAY, np.array([mm]))[0], "<=", 0.62),
    "the narrowest play": (lambda mm: is_play(PLAY, np.array([mm]))[0], ">=", 0.38),
    "a shoulder is higher": (shoulder, ">", 15.5),
    "a shoulder is beside": (lambda mm: shoulder(40.0, mm), "<=", 15.0),
    "a small lean": (lambda deg: _is_small((0.0, deg)), "<=", 20.0),
    "wheels roll between faces that look at each other": (
        lambda cos: _is_between([(0, X), (1, np.array([cos, math.sqrt(1 - cos**2), 0.0]))]), "<", -0.87
    ),
}  # fmt: skip
"""Members and fasteners."""


def rz(cos_beta: float) -> np.ndarray:
    return rotation_from_zyx(0.3, math.pi / 2 - cos_beta, 0.0)


def deep(levels: int) -> None:
    value: Any = 1.0
    for _ in range(levels):
        value = [value]
    _check_unknown(value, ())


def turned_by(error: float) -> None:
    R = np.eye(3)
    R[0, 1] = error
    RigidTransform(R, np.zeros(3), "a", "b")


CORE: dict[str, tuple[Any, str, float]] = {
    "a long word in a message": (lambda n: "…" in shown("a" * n), ">", 40),
    "a long number in a message": (lambda n: shown(10 ** (n - 1)).startswith("a number"), ">", 40),
    "a long name in a list": (lambda n: "…" in listed(["a" * n]), ">", 40),
    "many names in a list": (lambda n: "more" in listed(["a"] * n), ">", 20),
    "a long message": (lambda n: whole_text("a" * n).endswith("…"), ">", 2000),
    "a heading with a unit": (lambda n: column_name("x" * (n - 5) + " (mm)").endswith("_mm"), "<=", 100),
    "a long number in a cell": (refuses(lambda n: number_in_cell("1".zfill(n), column="x", decimal=".")), ">", 100),
    "a point far away": (refuses(lambda mm: as_points([[0.0, -mm, 0.0]], name="p")), ">", 1e9),
    "a rotation": (refuses(turned_by), ">", 1e-6),
    "levels of a record": (refuses(deep), ">", 64),
    "numbers of a record": (refuses(lambda x: _check_unknown(-x, ())), ">", 1e15),
    "whole numbers of a record": (refuses(lambda n: _check_unknown(-n, ())), ">", 2**64),
}  # fmt: skip
"""Messages, tables and records."""
ROWS = FITS | WELDS | MEMBERS | CORE


@pytest.mark.parametrize("name", ROWS)
def test_a_limit_is_where_it_is_said_to_be(name: str) -> None:
    check_border(*ROWS[name])
