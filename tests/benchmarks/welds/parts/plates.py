"""Plates and sheets: tabs and slots, one fused solid, parts that are bolted and welded."""

from typing import Any

import numpy as np

from tests.benchmarks.welds.lists import OPTIONAL, PROBABLE, SURE, Weld, line, loop
from tests.benchmarks.welds.parts.part import Member, Part, straight
from tests.benchmarks.welds.parts.shapes import BLACK, BRIGHT, DARK, STEEL, block, plate, rod


def tab_plates() -> Part:
    """Return two sheets of 5 mm on a third: the web goes through slots with tabs, with 0.2 mm play on all sides."""
    base = block((0, 0, -5), (200, 150, 0))
    web = block((0, 72.5, 0), (200, 77.5, 80))
    tabs = ((40.0, 70.0), (130.0, 160.0))
    for low, high in tabs:
        base -= block((low - 0.2, 72.3, -5), (high + 0.2, 77.7, 0))
        web += block((low, 72.5, -5), (high, 77.5, 0))
    members = [
        Member("base sheet", base, STEEL, "sheet 200 x 150 x 5 with two slots"),
        Member("web", web, DARK, "sheet 5 mm with two tabs"),
        Member("rib", block((97.5, 77.5, 0), (102.5, 140, 60)), DARK, "sheet 5 mm"),
    ]
    on = ("web", "base sheet")
    welds = [
        Weld("web front", on, "tee fillet over tabs", SURE, line((0, 72.5, 0), (200, 72.5, 0))),
        Weld("web back 1", on, "tee fillet over a tab", SURE, line((0, 77.5, 0), (97.5, 77.5, 0))),
        Weld("web back 2", on, "tee fillet over a tab", SURE, line((102.5, 77.5, 0), (200, 77.5, 0))),
        Weld("web end 0", on, "wrap round the end", OPTIONAL, line((0, 72.5, 0), (0, 77.5, 0))),
        Weld("web end 200", on, "wrap round the end", OPTIONAL, line((200, 72.5, 0), (200, 77.5, 0))),
        Weld("rib end", ("rib", "base sheet"), "wrap round the end", OPTIONAL, line((97.5, 140, 0), (102.5, 140, 0))),
        Weld("rib top", ("rib", "web"), "wrap over the top", OPTIONAL, line((97.5, 77.5, 60), (102.5, 77.5, 60))),
    ]
    for x in (97.5, 102.5):
        welds.append(
            Weld(f"rib foot {x:g}", ("rib", "base sheet"), "tee fillet", SURE, line((x, 77.5, 0), (x, 140, 0)))
        )
        welds.append(Weld(f"rib up {x:g}", ("rib", "web"), "tee fillet", SURE, line((x, 77.5, 0), (x, 77.5, 60))))
    for low, high in tabs:
        rim = loop((low, 72.5, -5), (high, 72.5, -5), (high, 77.5, -5), (low, 77.5, -5))
        welds.append(Weld(f"tab {low:g} below", on, "plug round a flush tab", PROBABLE, rim))
    return Part("tab-plates", "sheets with tabs through slots", members, welds)


def fused_bracket() -> Part:
    """Return a bracket of four plates that was saved as one solid; its front edge is bent up with a radius."""
    body = block((0, 0, 0), (150, 100, 10)) + block((0, 0, 10), (150, 10, 90))
    for x in (30.0, 112.0):
        body += plate([(x, 10, 10), (x, 70, 10), (x, 10, 60)], (8, 0, 0))
    bend = rod(18, (0, 100, 18), (1, 0, 0), 150) - rod(8, (0, 100, 18), (1, 0, 0), 150)
    body += bend & block((0, 100, 0), (150, 130, 18))
    body += block((0, 108, 18), (150, 118, 40))
    body -= rod(6, (75, 0, 60), (0, 1, 0), 10)
    name = "bracket"
    welds = []
    for low, high in ((0.0, 30.0), (38.0, 112.0), (120.0, 150.0)):
        welds.append(Weld(f"back {low:g}", (name,), "tee fillet", SURE, line((low, 10, 10), (high, 10, 10))))
    for x in (30.0, 38.0, 112.0, 120.0):
        welds.append(Weld(f"gusset foot {x:g}", (name,), "tee fillet", SURE, line((x, 10, 10), (x, 70, 10))))
        welds.append(Weld(f"gusset up {x:g}", (name,), "tee fillet", SURE, line((x, 10, 10), (x, 10, 60))))
    for x in (30.0, 112.0):
        for end, y, z in (("toe", 70.0, 10.0), ("top", 10.0, 60.0)):
            points = line((x, y, z), (x + 8, y, z))
            welds.append(Weld(f"gusset {end} {x:g}", (name,), "wrap round the end", OPTIONAL, points))
    members = [Member(name, body, STEEL, "base, back and two gussets, fused; the front edge is bent")]
    return Part("fused-bracket", "weldment saved as one solid, with a bent edge", members, welds)


BOLTS = ((-70, -45), (0, -45), (70, -45), (-70, 45), (0, 45), (70, 45))  #: Places of the screws of the cover, mm.


def bolted_cover() -> Part:
    """Return a welded trough whose cover is bolted on over a gasket."""
    rubber = block((-80, -55, 60), (80, 55, 62)) - block((-60, -35, 60), (60, 35, 62))
    front, back = (_tapped(y) for y in (-45, 45))
    gasket = Member("gasket NBR", rubber, BLACK, "rubber", welded=False)
    cover = Member("cover", block((-80, -55, 62), (80, 55, 72)), STEEL, "plate 10 mm, bolted", welded=False)
    members = [
        Member("base", block((-100, -75, -12), (100, 75, 0)), STEEL, "plate 200 x 150 x 12"),
        Member("wall front", block((-80, -55, 0), (80, -35, 60)), DARK, "bar 60 x 20").without(*front),
        Member("wall back", block((-80, 35, 0), (80, 55, 60)), DARK, "bar 60 x 20").without(*back),
        Member("wall left", block((-80, -35, 0), (-60, 35, 60)), DARK, "bar 60 x 20"),
        Member("wall right", block((60, -35, 0), (80, 35, 60)), DARK, "bar 60 x 20"),
        gasket.without(*(rod(4.5, (x, y, 60), (0, 0, 1), 2) for x, y in BOLTS)),
        cover.without(*(rod(4.5, (x, y, 62), (0, 0, 1), 10) for x, y in BOLTS)),
    ]
    for k, (x, y) in enumerate(BOLTS):
        washer = rod(8, (x, y, 72), (0, 0, 1), 1.6) - rod(4.2, (x, y, 72), (0, 0, 1), 1.6)
        members.append(Member(f"ISO 7089 M8 {k + 1}", washer, BRIGHT, "washer", welded=False))
        hexagon = [(x + 7.5 * np.cos(t), y + 7.5 * np.sin(t), 73.6) for t in np.radians(range(0, 360, 60))]
        screw = plate(hexagon, (0, 0, 5.3)) + rod(4, (x, y, 40), (0, 0, 1), 33.6)
        members.append(Member(f"ISO 4017 M8 x 30 {k + 1}", screw, BRIGHT, "hexagon screw", welded=False))
    about = "welded trough with a gasket and a cover that are bolted on"
    return Part("bolted-cover", about, members, _trough_welds())


def _tapped(y: float) -> list[Any]:
    """Return the holes of the screws in one wall of the trough."""
    return [rod(4.0, (x, y, 35), (0, 0, 1), 25) for x, at in BOLTS if at == y]


def _trough_welds() -> list[Weld]:
    """Return the welds of the four walls of the trough on its base and with each other."""
    welds = []
    tee, inside = "tee fillet", "fillet inside the trough"
    for y, name in ((-55.0, "wall front"), (55.0, "wall back")):
        inner = y - np.sign(y) * 20.0
        welds += straight(
            (name, "base"),
            (f"{name} outside", tee, SURE, (-80, y, 0), (80, y, 0)),
            (f"{name} inside", inside, OPTIONAL, (-60, inner, 0), (60, inner, 0)),
        )
        for x, other in ((-80.0, "wall left"), (80.0, "wall right")):
            corner = x - np.sign(x) * 20.0
            welds += straight((name, "base"), (f"{name} end {x:g}", tee, SURE, (x, y, 0), (x, inner, 0)))
            welds += straight(
                (name, other),
                (f"{name} {other}", "corner butt, flush outside", PROBABLE, (x, inner, 0), (x, inner, 60)),
                (f"{name} {other} inside", "inner corner", OPTIONAL, (corner, inner, 0), (corner, inner, 60)),
            )
    for x, name in ((-80.0, "wall left"), (80.0, "wall right")):
        inner = x - np.sign(x) * 20.0
        welds += straight(
            (name, "base"),
            (f"{name} outside", tee, SURE, (x, -35, 0), (x, 35, 0)),
            (f"{name} inside", inside, OPTIONAL, (inner, -35, 0), (inner, 35, 0)),
        )
    return welds


def skewed_ribs() -> Part:
    """Return plates that meet at 60 degrees, with a gap, butt, and at the edge of a plate."""
    foot, lean = 8 / np.cos(np.radians(30.0)), 70 * np.tan(np.radians(30.0))
    outline = [(60, 10, 10), (60 + foot, 10, 10), (60 + foot + lean, 10, 80), (60 + lean, 10, 80)]
    rib = "plate 8 mm that leans by 30 degrees, cut to lie on the base"
    members = [
        Member("base", block((0, 0, 0), (300, 100, 10)), STEEL, "plate 300 x 100 x 10"),
        Member("extension", block((301, 0, 0), (400, 100, 10)), STEEL, "plate 10 mm, root gap 1 mm"),
        Member("leaning rib", plate(outline, (0, 80, 0)), DARK, rib),
        Member("raised rib", block((220, 10, 10.5), (230, 90, 90)), DARK, "plate 10 mm, 0.5 mm off the base"),
        Member("end plate", block((-10, 0, -10), (0, 100, 80)), DARK, "plate 10 mm on the end of the base"),
    ]
    right, z, wrap = 60 + foot, 10.0, "wrap round the end"
    leaning = straight(
        ("leaning rib", "base"),
        ("leaning rib obtuse", "fillet, obtuse side of 60 degrees", SURE, (60, 10, z), (60, 90, z)),
        ("leaning rib acute", "fillet, acute side of 60 degrees", SURE, (right, 10, z), (right, 90, z)),
        *((f"leaning rib end {y}", wrap, OPTIONAL, (60, y, z), (right, y, z)) for y in (10, 90)),
    )
    raised = straight(
        ("raised rib", "base"),
        *((f"raised rib {x}", "tee fillet, gap 0.5", SURE, (x, 10, z), (x, 90, z)) for x in (220, 230)),
        *((f"raised rib end {y}", wrap, OPTIONAL, (220, y, z), (230, y, z)) for y in (10, 90)),
    )
    butt = straight(
        ("base", "extension"),
        ("butt above", "butt, root gap 1", SURE, (300.5, 0, 10), (300.5, 100, 10)),
        ("butt below", "butt from below", OPTIONAL, (300.5, 0, 0), (300.5, 100, 0)),
        *((f"butt side {y}", "butt at the side", OPTIONAL, (300.5, y, 0), (300.5, y, 10)) for y in (0, 100)),
    )
    end = straight(
        ("end plate", "base"),
        ("end plate above", "tee fillet", SURE, (0, 0, 10), (0, 100, 10)),
        ("end plate below", "fillet below, plate 10 mm lower", SURE, (0, 0, 0), (0, 100, 0)),
        *((f"end plate side {y}", "flush at the side", OPTIONAL, (0, y, 0), (0, y, 10)) for y in (0, 100)),
    )
    about = "a leaning rib, a rib with a gap, a butt with a root gap, an end plate"
    return Part("skewed-ribs", about, members, [*butt, *leaning, *raised, *end])
