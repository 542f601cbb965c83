"""Parts that nobody welds: every accepted seam on them is wrong."""

import numpy as np
from build123d import Axis

from tests.benchmarks.welds.parts.part import Member, Part
from tests.benchmarks.welds.parts.shapes import BRIGHT, CAST, DARK, STEEL, block, plate, rod


def casting() -> Part:
    """Return a cast bearing housing: a foot, a boss and ribs with fillets, two machined bores."""
    body = (
        block((-80, -30, 0), (80, 30, 18)) + rod(38, (0, -32, 60), (0, 1, 0), 64) + block((-38, -28, 10), (38, 28, 60))
    )
    for x in (-1.0, 1.0):
        body += plate([(x * 30, -6, 18), (x * 72, -6, 18), (x * 30, -6, 60)], (0, 12, 0))
    sharp = body.edges().filter_by(Axis.Y).filter_by(lambda e: abs(e.center().Z - 18) < 0.1 and abs(e.center().X) < 60)
    body = body.fillet(4, sharp)
    body -= rod(22, (0, -40, 60), (0, 1, 0), 80) + rod(31, (0, -33, 60), (0, 1, 0), 15)
    for x in (-62.0, 62.0):
        body -= rod(7, (x, -18, 0), (0, 0, 1), 18) + rod(7, (x, 18, 0), (0, 0, 1), 18)
    return Part(
        "casting",
        "cast bearing housing, one solid",
        [Member("bearing housing EN-GJS-400", body, CAST, "casting", welded=False)],
        [],
    )


def machined_block() -> Part:
    """Return a milled block with a pocket, steps and a T slot, and a stop bolted and pinned to it."""
    body = block((0, 0, 0), (160, 100, 50))
    pocket = block((20, 20, 25), (90, 80, 50))
    body -= pocket.fillet(8, pocket.edges().filter_by(Axis.Z))
    body -= block((130, 0, 30), (160, 100, 50))
    body -= block((105, 0, 34), (115, 100, 50)) + block((101, 0, 26), (119, 100, 34))
    for y in (30.0, 70.0):
        body -= rod(4.2, (145, y, 5), (0, 0, 1), 25)
    body -= rod(5, (145, 50, 10), (0, 0, 1), 20)
    stop = block((132, 10, 30), (158, 90, 60))
    members = [Member("fixture block C45", body, STEEL, "milled block", welded=False)]
    for k, y in enumerate((30.0, 70.0)):
        stop -= rod(4.5, (145, y, 30), (0, 0, 1), 30) + rod(7.5, (145, y, 51), (0, 0, 1), 9)
        screw = rod(4, (145, y, 8), (0, 0, 1), 43.5) + rod(6.5, (145, y, 51), (0, 0, 1), 8)
        members.append(Member(f"DIN 912 M8 x 40 {k + 1}", screw, BRIGHT, "socket head screw", welded=False))
    stop -= rod(5, (145, 50, 30), (0, 0, 1), 20)
    members.insert(1, Member("stop C45", stop, DARK, "milled block, bolted and pinned", welded=False))
    members.append(Member("DIN 6325 10 x 40", rod(5, (145, 50, 10), (0, 0, 1), 40), BRIGHT, "dowel pin", welded=False))
    return Part("machined-block", "milled block with a bolted and pinned stop", members, [])


def bent_sheet() -> Part:
    """Return a bent bracket of sheet 3 mm, and a loose rolled angle beside it."""
    body = block((0, 0, 0), (74, 100, 3)) + block((77, 0, 6), (80, 100, 60))
    bend = rod(6, (74, 0, 6), (0, 1, 0), 100) - rod(3, (74, 0, 6), (0, 1, 0), 100)
    body += bend & block((74, 0, 0), (80, 100, 6))
    for x in (20.0, 50.0):
        body -= rod(5, (x, 50, 0), (0, 0, 1), 3)
    profile = [(0.0, 0.0), (0.0, 50.0), (5.0, 50.0), (5.0, 12.0)]
    profile += [(12 - 7 * np.cos(a), 12 - 7 * np.sin(a)) for a in np.radians([15, 30, 45, 60, 75])]
    profile += [(12.0, 5.0), (50.0, 5.0), (50.0, 0.0)]
    angle = plate([(150 + a, 0, b) for a, b in profile], (0, 200, 0))
    members = [
        Member("bracket sheet 3 mm", body, STEEL, "bent sheet", welded=False),
        Member("L 50 x 5", angle, DARK, "rolled angle, loose", welded=False),
    ]
    return Part("bent-sheet", "bent bracket and a loose rolled angle", members, [])
