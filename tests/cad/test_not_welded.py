"""Solids without a telling name that nobody welds, and beside each of them a like part that is welded."""

from collections.abc import Callable
from typing import Any

import pytest
from build123d import Align, Box, Cylinder, Pos, Rot, Torus, chamfer

from cad.kernel.to_brep import to_brep
from wpcal.brep.trim import TrimmedFaces
from wpcal.seam import Seam, SeamOptions, detect_seams
from wpcal.seam.limits import Level
from wpcal.seam.member.note import take_members
from wpcal.seam.options import Judging
from wpcal.seam.rules import Rule

LOW = (Align.CENTER, Align.CENTER, Align.MIN)
Solids = dict[str, Any]
Made = Callable[[], Solids]


def tube(outer: float, inner: float, low: float, high: float) -> Any:
    return Pos(0, 0, low) * (Cylinder(outer, high - low, align=LOW) - Cylinder(inner, high - low, align=LOW))


def table(leg: Any) -> Solids:
    """Return a table of 1200 x 700 mm: a top of 30 mm on four legs, and a bar between each two of them."""
    solids: Solids = {"S1": Pos(0, 0, 700) * Box(1200, 700, 30, align=LOW)}
    for x in (-1, 1):
        for y in (-1, 1):
            solids[f"L{x}{y}"] = Pos(500 * x, 250 * y, 0) * leg
        solids[f"B{x}"] = Pos(500 * x, 0, 600) * Box(40, 430, 80, align=LOW)
    return solids


def framed(*, groove: bool) -> Solids:
    """Return a frame of flat bar, one body, and a pane in it."""
    frame = Box(500, 400, 30) - Box(420, 320, 40)
    pane = Box(432, 332, 6) if groove else Box(420, 320, 6)
    return {"S1": frame - pane, "S2": pane}


def wheel(tread: Any) -> Solids:
    """Return a wheel in a fork's side plate, on an axle."""
    body = Cylinder(100, 40) + tread - Cylinder(12, 60)
    return {"S1": body, "S2": Cylinder(12, 160)}


def fork(x: float) -> Any:
    """Return a casting: a foot with a round body and a boss."""
    body = Box(120, 60, 24, align=LOW) + Pos(0, 0, 50) * Rot(90, 0, 0) * Cylinder(40, 60)
    body += Pos(0, 0, 70) * Cylinder(15, 35, align=LOW)
    return Pos(x, 0, 0) * (body - Pos(0, 0, 50) * Rot(90, 0, 0) * Cylinder(24, 70))


def castings() -> Solids:
    """Return a plate on which three castings stand, and a small bar."""
    plate = Box(600, 200, 10, align=(Align.CENTER, Align.CENTER, Align.MAX))
    forks = {f"C{k}": fork(180 * k) for k in (-1, 0, 1)}
    return {"P": plate, **forks, "B": Pos(275, 60, 0) * Box(20, 20, 20, align=LOW)}


BASE = Box(240, 120, 10, align=(Align.CENTER, Align.CENTER, Align.MAX))
HUB = ((60, 20, 0, 12), (20, 10, -20, 32))
BEARING = ((60, 40, 0, 30), (40, 30, 0.5, 29.5), (30, 20, 0, 30))


def rings(*sizes: tuple[float, float, float, float]) -> Solids:
    return {f"S{k}": tube(*size) for k, size in enumerate(sizes, 1)}


def collared(*, closed: bool) -> Solids:
    """Return a cup or a tube in a collar."""
    cup = Cylinder(56, 190, align=LOW) - Pos(0, 0, 2) * Cylinder(54, 190, align=LOW)
    return {"S1": cup if closed else tube(56, 54, 0, 190), "S2": tube(75, 56, 90, 100)}


def hinge() -> Solids:
    """Return two leaves with bored knuckles in turn, on axes 5 µm apart."""
    leaves = [Pos(-33 * way, 0, 0) * Box(40, 18, 90, align=LOW) for way in (1, -1)]
    for k, x in enumerate((0.395, 0.4, 0.405)):
        arm = Pos(x - 10 if k % 2 == 0 else x + 10, 0, 30 * k) * Box(20, 18, 30, align=LOW)
        leaves[k % 2] += [Pos(x, 0, 0) * tube(9, 4, 30 * k, 30 * k + 30), arm]
        leaves[k % 2] -= Pos(x, 0, 30 * k) * Cylinder(4, 30, align=LOW)
    return {"S1": leaves[0], "S2": leaves[1]}


def links(*, pinned: bool) -> Solids:
    """Return two links that overlap, with a pin through both or a weld nut beside them, and a pin at one end."""
    one = Box(80, 30, 8, align=LOW) + Pos(40, 0, 0) * Cylinder(15, 8, align=LOW)
    one -= [Pos(x, 0, 0) * Cylinder(6, 20) for x in (-25, 40)]
    pin, end = Pos(40 if pinned else 0, 0, -4 if pinned else -24), Pos(-25, 0, -4)
    solids = {"S1": one, "S2": Pos(80, 0, 8) * Rot(0, 0, 180) * one}
    return solids | {name: at * Cylinder(6, 24, align=LOW) for name, at in (("pin", pin), ("end", end))}


def lid(wall_mm: float) -> Solids:
    """Return a case with small ribs of one wall in it, and a lid on it."""
    case = Box(110, 70, 40, align=LOW) - Pos(0, 0, wall_mm) * Box(110 - 2 * wall_mm, 70 - 2 * wall_mm, 40, align=LOW)
    case += [Pos(x, 0, 0) * Box(wall_mm, 14, 14, align=LOW) for x in (-30, -10, 10, 30)]
    return {"S1": case, "S2": Pos(0, 0, 40) * Box(110, 70, wall_mm, align=LOW)}


def lip(mm: float) -> Solids:
    return {"S1": BASE, "S2": Box(90, mm, mm, align=LOW)}


def blocks(size: float) -> Solids:
    """Return a small block on a larger one, of so many mm."""
    foot, half = Box(size, size, size / 2, align=LOW), size / 2
    return {"S1": foot, "S2": Pos(0, 0, half) * Box(half, half, size, align=LOW)}


def nested(*, deep: bool) -> Solids:
    """Return a bar on a plate, in a slot of a block or beside it."""
    bar = Box(40, 40, 60, align=LOW)
    block = Box(120, 120, 60, align=LOW) - Pos(0, 40, 0) * Box(40, 120, 60, align=LOW)
    return {"S1": BASE, "S2": bar, "S3": Pos(0, 0 if deep else -160, 0) * block}


def web() -> Any:
    return Box(200, 8, 80, align=LOW)


def found(solids: Solids, **judging: Any) -> tuple[float, set[str], tuple[Seam, ...]]:
    """Return the length of the accepted seams, the rules that speak against others, and all candidates."""
    graph = to_brep([(name, shape.solid().wrapped) for name, shape in solids.items()])
    seams = detect_seams(graph, SeamOptions(judging=Judging(**judging)))
    rules = {one.rule for seam in seams if not seam.accepted for one in seam.findings}
    return sum(seam.length_mm for seam in seams if seam.accepted), rules, seams


@pytest.mark.parametrize(
    ("solids", "rule", "welded"),
    [
        (lambda: framed(groove=True), Rule.CLOSED_IN, lambda: framed(groove=False)),
        (lambda: rings(*BEARING), Rule.RING_IN_RING, lambda: rings(*HUB)),
        (lambda: table(Box(70, 70, 700, align=LOW)), Rule.TIMBER, lambda: table(tube(30, 27, 0, 700))),
        (lambda: blocks(14.0), Rule.SMALLER_THAN_NOZZLE, lambda: blocks(70.0)),
        (lambda: wheel(Torus(100, 20)), Rule.ROLLING, lambda: wheel(Cylinder(101, 40))),
        (lambda: lip(4), Rule.TOO_THIN, lambda: lip(12)),
        (hinge, Rule.LINED_UP, lambda: rings(*HUB)),
        (lambda: lid(2), Rule.ONE_PIECE, lambda: lid(5)),
        (lambda: collared(closed=True), Rule.ONE_PIECE, lambda: collared(closed=False)),
    ],
    ids=["pane", "bearing", "table", "terminal", "wheel", "lip", "hinge", "lid", "cup"],
)
def test_what_is_not_welded_is_told_by_its_shape(solids: Made, rule: Rule, welded: Made) -> None:
    taken_mm, rules, _ = found(solids())
    assert taken_mm == 0
    assert rule.key in rules
    taken_mm, rules, _ = found(welded())
    assert taken_mm > 30
    assert rule.key not in rules


@pytest.mark.parametrize("pinned", [True, False])
def test_links_that_turn_about_a_pin_are_not_welded_to_each_other_nor_to_the_pin(pinned: bool) -> None:
    seams = found(links(pinned=pinned))[2]
    own = [seam for seam in seams if seam.solids == ("S1", "S2")]
    assert any(seam.accepted for seam in seams if "S1" in seam.solids and {"pin", "end"} & {*seam.solids}) != pinned
    assert any(seam.accepted for seam in own) != pinned
    assert any(one.rule == Rule.BOLTED.key for seam in own for one in seam.findings) == pinned


def test_a_bar_in_a_slot_is_not_welded_to_the_plate_below() -> None:
    for deep, welded_mm in ((True, 0.0), (False, 160.0)):
        own = [seam for seam in found(nested(deep=deep))[2] if seam.solids == ("S1", "S2")]
        assert sum(seam.length_mm for seam in own if seam.accepted) == pytest.approx(welded_mm)
        assert any(one.rule == Rule.BURIED.key for seam in own for one in seam.findings) == deep


def test_your_word_and_generous_take_them() -> None:
    solids = table(Box(70, 70, 700, align=LOW))
    assert found(solids, weld=("*",))[0] == pytest.approx(found(solids, level=Level.GENEROUS)[0])
    assert found(solids, weld=("*",))[0] > 1000


def test_a_table_of_named_steel_is_welded() -> None:
    solids = {f"steel bar {name}": shape for name, shape in table(Box(70, 70, 700, align=LOW)).items()}
    assert found(solids)[0] > 1000


def test_a_body_that_is_in_the_file_twice_is_welded_once() -> None:
    once, _, _ = found({"plate": BASE, "web": web()})
    copy = chamfer(web().edges().group_by()[-1], 2)
    twice, _, seams = found({"plate": BASE, "web": web(), "Chamfer": copy})
    assert once == pytest.approx(twice) == pytest.approx(400.0)
    assert all("Chamfer" not in seam.solids for seam in seams if seam.accepted)
    graph = to_brep([(name, shape.solid().wrapped) for name, shape in (("web", web()), ("Chamfer", copy))])
    members = take_members(graph, TrimmedFaces.of(graph), Judging()).notes.members
    assert [one.taken_as for one in members] == ["a member", "a copy"]
    assert members[1].why == ("fills the same room as web",)


def test_what_is_left_between_castings_is_doubted_with_them() -> None:
    taken_mm, rules, _ = found(castings())
    assert taken_mm == 0
    assert Rule.LEFT_OVER.key in rules
    alone = {name: shape for name, shape in castings().items() if name in ("P", "B")}
    assert found(alone)[0] == pytest.approx(80.0)
