"""Small parts whose seams and features anybody can count, saved as graphs for the tests that need no kernel.

`python -m tests.samples.graphs FOLDER` writes all of them, and those of the sample parts.
"""

import math
import sys
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

from cad.kernel.geometry import to_location
from cad.kernel.modelling import disc, filleted, fused
from cad.kernel.primitives import box, cut, cylinder, prism
from cad.kernel.to_brep import to_brep
from cad.samples.parts import SAMPLES
from cad.step.new_file import Member
from tests.samples.bolted import BOLTED_GRAPHS
from wpcal.brep import BrepGraph
from wpcal.brep.graph_file import graph_bytes
from wpcal.core.arrays import IntArray
from wpcal.core.records import write_file
from wpcal.core.transform import RigidTransform

UP = (0.0, 0.0, 1.0)
FAR_MM = 1000.0  #: Five times the T-joint: a copy there has nothing to do with the first one.
DISC_ARCS = 80  #: Arcs of 1.96 mm round the disc.
BLOCK_SHIFT_MM = (312.5, -77.25, 40.125)
BLOCK_POSE = ((31.0, -7.0, 44.0), (20.0, -35.0, 70.0))
"""Where the turned block is: mm, and degrees about its own x, then y, then z."""

Solids = list[tuple[str, Any]]  #: Names and kernel solids.


def numbered(*shapes: Any) -> Solids:
    """Return solids with names that say nothing: ``S0``, ``S1``, …."""
    return [(f"S{number}", shape) for number, shape in enumerate(shapes)]


def graph_of(*shapes: Any) -> BrepGraph:
    """Return the graph of solids with names that say nothing."""
    return to_brep(numbered(*shapes))


def _of_sample(name: str, *, backwards: bool = False) -> Solids:
    members: list[Member] = SAMPLES[name].build()
    solids = [(member, shape) for member, shape, _ in members]
    return solids[::-1] if backwards else solids


def _plate() -> Any:
    return box(200, 100, 8, (0, 0, 0))


def _web(z: float) -> Any:
    return box(160, 8, 80, (20, 46, z))


def _pin_flush_with_its_plate() -> Solids:
    def pin() -> Any:
        return cylinder(5, 40, (0, 0, -40), UP)

    return numbered(cut(box(80, 80, 10, (-40, -40, -10)), pin()), pin())


def _rod_through_a_plate() -> Solids:
    def rod() -> Any:
        return cylinder(30, 100, (0, 0, -50), UP)

    return numbered(cut(box(200, 200, 10, (-100, -100, -10)), rod()), rod())


def saddle(tilt_deg: float, *, trimmed: bool = True) -> Solids:
    """Return a pipe of 70 mm on a bar of 120 mm, leaning from square; not trimmed it runs into the bar."""
    tilt = math.radians(tilt_deg)
    axis = (math.sin(tilt), 0.0, math.cos(tilt))
    run = cylinder(60, 300, (-150, 0, 0), (1, 0, 0))
    tools = [cylinder(31, 170, (0, 0, 0), axis), *([run] if trimmed else [])]
    return numbered(run, cut(cylinder(35, 160, (0, 0, 0), axis), *tools))


def _bolt(x: float) -> Any:
    """Return a shank of 10 mm below z 20 with a head above."""
    return fused(cylinder(5, 45, (x, 0, -25), UP), cylinder(9, 7, (x, 0, 20), UP))


def _nut(x: float) -> Any:
    return cut(box(17, 17, 8, (x - 8.5, -8.5, -8)), cylinder(5, 8, (x, 0, -8), UP))


def _two_plates(*holes: Any) -> list[Any]:
    """Return two plates of 10 mm on each other, the upper one smaller."""
    return [cut(box(200, 100, 10, (-100, -50, 0)), *holes), cut(box(160, 60, 10, (-80, -30, 10)), *holes)]


def _bolted_plates() -> Solids:
    holes = [cylinder(5.5, 20, (x, 0, 0), UP) for x in (-40, 40)]
    return numbered(*_two_plates(*holes), _bolt(-40), _nut(-40), _bolt(40), _nut(40))


def _bar_through_plates(*, with_nut: bool) -> Solids:
    plates = _two_plates(cylinder(5, 20, (0, 0, 0), UP))
    return numbered(*plates, cylinder(5, 60, (0, 0, -20), UP), *([_nut(0)] if with_nut else []))


def _collar_on_a_tube() -> Solids:
    tube = cut(cylinder(15, 200, (0, 0, 0), UP), cylinder(12, 200, (0, 0, 0), UP))
    return numbered(tube, cut(cylinder(25, 8, (0, 0, 90), UP), cylinder(15, 8, (0, 0, 90), UP)))


def _closed_box() -> Solids:
    """Return six sheets of 6 mm, 180 mm wide inside."""
    a, b, t = 180.0, 192.0, 6.0
    sheets = [box(b, b, t, (-t, -t, -t)), box(b, b, t, (-t, -t, a))]
    sheets += [box(t, b, a, (-t, -t, 0)), box(t, b, a, (a, -t, 0)), box(a, t, a, (0, -t, 0)), box(a, t, a, (0, a, 0))]
    return numbered(*sheets)


def _wall_on_a_step() -> Solids:
    """Return a wall that is half on a plate and half 0.2 mm above its lower half."""
    floor = fused(box(100, 100, 10, (0, 0, 0)), box(100, 100, 10.2, (100, 0, 0)))
    return numbered(floor, box(120, 8, 60, (40, 46, 10.2)))


def _disc_of_short_arcs() -> Solids:
    """Return a disc on a plate, its rim cut into `DISC_ARCS` arcs."""
    return [("plate", box(100, 100, 10, (-50, -50, 0))), ("disc", disc(25, 30, (0, 0, 10), arcs=DISC_ARCS))]


def bead_tee() -> Any:
    """Return in one piece a web of 8 mm across a whole plate, with a bead of 6 mm on both sides."""
    shape = fused(box(200, 100, 10, (0, 0, 0)), box(200, 8, 80, (0, 46, 10)), unified=False)
    return filleted(shape, 6.0, lambda x, y, z: abs(z - 10) < 1e-6 and abs(abs(y - 50) - 4) < 1e-6 and 1 < x < 199)


def bead_pipe(tilt_deg: float) -> Any:
    """Return in one piece a pipe of 60 mm on a plate with a bead of 5 mm round it, leaning from square."""
    tilt = math.radians(tilt_deg)
    axis = (math.sin(tilt), 0.0, math.cos(tilt))
    low, lower = ((-length * axis[0], 0.0, -length * axis[2]) for length in (60, 150))
    pipe = cut(cylinder(30, 160, low, axis), box(400, 400, 100, (-200, -200, -100)))
    shape = fused(box(200, 200, 10, (-100, -100, -10)), pipe, unified=False)
    shape = filleted(shape, 5.0, lambda x, y, z: abs(z) < 1e-6 and math.hypot(x, y) < 60)
    return cut(shape, cylinder(27, 300, lower, axis))


def _tee_and_far_copy() -> Solids:
    far = to_location(RigidTransform.from_six_tuple([FAR_MM, 0, 0, 0, 0, 0], target="base", source="part"))
    return [*((f"{name} far", shape.Moved(far)) for name, shape in _of_sample("tee")), *_of_sample("tee")]


def _machined(make: Callable[[Any], Any]) -> Solids:
    """Return a part that is drawn with build123d."""
    import build123d

    return [("block", make(build123d).solid().wrapped)]


def _at_low(b: Any, x: float, y: float, z: float) -> Any:
    return b.Box(x, y, z, align=(b.Align.MIN,) * 3)


def _pin(b: Any, x: float, y: float, z: float, radius: float, height: float) -> Any:
    return b.Pos(x, y, z) * b.Cylinder(radius, height, align=(b.Align.CENTER, b.Align.CENTER, b.Align.MIN))


def _cone(b: Any, x: float, y: float, z: float, low: float, high: float, height: float) -> Any:
    return b.Pos(x, y, z) * b.Cone(low, high, height, align=(b.Align.CENTER, b.Align.CENTER, b.Align.MIN))


def _block(b: Any) -> Any:
    """Return 200 × 100 × 20 with a counterbored, a blind, a through and a countersunk hole, a boss and a slot."""
    part = _at_low(b, 200, 100, 20) + _pin(b, 50, 70, 20, 10, 15)
    holes = ((30, 30, 0, 5, 20), (30, 30, 14, 9, 6), (70, 30, 8, 4, 12), (110, 30, 0, 6, 20), (150, 30, 0, 3, 20))
    for hole in holes:
        part -= _pin(b, *hole)
    part -= _cone(b, 150, 30, 17, 3, 6, 3)
    return part - b.Pos(130, 70, 0) * b.extrude(b.SlotOverall(40, 12), 20)


def _turned_block(b: Any) -> Any:
    place, turn = BLOCK_POSE
    return b.Pos(*place) * b.Rot(*turn) * _block(b)


def _comb(b: Any) -> Any:
    return _at_low(b, 100, 40, 20) - b.Pos(40, 0, 10) * _at_low(b, 20, 40, 10)


def _rounded_box(b: Any, *, upright: bool, top: bool = False) -> Any:
    part = _at_low(b, 80, 60, 40)
    part = b.fillet(part.edges().filter_by(b.Axis.Z) if upright else part.edges(), 8)
    return b.fillet(part.edges().group_by(b.Axis.Z)[-1], 3) if top else part


def _bracket(b: Any) -> Any:
    bracket = _at_low(b, 60, 60, 40) - b.Pos(10, 0, 10) * _at_low(b, 40, 60, 30)
    return bracket - b.Pos(0, 30, 25) * b.Rot(0, 90, 0) * _pin(b, 0, 0, 0, 6, 60)


def _cross_hole(b: Any) -> Any:
    part = _at_low(b, 60, 60, 40) - _pin(b, 30, 30, 10, 8, 30)
    return part - b.Pos(0, 30, 16) * b.Rot(0, 90, 0) * _pin(b, 0, 0, 0, 2, 30)


def _drilled(b: Any) -> Any:
    return _at_low(b, 60, 60, 40) - _pin(b, 30, 30, 15, 6, 25) - _cone(b, 30, 30, 11, 0, 6, 4)


def crossed_tee() -> Solids:
    """Return a web on a base; a block on the base stands against the web, on 40 mm of the joint on its front."""
    return [
        ("base", box(200, 100, 10, (0, 0, 0))),
        ("web", box(180, 8, 60, (10, 46, 10))),
        ("block", box(40, 40, 40, (80, 6, 10))),
    ]


def _tee_beside_block() -> Solids:
    """Return a web on a base, 200 mm long; over 40 mm of it a block stands so near that only the wire has room."""
    return [
        ("base", box(240, 120, 10, (0, 0, 0))),
        ("web", box(200, 8, 60, (20, 46, 10))),
        ("block", box(40, 20, 80, (100, 5, 10))),
    ]


def _tee_under_bar() -> Solids:
    """Return a web on a base, 200 mm long; a bar crosses its joint so high that a torch has room beside it only."""
    return [
        ("base", box(240, 120, 10, (0, 0, 0))),
        ("web", box(200, 8, 120, (20, 46, 10))),
        ("bar", box(12, 100, 12, (114, -54, 60))),
    ]


def _gusseted_bracket() -> Solids:
    """Return an upright plate on the rear of a base, with two gussets of 8 mm, one of them leaning by 45 degrees."""
    gusset = prism([(30, 92, 8), (30, 42, 8), (30, 92, 58)], (8, 0, 0))
    leaning = prism([(90, 92, 8), (98, 92, 8), (148, 42, 8), (140, 42, 8)], (0, 0, 40))
    return [
        ("base", box(160, 100, 8, (0, 0, 0))),
        ("upright", box(160, 8, 100, (0, 92, 8))),
        ("gusset", gusset),
        ("leaning", leaning),
    ]


def _boss_with_ribs() -> Solids:
    """Return a boss of 60 mm on a plate with two ribs of 6 mm; the seam of the boss would start inside the first."""
    boss = cylinder(30, 40, (0, 0, 10), UP)
    ribs = box(50, 6, 25, (-75, -3, 10)), box(6, 50, 25, (-3, 25, 10))
    return [
        ("plate", box(200, 200, 10, (-100, -100, 0))),
        ("boss", boss),
        *((name, cut(rib, boss)) for name, rib in zip(("west", "north"), ribs, strict=True)),
    ]


def _pipe_through_plates() -> Solids:
    """Return a pipe of 60 mm through two plates, and a rib of 5 mm from plate to plate along the pipe."""
    pipe = cut(cylinder(30, 200, (0, 0, -50), UP), cylinder(26, 200, (0, 0, -50), UP))
    plates = [cut(box(160, 160, 8, (-80, -80, z)), cylinder(30, 8, (0, 0, z), UP)) for z in (0, 92)]
    rib = cut(box(50, 5, 84, (25, -2.5, 8)), cylinder(30, 84, (0, 0, 8), UP))
    return [("pipe", pipe), ("lower", plates[0]), ("upper", plates[1]), ("rib", rib)]


def _tee_beside_bolt() -> Solids:
    """Return a T-joint with a bolt of 8 mm that stands on the plate, 9 mm from the middle of the joint."""
    return [("plate", _plate()), ("web", _web(8)), ("bolt", cylinder(4, 60, (100, 33, 8), UP))]


def _section(*corners: tuple[float, float]) -> Solids:
    """Return a bar of 300 mm with a cross-section in the plane y, z."""
    return numbered(prism([(0.0, y, z) for y, z in corners], (300.0, 0.0, 0.0)))


def _u_sheet(t: float) -> Any:
    """Return a sheet of thickness t bent to a U, 60 mm wide and high, 80 mm long."""
    return cut(box(80, 60, 60, (0, 0, 0)), box(80, 60 - 2 * t, 60, (0, t, t)))


def _post_base() -> Solids:
    """A rod of 20 mm welded under a bent U with holes, in one solid."""
    holes = [cylinder(4, 60, (x, 0, 40), (0.0, 1.0, 0.0)) for x in (10, 25, 40, 55, 70)]
    return numbered(fused(cut(_u_sheet(4.0), *holes), cylinder(10, 200, (40, 30, -200), UP)))


def _hollow_corner() -> Solids:
    """Two square tubes of 40 x 3 mm that meet at a corner, in one solid."""
    outer = fused(box(240, 40, 40, (0, 0, 0)), box(40, 240, 40, (0, 0, 0)))
    return numbered(cut(outer, box(237, 34, 34, (3, 3, 3)), box(34, 237, 34, (3, 3, 3))))


def _pockets() -> Solids:
    """A block of 40 mm with four pockets of different depths, and a boss: milled."""
    pockets = [box(40, 30, depth, (10 + 50 * k, 10, 40 - depth)) for k, depth in enumerate((10, 15, 22, 31))]
    return numbered(fused(cut(box(220, 90, 40, (0, 0, 0)), *pockets), cylinder(15, 12, (110, 65, 40), UP)))


GRAPHS: dict[str, Callable[[], Solids]] = {
    **{name: partial(_of_sample, name) for name in SAMPLES},
    "frame-backwards": partial(_of_sample, "frame", backwards=True),
    "tee-and-far-copy": _tee_and_far_copy,
    "joint-tee": lambda: numbered(_plate(), _web(8)),
    "joint-tee-gap": lambda: numbered(_plate(), _web(8.4)),
    "joint-tee-apart": lambda: numbered(_plate(), _web(9)),
    "joint-tee-in-one": lambda: numbered(fused(_plate(), _web(8))),
    "joint-corner": lambda: numbered(_plate(), box(200, 8, 80, (0, 0, 8))),
    "joint-open-corner": lambda: numbered(_plate(), box(200, 8, 80, (0, -8, 8))),
    "joint-butt": lambda: numbered(_plate(), box(200, 100, 8, (0, 100, 0))),
    "joint-lap": lambda: numbered(box(120, 50, 6, (0, 0, 0)), box(120, 50, 6, (70, 0, 6))),
    "pin-flush": _pin_flush_with_its_plate,
    "rod-through": _rod_through_a_plate,
    "saddle-90": partial(saddle, 0.0),
    "saddle-60": partial(saddle, 30.0),
    "bolted-plates": _bolted_plates,
    "bar-through-plates": partial(_bar_through_plates, with_nut=False),
    "bar-with-nut": partial(_bar_through_plates, with_nut=True),
    "collar-on-tube": _collar_on_a_tube,
    "window": lambda: numbered(cut(box(200, 150, 10, (0, 0, 0)), box(80, 60, 10, (50, 40, 0)))),
    "thick-tee-in-one": lambda: numbered(fused(box(200, 100, 15, (0, 0, 0)), box(160, 8, 80, (20, 46, 15)))),
    "closed-box": _closed_box,
    "wall-on-step": _wall_on_a_step,
    "small-rod": lambda: [("plate", box(60, 60, 10, (-30, -30, 0))), ("rod", cylinder(3, 30, (0, 0, 10), UP))],
    "rod-on-plate": lambda: [("plate", box(100, 100, 10, (-50, -50, 0))), ("rod", cylinder(25, 30, (0, 0, 10), UP))],
    "crack": lambda: [("left", box(50, 80, 8, (-50, 0, 0))), ("right", box(50, 80, 8, (0, 0, 0)))],
    "disc-of-arcs": _disc_of_short_arcs,
    "crossed-tee": crossed_tee,
    "gusseted-bracket": _gusseted_bracket,
    "tee-beside-block": _tee_beside_block,
    "tee-under-bar": _tee_under_bar,
    "boss-with-ribs": _boss_with_ribs,
    "pipe-through-plates": _pipe_through_plates,
    "tee-beside-bolt": _tee_beside_bolt,
    "plain-block": lambda: [("block", box(50, 50, 10, (0, 0, 0)))],
    "bead-tee": lambda: [("part", bead_tee())],
    "bead-pipe": lambda: [("part", bead_pipe(0.0))],
    "bead-leaning-pipe": lambda: [("part", bead_pipe(25.0))],
    "bead-tee-beside-block": lambda: [("tee", bead_tee()), ("block", box(50, 50, 50, (0, 0, -50)))],
    "angle": partial(_section, (0, 0), (60, 0), (60, 8), (8, 8), (8, 60), (0, 60)),
    "channel": partial(_section, (0, 0), (50, 0), (50, 8), (8, 8), (8, 92), (50, 92), (50, 100), (0, 100)),
    "zed": partial(_section, (0, 0), (50, 0), (50, 60), (90, 60), (90, 68), (42, 68), (42, 8), (0, 8)),
    "i-section": partial(
        _section,
        (0, 0),
        (80, 0),
        (80, 8),
        (43, 8),
        (43, 92),
        (80, 92),
        (80, 100),
        (0, 100),
        (0, 92),
        (37, 92),
        (37, 8),
        (0, 8),
    ),
    "lap-in-one": lambda: numbered(fused(box(120, 50, 6, (0, 0, 0)), box(120, 50, 6, (70, 0, 6)))),
    "bent-sheet": lambda: numbered(_u_sheet(3.0)),
    "post-base": _post_base,
    "hollow-corner": _hollow_corner,
    "pockets": _pockets,
    "bent-block": lambda: [("block", filleted(box(100, 60, 40, (0, 0, 0)), 5.0, lambda x, y, z: abs(z - 40) < 1e-6))],
    "block": partial(_machined, _block),
    "block-shifted": partial(_machined, lambda b: b.Pos(*BLOCK_SHIFT_MM) * _block(b)),
    "block-turned": partial(_machined, _turned_block),
    "comb": partial(_machined, _comb),
    "rounded-upright": partial(_machined, partial(_rounded_box, upright=True)),
    "rounded-all": partial(_machined, partial(_rounded_box, upright=False)),
    "rounded-top": partial(_machined, partial(_rounded_box, upright=True, top=True)),
    "sharp-box": partial(_machined, lambda b: b.Box(80, 60, 40)),
    "bracket": partial(_machined, _bracket),
    "cross-hole": partial(_machined, _cross_hole),
    "drilled": partial(_machined, _drilled),
    **BOLTED_GRAPHS,
}
"""The parts whose graphs are saved."""


def build_graph(name: str) -> BrepGraph:
    """Return the graph of one of `GRAPHS`, made by the kernel."""
    return to_brep(GRAPHS[name]())


def main(folder: str) -> None:
    """Write all graphs into a folder."""
    Path(folder).mkdir(parents=True, exist_ok=True)
    for name in GRAPHS:
        write_file(Path(folder) / f"{name}.npz", graph_bytes(build_graph(name)), overwrite=True)


if __name__ == "__main__":
    main(sys.argv[1])


def nothing_crosses(graph: BrepGraph, pairs: IntArray) -> tuple[BrepGraph, None, tuple[()]]:
    """Stand in for the kernel where no solids run into each other."""
    assert not len(pairs)
    return graph, None, ()
