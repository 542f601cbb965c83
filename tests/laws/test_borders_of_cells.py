"""Law, as in `test_borders`: programs, cells, touches, edits of seams, and the members of solids."""

import math
from pathlib import Path
from types import SimpleNamespace as Some
from typing import Any

import numpy as np
import pytest

from tests.borders import check_border, refuses
from wpcal.calibrate.trust.criteria import Criterion
from wpcal.controllers.audit.off_line import _Run
from wpcal.controllers.audit.programs import speed_faults
from wpcal.controllers.audit.records import _repairs
from wpcal.controllers.fanuc.write import tp_file
from wpcal.controllers.judge import asked as one_robot
from wpcal.controllers.judge import in_step
from wpcal.controllers.judge.swept import is_followed
from wpcal.controllers.language.limits import _refuse_large
from wpcal.controllers.language.naming import NameRules, safe_names
from wpcal.controllers.program.touch_program import _refuse_unsafe
from wpcal.controllers.run.expressions import as_number
from wpcal.controllers.tool_data import _usable
from wpcal.controllers.touchup.poses import _agree, common_motion
from wpcal.controllers.touchup.record import _bodies, _same
from wpcal.controllers.touchup.study import SeamAfter
from wpcal.controllers.yaskawa.arc import _timer
from wpcal.controllers.yaskawa.write import inform_job
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.formats.offset import _g54
from wpcal.planning.cell.shape import Shape
from wpcal.planning.cell.workplace import is_within_turns
from wpcal.planning.plan.recheck import TipMotion
from wpcal.planning.search.problem import PlanningProblem
from wpcal.planning.sequence.smooth import _knots
from wpcal.seam.edit import edit_from_record
from wpcal.seam.find.sides import Sides, _is_along
from wpcal.seam.judge.evidence import _weight
from wpcal.seam.member.member import Decomposition, Member, MemberKind
from wpcal.seam.seam import SeamSource
from wpcal.touch.advice import _require_usable, _table_notes, fills_a_plane
from wpcal.touch.design import _orders
from wpcal.touch.plan.free import keeps_above_floor
from wpcal.touch.plan.options import TouchOptions
from wpcal.touch.plan.patterns import _sides
from wpcal.touch.searches.plan import SearchKind
from wpcal.touch.searches.results import Outcome, fingerprint_of
from wpcal.touch.searches.setup import TouchSetup
from wpcal.touch.touch_results import _outside, _require_postures, _require_same_plan, require_enough

X, Y, Z = np.eye(3)
DEG = math.pi / 180.0


def pose(mm: float = 0.0, rad: float = 0.0, along: Any = X) -> np.ndarray:
    T = np.eye(4)
    T[:3, 3], T[:3, :3] = mm * np.asarray(along), rotation_from_zyx(0.0, 0.0, rad)
    return T


def stop(**known: Any) -> Any:
    """Return one place that was asked for."""
    usual = {"p": np.zeros((2, 3)), "R": np.tile(np.eye(3), (2, 1, 1)), "joints": np.full((2, 6), np.nan)}
    return Some(**{**usual, "external": np.zeros((2, 1)), "home": np.zeros(6), **known})


def motion(**known: Any) -> Any:
    usual = {"joints": None, "goal": None, "start": None, "kind": "L", "via": None, "via_joints": None, "speed_mm_s": 9}
    at = Some(external=(0.0,), blends=False, file="F", speed_mm_s=known.pop("speed", 9.0), line=1)
    return Some(**{**usual, "place": at, "seam": 1, **known})


def welded(mm: float = 0.0, lean: float = 0.0) -> Any:
    wire = np.array([[math.sin(lean), 0.0, math.cos(lean)]])
    return _Run([motion()], Some(name="W1", is_planned=True), np.zeros(1), mm * X[None], wire).fault(is_alone=True)


def faster(mm_s: float) -> list[Any]:
    return list(speed_faults(Some(motions=[motion(speed=mm_s)]), {"F": [8.0, 100.0]}))


def frame_off(error: float, apart: float = 0.0) -> list[Any]:
    R = np.eye(3)
    R[0, 0] += error
    q = [math.sin(math.acos(1.0 - apart)), 0.0, 0.0, 1.0 - apart]
    return list(_repairs({"seams": [{"name": "W1", "frames": [{"R": R.tolist(), "q_xyzw": q}]}]}))


def after(after_mm: float, before_mm: float = 1.0) -> str:
    return SeamAfter("W1", 1, 1.0, before_mm, after_mm).says


def search(stroke: float = 40.0, off: float = 0.0, along: float = 20.0) -> Any:
    return Some(name="T1", stroke_mm=stroke, direction=X, normal_part=-X, start=np.zeros(3),
                planned=along * X + off * Y, R_part_tool=np.eye(3), kind=SearchKind.POST)  # fmt: skip


def moved(n: int) -> Any:
    places = np.array([pose(100.0 * k, along=Y) for k in range(n)])
    return common_motion(places, np.array([pose(7.0)]) @ places)


def tool(mm: float) -> Any:
    return _usable(RigidTransform(np.eye(3), np.array([0.0, -mm, 0.0]), "flange", "tool"), "T", Path("f"))


SAFE = NameRules("KRL", 24)
PROGRAMS: dict[str, tuple[Any, str, float]] = {
    "one place": (lambda mm: one_robot._is_within(-mm * X, np.zeros(3)), "<=", 0.05),
    "one orientation": (lambda x: one_robot._is_within(np.zeros(3), -x * X), "<=", 0.01 * DEG),
    "axes stand where they should": (
        lambda deg: one_robot._has_axes(motion(), stop(external=np.full((2, 1), deg)), 1), "<=", 1e-3
    ),
    "an arm is at home": (lambda deg: one_robot._is_home(motion(joints=-deg * np.ones(6)), stop()), "<=", 1e-3),
    "joints stand": (
        lambda deg: one_robot._stands(motion(joints=np.zeros(6)), motion(joints=np.full(6, deg)), flows=False), "<=",
        1e-3
    ),
    "a place is asked for twice": (lambda mm: one_robot._repeats(stop(p=np.array([0 * X, mm * Y])), 1), "<=", 0.05),
    "joints are asked for twice": (
        lambda deg: one_robot._repeats(stop(joints=np.array([[0.0] * 6, [deg] * 6])), 1), "<=", 1e-3
    ),
    "axes are asked for twice": (lambda deg: one_robot._repeats(stop(external=np.array([[0], [deg]])), 1), "<=", 1e-3),
    "joints that were asked for": (
        lambda deg: one_robot._near_joints(np.full(6, deg), stop(joints=np.zeros((2, 6))), 1) == [1], "<=", 1e-3
    ),
    "a pose that was asked for": (lambda mm: one_robot._near(pose(mm), stop(), 1) == [1], "<=", 0.05),
    "a turn that was asked for": (lambda deg: one_robot._near(pose(0.0, deg * DEG), stop(), 0) == [0, 1], "<=~", 0.01),
    "two robots come to one place": (lambda mm: in_step._is_near(pose(mm), pose()), "<=", in_step.SAME_MM),
    "a robot moves": (lambda rad: in_step._moves(np.array([[0.0, 0], [0, rad]])), ">", in_step.STILL_RAD),
    "a robot is between two states": (
        lambda rad: in_step._is_between(np.array([0.5, rad]), np.zeros(2), X[:2]), "<=", in_step.STILL_RAD
    ),
    "a way that is followed": (lambda mm: is_followed(motion(start=pose(), goal=pose(mm))), "<=", 20_000.0),
    "a wire off its seam": (welded, ">", 1.0),
    "a wire that leans from its plan": (lambda deg: welded(lean=deg * DEG), ">~", 5.0),
    "a speed above its header": (faster, ">", 8.08),
    "a frame that lost digits": (lambda x: len(frame_off(math.sqrt(1.0 + x) - 1.0)) == 1, ">~", 1e-6),
    "a frame that lost too many": (lambda x: len(frame_off(math.sqrt(1.0 + x) - 1.0)) == 0, ">~", 2e-3),
    "a quaternion that lost digits": (lambda x: len(frame_off(0.0, x)) == 1, ">~", 1e-6),
    "a quaternion that lost too many": (lambda x: len(frame_off(0.0, x)) == 0, ">~", 2e-3),
    "lines of a TP program": (refuses(lambda n: tp_file("A", ["x"] * n, [])), ">", 9999),
    "lines of a job": (refuses(lambda n: inform_job("A", [], ["x"] * n)), ">", 9997),
    "room for a name": (refuses(lambda n: safe_names(["W1"], SAFE, room=n)), ">", 22),
    "what a template multiplies": (refuses(lambda n: _refuse_large(["a" * 1000, -n])), ">", 20_000),
    "a part that stands level": (lambda deg: "NOT LEVEL" in _g54([], {"X": 1.0}, (deg, 0.0, 5.0)), ">", 1e-3),
    "digits of a number": (refuses(lambda n: as_number("1" * n)), ">", 40),
    "a stroke of a search": (refuses(lambda mm: _refuse_unsafe(search(mm))), ">", 300.0),
    "a contact beside its search": (refuses(lambda mm: _refuse_unsafe(search(off=mm))), ">", 1.0),
    "a contact at the end of its search": (refuses(lambda mm: _refuse_unsafe(search(along=mm))), ">=", 40.0),
    "a contact at the start of its search": (refuses(lambda mm: _refuse_unsafe(search(along=mm))), "<=", 0.0),
    "a tool": (refuses(tool), ">", 10_000.0),
    "a place of two programs": (lambda mm: _agree(pose(mm)[None], pose()[None])[0], "<=", 0.03),
    "a turn of two programs": (lambda x: _agree(pose(0.0, math.asin(x))[None], pose()[None])[0], "<=~", 5e-4),
    "poses that show a motion": (moved, ">=", 4),
    "parts that show a body": (lambda n: list(_bodies([{"bodies": ["B"]}] * n)), ">=", 3),
    "most parts show a body": (lambda n: list(_bodies([{"bodies": ["B"] * (k < n)} for k in range(10)])), ">=", 8),
    "a correction worth a rule": (lambda mm: _same([[mm, 0.0]] * 4, 4), ">=", 0.2),
    "a correction of most parts": (lambda n: _same([[1.0, 0.0]] * n, 10), ">=", 8),
    "a sure correction": (lambda x: _same([[x - 1, 0], [x, 0], [x + 1, 0.0]], 3), ">=~", math.sqrt(3.0)),
    "less sure than before": (lambda mm: after(mm).startswith("less sure"), ">", 1.0 / 0.95),
    "no surer than before": (lambda mm: after(mm).startswith(("less", "no surer")), ">", 0.95),
    "better than before": (lambda mm: after(mm) == "better", "<=", 0.8),
    "a timer": (_timer, ">=", 0.01),
}  # fmt: skip
"""What programs do, and what is told of them."""


def tip(error: float = 0.0, slow: float = 8.0, fast: float = 8.0) -> bool:
    return TipMotion(error, 0.0, slow, fast).is_coarse(8.0)


def turns_of_weld(deg: float) -> int:
    task = Some(R=np.array([np.eye(3), pose(0.0, deg * DEG)[:3, :3]]), rungs=lambda: [0, 1, 2])
    way = type("Way", (), {"task": task, "__len__": lambda self: 2})()
    return len(_knots(way))


def joint(rad: float) -> Any:
    arm = Some(limits=np.array([[-1.0] * 6, [1.0] * 6]))
    return is_within_turns(arm, np.full((1, 6), rad + 4.0 * math.pi))[0]


def results(mm: float = 0.0, rad: float = 0.0) -> Any:
    T = RigidTransform(pose(0.0, rad)[:3, :3], mm * X, "base", "part")
    return Some(path="f", results=[Some(outcome=Outcome.FOUND, name="T1")], fingerprint="a", count=1, T_base_part=T)


PLAN = Some(
    fingerprint="a", searches=[Some(name="T1")], T_base_part=RigidTransform.identity(target="base", source="part")
)


def used(n: int) -> None:
    plan = Some(searches=[Some(name=f"T{k}", target="edge" if k == 0 else "face") for k in range(9)])
    left = Some(taught=Some(names=[f"T{k}" for k in range(n)], path="f"), left_out=(("T8", Outcome.MISSED),))
    require_enough(plan, left)


def turned(deg: float) -> None:
    stored = Some(R=pose(0.0, deg * DEG)[:3, :3])
    _require_postures(PLAN, [(search(), stored)], "f")


def strokes(mm: float) -> bool:
    at = Some(before_mm=np.zeros(1), at=lambda _: np.array([[0.0, 0.0, mm]]))
    return keeps_above_floor(at, Z, 5.0, np.array([9.0]))[0]


def sides(n: int) -> list[Any]:
    normals = np.array([[math.cos(k), math.sin(k), 0.0] for k in np.linspace(0.0, 5.0, n)])
    return _sides(np.arange(3.0 * n).reshape(n, 3), normals)


def advised(points: int = 4, sigma: float = 0.3, have: int = 0) -> None:
    _require_usable(points, sigma, [Some()] * have, Criterion.MINIMAX)


def low(mm: float) -> list[str]:
    return _table_notes(Some(features=[Some(name="P", p_mm=(0.0, 0.0, mm))]), 5.0)


TOUCHES: dict[str, tuple[Any, str, float]] = {
    "a tip off the line": (tip, ">", 0.25),
    "a tip that is too slow": (lambda mm_s: tip(slow=mm_s), "<~", 8.0 * 0.85),
    "a tip that is too fast": (lambda mm_s: tip(fast=mm_s), ">", 8.0 * 1.15),
    "a path keeps its limits": (
        lambda x: PlanningProblem.is_allowed(Some(excesses=lambda _: {"a": 0.0, "b": x}), None), "<=", 1e-9
    ),
    "a link of an arm": (refuses(lambda n: Shape("a", np.zeros((1, 3)), np.zeros((1, 3)), np.ones(1), link=n)), ">", 6),
    "a seam that turns": (lambda deg: turns_of_weld(deg) == 3, ">=~", 0.1),
    "a joint within its turns": (joint, "<=", 1.0),
    "a joint within its other turns": (joint, ">=", -1.0),
    "points on one line": (
        lambda y: fills_a_plane(np.array([X, -X, y * Y, -y * Y])), ">~", 1e-3
    ),
    "points of an advice": (refuses(advised), "<", 3),
    "points that are there": (refuses(lambda n: advised(have=n)), ">=", 4),
    "the least error of an advice": (refuses(lambda mm: advised(sigma=mm)), "<", 1e-6),
    "a point on the table": (low, "<", 5.01),
    "points in every order": (lambda n: len(list(_orders(n))) == math.factorial(n), "<=", 6),
    "sides of a part": (lambda n: len(sides(n)) == n, "<=", 6),
    "touches of a plan": (refuses(lambda n: TouchOptions(touches=n)), ">", 60),
    "touches that hold a part": (refuses(lambda n: TouchOptions(touches=n)), "<", 6),
    "half a fingerprint": (refuses(lambda n: fingerprint_of(n, 0)), ">=", 65536),
    "the other half": (refuses(lambda n: fingerprint_of(0, n)), ">=", 65536),
    "a fingerprint is positive": (refuses(lambda n: fingerprint_of(n, n)), "<", 0),
    "a speed of a search": (refuses(lambda mm_s: TouchSetup(search_speed_mm_s=mm_s)), ">=", 100.0),
    "a speed in the air": (refuses(lambda mm_s: TouchSetup(air_speed_mm_s=mm_s)), ">=", 2000.0),
    "a wait": (refuses(lambda s: TouchSetup(hold_s=s)), ">=", 60.0),
    "a repeatability": (refuses(lambda mm: TouchSetup(repeatability_mm=mm)), ">=", 100.0),
    "searches that are left": (refuses(used), "<", 5),
    "a frame that was changed": (refuses(lambda mm: _require_same_plan(PLAN, results(mm))), ">", 0.05),
    "a frame that was turned": (refuses(lambda deg: _require_same_plan(PLAN, results(0.0, deg * DEG))), ">~", 0.05),
    "a tool that was turned": (refuses(turned), ">~", 2.0),
    "a contact beside its stroke": (lambda mm: _outside(search(), np.array([20.0, mm, 0.0])), ">", 1.5),
    "a contact before its stroke": (lambda mm: _outside(search(), mm * X), "<", -2.0),
    "a contact behind its stroke": (lambda mm: _outside(search(), mm * X), ">", 42.0),
    "a search above the floor": (strokes, ">=", 9.0),
}  # fmt: skip
"""Plans and touches."""


def member(
    kind: MemberKind, thick: float = 10.0, long: float = 500.0, section: Any = (10.0, 100.0), **more: Any
) -> Member:
    return Member(kind, frozenset(), Z, np.array(section), thick, long, **more)


def of(*members: Member, share: float = 1.0) -> Decomposition:
    return Decomposition(members, share, 1.0)


PLATE, BAR, TUBE, BOX = MemberKind.PLATE, MemberKind.BAR, MemberKind.TUBE, MemberKind.BOX


def corner(mm: float, lean: float = 0.0) -> bool:
    profile = member(MemberKind.PROFILE, roots=frozenset({(1, 2)}))
    return of(profile).around((2, 1), np.array([math.sin(lean), 0.0, math.cos(lean)]), mm, is_sharp=True) is profile


def edit(**known: Any) -> Any:
    return edit_from_record(known, "W1", path="f")


MEMBERS: dict[str, tuple[Any, str, float]] = {
    "a plate drawn solid": (lambda mm: member(PLATE, mm).is_drawn_solid, ">=", 150.0),
    "a box thicker than bars": (lambda mm: member(BOX, mm).is_thicker_than_bars, ">=", 250.0),
    "a thick board": (lambda mm: member(BAR, section=(mm, 900.0)).is_slab, ">=", 20.0),
    "a large board": (lambda mm: member(BAR, 20.0, mm, (20.0, 500.0)).is_slab, ">=", 500.0),
    "a beam": (lambda mm: member(BAR, mm, 20.0, (mm, mm)).is_beam, ">=", math.sqrt(10.0 / 7.85e-3)),
    "a stout bar": (lambda mm: member(BAR, mm, 400.0).is_stout, ">", 60.0),
    "a plate too thick to be moulded": (lambda mm: member(PLATE, mm).is_slender, ">", 3.0),
    "a slender plate": (lambda mm: member(PLATE, mm, 400.0).is_slender, "<=", 24.0),
    "a slender wall": (lambda mm: member(TUBE, mm, 400.0, (50.0, 50.0)).is_slender, "<=", 10.0),
    "one member explains a solid": (lambda x: of(member(BAR), share=x).is_one, ">=", 0.9),
    "one wall": (lambda mm: of(member(PLATE, mm), member(PLATE)).is_of_one_wall, ">=", 9.0),
    "a wall that an arc burns through": (lambda mm: of(member(PLATE, mm, section=(mm, 9.0))).is_moulded, "<", 1.2),
    "a corner as long as its member": (corner, "<=", 600.0),
    "a corner along its member": (lambda cos: corner(9.0, math.acos(cos)), ">~", 0.999),
    "an edge along a face": (lambda x: _is_along(np.array([[x, 0.0, 0.0]]), X[None])[0], "<", 0.5),
    "wall and base face the same way": (
        lambda cos: Sides.side_by_side.fget(Some(n_wall=X[None], n_base=np.array([[cos, 0, 0.0]])))[0], ">", 0.7
    ),
    "a sure contact": (lambda x: _weight(CONTACT, (), Some(value=x))["accepted"], "<=", 0.95),
    "the name of an edit": (refuses(lambda n: edit(name="a" * n)), ">", 200),
    "stretches of an edit": (refuses(lambda n: edit(join=[{"candidate": CANDIDATE}] * n)), ">", 100),
    "a length of an edit": (refuses(lambda mm: edit(range_mm=[0.0, mm])), ">", 1e9),
}  # fmt: skip
CONTACT = Some(source=SeamSource.CONTACT, inside=(), blocked_by=())
CANDIDATE = {"name": "W1", "start_part_mm": [0, 0, 0], "middle_part_mm": [1, 0, 0], "length_mm": 2.0}
ROWS = PROGRAMS | TOUCHES | MEMBERS


@pytest.mark.parametrize("name", ROWS)
def test_a_limit_is_where_it_is_said_to_be(name: str) -> None:
    check_border(*ROWS[name])
