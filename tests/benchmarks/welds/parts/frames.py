"""Frames of tubes and profiles."""

import numpy as np
from build123d import Pos

from tests.benchmarks.welds.lists import OPTIONAL, PROBABLE, SURE, Weld, arc, circle, line
from tests.benchmarks.welds.parts.part import Member, Part, straight
from tests.benchmarks.welds.parts.shapes import (
    BLACK,
    BRIGHT,
    DARK,
    STEEL,
    WOOD,
    block,
    pipe,
    plate,
    rod,
    rolled,
    turned,
)
from tests.benchmarks.welds.parts.tubes import Tube, tube_end

TUBE = Tube(side=40.0, radius=6.0)


def rounded_frame() -> Part:
    """Return a frame of square tubes 40 x 3 with rounded corners, flush, with a post on it."""
    tube = {"wall": 3.0, "radius": TUBE.radius}
    members = [
        Member(
            "rail front", rolled((0, 0, 0), (500, 40, 40), "x", **tube), STEEL, "square tube 40 x 3, corner radius 6"
        ),
        Member("rail back", rolled((0, 360, 0), (500, 400, 40), "x", **tube), STEEL, "square tube 40 x 3"),
        Member("cross end", rolled((0, 40, 0), (40, 360, 40), "y", **tube), DARK, "square tube 40 x 3"),
        Member("cross middle", rolled((230, 40, 0), (270, 360, 40), "y", **tube), DARK, "square tube 40 x 3"),
        Member("post", rolled((460, 0, 40), (500, 40, 240), "z", **tube), DARK, "square tube 40 x 3"),
    ]
    welds: list[Weld] = []
    for cross, x in (("cross end", 0.0), ("cross middle", 230.0)):
        for rail, y, way in (("rail front", 40.0, 1.0), ("rail back", 360.0, -1.0)):
            welds += tube_end(
                (cross, rail), (x, y, 0.0), (1, 0, 0), (0, 0, 1), (0, way, 0), tube=TUBE, flush_low=x == 0.0
            )
    welds += tube_end(("post", "rail front"), (460, 0, 40), (1, 0, 0), (0, 1, 0), (0, 0, 1), tube=TUBE, flush_high=True)
    return Part(
        "rounded-frame", "flat frame of rounded square tube with a post; flush sides are flare-bevel", members, welds
    )


def railing() -> Part:
    """Return a railing of round tubes, coped, on plates that are anchored to concrete."""
    post, rail, middle = 21.2, 21.2, 16.85
    top = rod(rail, (-100, 0, 500), (1, 0, 0), 800)
    members = [Member("handrail", pipe(rail, 2.6, (-100, 0, 500), (1, 0, 0), 800), STEEL, "round tube 42.4 x 2.6")]
    welds = []
    posts = []
    for x, side in ((0.0, "left"), (600.0, "right")):
        shape = pipe(post, 2.6, (x, 0, 0), (0, 0, 1), 500) - top
        posts.append(rod(post, (x, 0, 0), (0, 0, 1), 500))
        members.append(Member(f"post {side}", shape, DARK, "round tube 42.4 x 2.6, coped at the top"))
        base = block((x - 50, -50, -10), (x + 50, 50, 0))
        for k in range(4):
            a = np.radians(45 + 90 * k)
            hole = (x + 50 * np.cos(a), 50 * np.sin(a))
            base -= rod(5.5, (*hole, -10), (0, 0, 1), 10)
            bolt = rod(5.0, (*hole, -60), (0, 0, 1), 80) + rod(9.0, (*hole, 0), (0, 0, 1), 2)
            bolt += plate(
                [(hole[0] + 9.2 * np.cos(t), hole[1] + 9.2 * np.sin(t), 2) for t in np.radians(range(0, 360, 60))],
                (0, 0, 8),
            )
            members.append(
                Member(f"anchor bolt M10 {side} {k + 1}", bolt, BRIGHT, "anchor with washer and nut", welded=False)
            )
        members.append(Member(f"base plate {side}", base, STEEL, "plate 100 x 100 x 10 with 4 holes of 11 mm"))
        welds.append(
            Weld(
                f"post {side} on plate",
                (f"post {side}", f"base plate {side}"),
                "tee fillet round a tube",
                SURE,
                circle((x, 0, 0), (0, 0, 1), post),
            )
        )
        t = np.radians(np.linspace(0, 360, 181))
        cope = np.column_stack([x + post * np.cos(t), post * np.sin(t), 500 - post * np.abs(np.cos(t))])
        cope[-1] = cope[0]
        welds.append(
            Weld(f"handrail on post {side}", ("handrail", f"post {side}"), "coped tube, equal diameters", SURE, cope)
        )
    members.append(
        Member(
            "middle rail",
            pipe(middle, 2.6, (0, 0, 250), (1, 0, 0), 600) - posts[0] - posts[1],
            DARK,
            "round tube 33.7 x 2.6, coped at both ends",
        )
    )
    t = np.radians(np.linspace(0, 360, 181))
    y = middle * np.cos(t)
    for x, way, side in ((0.0, 1.0, "left"), (600.0, -1.0, "right")):
        cope = np.column_stack([x + way * np.sqrt(post**2 - y**2), y, 250 + middle * np.sin(t)])
        cope[-1] = cope[0]
        welds.append(
            Weld(f"middle rail on post {side}", ("middle rail", f"post {side}"), "coped tube on tube", SURE, cope)
        )
    return Part("railing", "handrail of coped round tubes; base plates with anchor bolts", members, welds)


def lap_ladder() -> Part:
    """Return two flat bars with four flat rungs lapped on top, 60 mm clear between them."""
    members = [
        Member("bar 1", block((0, 0, 0), (500, 50, 8)), STEEL, "flat bar 50 x 8"),
        Member("bar 2", block((0, 200, 0), (500, 250, 8)), STEEL, "flat bar 50 x 8"),
    ]
    welds = []
    for k in range(4):
        low = 70.0 + 100 * k
        high, rung = low + 40, f"rung {k + 1}"
        members.append(Member(rung, block((low, 10, 8), (high, 240, 14)), DARK, "flat bar 40 x 6"))
        for bar, inner, outer in (("bar 1", 50, 10), ("bar 2", 200, 240)):
            pair = (rung, bar)
            welds += [
                Weld(f"{rung} {bar} x {x:g}", pair, "lap fillet", SURE, line((x, outer, 8), (x, inner, 8)))
                for x in (low, high)
            ]
            welds.append(
                Weld(f"{rung} {bar} end", pair, "lap fillet at the end", SURE, line((low, outer, 8), (high, outer, 8)))
            )
            under = line((low, inner, 8), (high, inner, 8))
            welds.append(Weld(f"{rung} {bar} below", pair, "lap fillet from below", OPTIONAL, under))
    return Part("lap-ladder", "flat bars lapped on flat bars with 60 mm between them", members, welds)


CORNERS = ((0, 0), (600, 0), (600, 400), (0, 400))  #: Outer corners of the frame with the board, mm.


def board_frame() -> Part:
    """Return a mitred frame of rolled angles 40 x 4 with a plywood board that lies in it, held by screws."""
    profile = [(0.0, 0.0), (0.0, 40.0), (4.0, 40.0), (4.0, 10.0)]
    profile += [(10 - 6 * np.cos(t), 10 - 6 * np.sin(t)) for t in np.radians([15, 30, 45, 60, 75])]
    profile += [(10.0, 4.0), (40.0, 4.0), (40.0, 0.0)]
    members = []
    for k, name in enumerate(("angle front", "angle right", "angle back", "angle left")):
        shape = plate([(-1, a, b) for a, b in profile], ((600.0, 400.0)[k % 2] + 2, 0, 0))
        for x, way in ((0.0, 1.0), ((600.0, 400.0)[k % 2], -1.0)):
            corners = [(x - way * 50, -1, -1), (x - way * 1, -1, -1), (x + way * 60, 60, -1), (x - way * 50, 60, -1)]
            shape -= plate(corners, (0, 0, 60))
        shape = Pos(*CORNERS[k], 0) * turned(shape, 90 * k)
        members.append(Member(name, shape, (STEEL, DARK)[k % 2], "rolled angle 40 x 4, mitred"))
    names = [member.name for member in members]
    board = Member("plywood board 15 mm", block((12, 12, 4), (588, 388, 19)), WOOD, "wood, lies loose", welded=False)
    screws = []
    for k, (x, y) in enumerate(((300, 25), (575, 200), (300, 375), (25, 200))):
        screw = rod(2.0, (x, y, 0), (0, 0, 1), 18) + rod(4.0, (x, y, -2), (0, 0, 1), 2)
        screws.append(Member(f"DIN 97 4 x 20 {k + 1}", screw, BRIGHT, "wood screw", welded=False))
        members[k] = members[k].without(rod(2.5, (x, y, -1), (0, 0, 1), 6))
        board = board.without(rod(2.0, (x, y, 3), (0, 0, 1), 15))
    welds = [weld for k in range(4) for weld in _mitred_corner(k, (names[k - 1], names[k]))]
    about = "angle frame with a wooden board: only the steel is welded"
    return Part("board-frame", about, [*members, board, *screws], welds)


def _mitred_corner(k: int, pair: tuple[str, str]) -> list[Weld]:
    """Return the welds of one corner of the frame with the board."""
    (x, y), (a, b) = CORNERS[k], ((1, 1), (-1, 1), (-1, -1), (1, -1))[k]

    def inside(by: float, z: float) -> tuple[float, float, float]:
        return (x + by * a, y + by * b, z)

    name = f"corner {k + 1}"
    return straight(
        pair,
        (f"{name} outside", "corner butt", SURE, (x, y, 0), (x, y, 40)),
        (f"{name} mitre below", "mitre butt", PROBABLE, (x, y, 0), inside(40, 0)),
        (f"{name} inside", "inner corner above the board", OPTIONAL, inside(4, 10), inside(4, 40)),
        (f"{name} mitre above", "mitre butt under the board", OPTIONAL, inside(10, 4), inside(40, 4)),
        (f"{name} top", "mitre on the thin edge", OPTIONAL, (x, y, 40), inside(4, 40)),
    )


def _channel(
    length: float, height: float, flange: float, web: float, thick: float, root: float
) -> list[tuple[float, float]]:
    """Return the outline of a channel in (across, up): back of the web at 0, toes at -flange, rounded roots."""
    half, inner = height / 2, height / 2 - thick
    low = [
        (-web - root + root * np.cos(t), -inner + root - root * np.sin(t))
        for t in np.radians([90, 75, 60, 45, 30, 15, 0])
    ]
    high = [(x, -z) for x, z in low]
    toe, sole = [(-flange, half), (-flange, inner)], [(-flange, -inner), (-flange, -half)]
    return [(0, -half), (0, half), *toe, *high, *low[::-1], *sole][::-1]


def channel_cross() -> Part:
    """Return two lower channels butted against the web of a channel."""
    main = plate([(0, a, b) for a, b in _channel(600, 100, 50, 6, 8, 8)], (600, 0, 0))
    members = [Member("channel 100", main, STEEL, "rolled channel 100 x 50 with root radius 8")]
    welds = []
    for x, name in ((100.0, "cross 1"), (400.0, "cross 2")):
        outline = _channel(250, 80, 45, 6, 7, 7)
        shape = plate([(x - a, 0, b) for a, b in outline], (0, 250, 0))
        members.append(Member(name, shape, DARK, "rolled channel 80 x 45"))
        pair = (name, "channel 100")
        welds.append(
            Weld(f"{name} back", pair, "tee fillet on the back of the web", SURE, line((x, 0, -40), (x, 0, 40)))
        )
        for z, side in ((40.0, "top"), (-40.0, "bottom")):
            welds.append(
                Weld(f"{name} {side}", pair, "tee fillet along the flange", SURE, line((x, 0, z), (x + 45, 0, z)))
            )
            welds.append(
                Weld(
                    f"{name} {side} toe",
                    pair,
                    "wrap round the toe",
                    OPTIONAL,
                    line((x + 45, 0, z), (x + 45, 0, z - np.sign(z) * 7)),
                )
            )
        inside = [(x - a, 0.0, b) for a, b in outline if a < 0 and abs(b) < 36]
        inside.sort(key=lambda p: p[2])
        welds.append(Weld(f"{name} inside", pair, "inside of the channel", OPTIONAL, line(*inside), 3.0))
    return Part("channel-cross", "channels with rounded roots butted against a web", members, welds)


def bolted_post() -> Part:
    """Return a post of rounded tube on a foot plate with a rim of gussets, and a foot plate bolted below it."""
    members = [
        Member("foot plate", block((-70, -70, -10), (70, 70, 0)), STEEL, "plate 140 x 140 x 10 with 4 bolt holes"),
        Member("post", rolled((-25, -25, 0), (25, 25, 250), "z", wall=4.0, radius=8.0), DARK, "square tube 50 x 4"),
        Member(
            "lower plate", block((-70, -70, -20), (70, 70, -10)), STEEL, "plate bolted to the foot plate", welded=False
        ),
    ]
    for k in range(4):
        a = np.radians(45 + 90 * k)
        x, y = 80 * np.cos(a), 80 * np.sin(a)
        for row in (0, 2):
            old = members[row]
            members[row] = Member(
                old.name, old.shape - rod(5.5, (x, y, -21), (0, 0, 1), 22), old.color, old.what, welded=old.welded
            )
        hexagon = [(x + 9.2 * np.cos(t), y + 9.2 * np.sin(t), 0) for t in np.radians(range(0, 360, 60))]
        screw = rod(5, (x, y, -28), (0, 0, 1), 28) + plate(hexagon, (0, 0, 6.4))
        members.append(Member(f"ISO 4017 M10 x 30 {k + 1}", screw, BRIGHT, "hexagon screw", welded=False))
        nut = plate([(px, py, -28) for px, py, _ in hexagon], (0, 0, 8)) - rod(5, (x, y, -28), (0, 0, 1), 8)
        members.append(Member(f"ISO 4032 M10 {k + 1}", nut, BLACK, "hexagon nut", welded=False))
    outline = [
        arc((sx * 17, sy * 17, 0), (0, 0, 1), start, 8, 90)
        for sx, sy, start in ((1, -1, (0, -1, 0)), (1, 1, (1, 0, 0)), (-1, 1, (0, 1, 0)), (-1, -1, (-1, 0, 0)))
    ]
    ring = np.vstack([*outline, outline[0][:1]])
    welds = [Weld("post on foot plate", ("post", "foot plate"), "tee fillet round a tube", SURE, ring)]
    return Part("bolted-post", "post welded on a foot plate that is bolted to another plate", members, welds)
