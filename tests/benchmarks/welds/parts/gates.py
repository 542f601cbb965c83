"""A gate and the drawbar of a trailer."""

import numpy as np
from build123d import Pos, Rot

from tests.benchmarks.welds.lists import OPTIONAL, PROBABLE, SURE, Weld, circle, line
from tests.benchmarks.welds.parts.part import Member, Part, straight
from tests.benchmarks.welds.parts.shapes import BLACK, BRIGHT, CAST, DARK, STEEL, block, pipe, plate, rod, rolled
from tests.benchmarks.welds.parts.tubes import Tube, tube_end

TUBE = Tube(side=40.0, radius=5.0)
BAR_MM, BARREL_MM = 6.0, 10.0  #: Radii of the bars of the gate and of the barrel of its hinge.
LEAN = float(np.radians(25.0))  #: Of the two tubes of the drawbar to its axis.


def gate() -> Part:
    """Return a gate: a frame of rounded tube with round bars, a hinge with a barrel, and plastic caps."""
    tube = {"wall": 2.5, "radius": TUBE.radius}
    members = [
        Member("stile left", rolled((0, 0, 0), (40, 40, 600), "z", **tube), STEEL, "square tube 40 x 2.5"),
        Member("stile right", rolled((460, 0, 0), (500, 40, 600), "z", **tube), STEEL, "square tube 40 x 2.5"),
        Member("rail low", rolled((40, 0, 0), (460, 40, 40), "x", **tube), DARK, "square tube 40 x 2.5"),
        Member("rail high", rolled((40, 0, 560), (460, 40, 600), "x", **tube), DARK, "square tube 40 x 2.5"),
        Member("strap", block((-5, 8, 100), (0, 32, 180)), DARK, "flat bar 24 x 5"),
        Member("barrel", pipe(BARREL_MM, 3.9, (-15, 20, 110), (0, 0, 1), 60), STEEL, "hinge barrel, round tube 20"),
    ]
    welds: list[Weld] = []
    for rail, z, low in (("rail low", 0.0, True), ("rail high", 560.0, False)):
        for stile, x, way in (("stile left", 40.0, 1.0), ("stile right", 460.0, -1.0)):
            ends = {"flush_low": low, "flush_high": not low}
            welds += tube_end((rail, stile), (x, 0, z), (0, 0, 1), (0, 1, 0), (way, 0, 0), tube=TUBE, **ends)
    for k, x in enumerate((120.0, 200.0, 300.0, 380.0)):
        name = f"bar {k + 1}"
        members.append(Member(name, rod(BAR_MM, (x, 20, 40), (0, 0, 1), 520), DARK, "round bar 12"))
        for rail, z in (("rail low", 40.0), ("rail high", 560.0)):
            points = circle((x, 20, z), (0, 0, 1), BAR_MM)
            welds.append(Weld(f"{name} {rail}", (name, rail), "fillet round a bar", SURE, points))
    for name, x in (("left", 0.0), ("right", 460.0)):
        cap = block((x + 2.6, 2.6, 580), (x + 37.4, 37.4, 600)) + block((x, 0, 600), (x + 40, 40, 603))
        members.append(Member(f"plastic cap 40 x 40 {name}", cap, BLACK, "plastic plug", welded=False))
    welds += straight(
        ("strap", "stile left"),
        *((f"strap side {y}", "lap fillet", SURE, (0, y, 100), (0, y, 180)) for y in (8, 32)),
        *((f"strap end {z}", "lap fillet at the end", PROBABLE, (0, 8, z), (0, 32, z)) for z in (100, 180)),
    )
    for y in (15.0, 25.0):
        points = line((-5, y, 110), (-5, y, 170))
        welds.append(Weld(f"barrel {y:g}", ("barrel", "strap"), "flare bevel, barrel on strap", SURE, points, 5.5))
    return Part("gate", "gate of rounded tube with round bars and a hinge; plastic caps", members, welds)


def drawbar() -> Part:
    """Return the drawbar of a trailer: two tubes in a V on a plate, a gusset over them, a bolted coupling."""
    half, radius = 25.0, 8.0
    front = plate([(-10, -90, -35), (-10, 90, -35), (-10, 90, 35), (-10, -90, 35)], (10, 0, 0))
    casting = block((-60, -30, -25), (-10, 30, 25)) + rod(24, (-75, 0, -25), (0, 0, 1), 50)
    members = [Member("front plate", front, STEEL, "plate 180 x 70 x 10")]
    coupling = Member("ball coupling", casting, CAST, "casting, bolted on", welded=False)
    for k, y in enumerate((-20.0, 20.0)):
        hole = rod(6.5, (-60, y, 0), (1, 0, 0), 60)
        members[0], coupling = members[0].without(hole), coupling.without(hole)
        nut = rod(11, (0, y, 0), (1, 0, 0), 10)
        bolt = rod(6, (-60, y, 0), (1, 0, 0), 70) + rod(10, (-68, y, 0), (1, 0, 0), 8) + nut
        members.append(Member(f"DIN 931 M12 x 70 {k + 1}", bolt, BRIGHT, "hexagon bolt with its nut", welded=False))
    offset, flat = 62.0, (half - radius) / np.cos(LEAN)
    wide, slope = half / np.cos(LEAN), float(np.tan(LEAN))
    shape = rolled((-100, -half, -half), (450, half, half), "x", wall=4.0, radius=radius)
    welds: list[Weld] = []
    for side, name in ((1.0, "tube right"), (-1.0, "tube left")):
        tube = Pos(0, side * offset, 0) * Rot(0, 0, side * 25.0) * shape
        tube = tube - block((-200, -300, -100), (0, 300, 100))
        members.append(Member(name, tube, DARK, "square tube 50 x 4, cut at 25 degrees"))
        y0, y1, out = (side * (offset + by) for by in (-flat, flat, wide))
        inner, z = side * (offset - wide), half - radius
        welds += straight(
            (name, "front plate"),
            *((f"{name} {z_:g}", "tee fillet", SURE, (0, y0, z_), (0, y1, z_)) for z_ in (-half, half)),
            (f"{name} outside", "fillet, acute side of 65 degrees", SURE, (0, out, -z), (0, out, z)),
            (f"{name} inside", "fillet, obtuse side", SURE, (0, inner, -z), (0, inner, z)),
        )
        welds += _corners((name, "front plate"), side, offset, half, radius)
        edge = {x: side * (offset + x * slope + 12.0) for x in (60.0, 180.0)}
        near = {x: side * (offset + x * slope - flat) for x in (60.0, 180.0)}
        welds += straight(
            ("gusset", name),
            (f"gusset along {name}", "lap fillet", SURE, (60, edge[60.0], half), (180, edge[180.0], half)),
            *((f"gusset {name} {x:g}", "lap fillet", SURE, (x, near[x], half), (x, edge[x], half)) for x in near),
        )
        under = [(x, side * (offset + x * slope - wide), half) for x in (60.0, 180.0)]
        points = line(*under)
        welds.append(Weld(f"under gusset {name}", ("gusset", name), "flare bevel from below", OPTIONAL, points, 8.5))
    low, high = (offset + x * slope + 12.0 for x in (60.0, 180.0))
    outline = [(60, -low, half), (60, low, half), (180, high, half), (180, -high, half)]
    members += [Member("gusset", plate(outline, (0, 0, 6)), STEEL, "plate 6 mm over both tubes"), coupling]
    return Part("drawbar", "drawbar of a trailer: tubes in a V, gusset, bolted coupling", members, welds)


def _corners(pair: tuple[str, str], side: float, offset: float, half: float, radius: float) -> list[Weld]:
    """Return the welds round the corners of a tube that is cut at an angle: quarters of ellipses."""
    welds = []
    t = np.radians(np.linspace(0, 90, 10))
    for a in (-1.0, 1.0):
        for b in (-1.0, 1.0):
            y = side * (offset + a * (half - radius + radius * np.cos(t)) / np.cos(LEAN))
            points = np.column_stack([np.zeros(len(t)), y, b * (half - radius + radius * np.sin(t))])
            welds.append(Weld(f"{pair[0]} corner {a:g} {b:g}", pair, "round the corner", OPTIONAL, points))
    return welds
