"""Pipes, vessels and rods."""

import numpy as np
from build123d import Align, Pos, Rot, Torus

from tests.benchmarks.welds.lists import OPTIONAL, PROBABLE, SURE, Weld, circle, line, turned_z
from tests.benchmarks.welds.parts.part import Member, Part
from tests.benchmarks.welds.parts.shapes import BRIGHT, DARK, STEEL, block, pipe, plate, rod, turned
from wpcal.core.arrays import FloatArray


def pipe_stand() -> Part:
    """Return a pipe on a foot plate with a fit-up gap of 0.8 mm, four gussets with snipes, and a head plate."""
    radius, gap, half = 44.45, 0.8, 3.0
    foot = block((-80, -80, -12), (80, 80, 0))
    for k in range(4):
        foot -= turned(rod(7, (92, 0, -12), (0, 0, 1), 12), 45 + 90 * k)
    members = [
        Member("foot plate", foot, STEEL, "plate 160 x 160 x 12 with 4 holes of 14 mm"),
        Member("pipe", pipe(radius, 4, (0, 0, gap), (0, 0, 1), 300 - gap), DARK, "pipe 88.9 x 4"),
        Member("head plate", block((-60, -60, 300), (60, 60, 308)), STEEL, "plate 120 x 120 x 8"),
    ]
    welds = [
        Weld(
            "pipe on foot plate",
            ("pipe", "foot plate"),
            "tee fillet round a pipe, gap 0.8",
            SURE,
            circle((0, 0, 0), (0, 0, 1), radius),
        ),
        Weld(
            "pipe under head plate",
            ("pipe", "head plate"),
            "tee fillet round a pipe",
            SURE,
            circle((0, 0, 300), (0, 0, 1), radius),
        ),
    ]
    reach = 44.95
    profile = [(reach, 15.0), (reach, 80.0), (52.0, 80.0), (76.0, 10.0), (76.0, 0.0), (reach + 15, 0.0)]
    on_pipe = float(np.sqrt(radius**2 - half**2))
    for k in range(4):
        name = f"gusset {k + 1}"
        shape = plate([(x, -half, z) for x, z in profile], (0, 2 * half, 0))
        members.append(
            Member(name, turned(shape, 90 * k), STEEL, "plate 6 mm, 0.5 mm off the pipe, with a snipe of 15 mm")
        )
        for y, side in ((-half, "a"), (half, "b")):
            low = turned_z(line((reach + 15, y, 0), (76, y, 0)), 90 * k)
            high = turned_z(line((on_pipe, y, 15), (on_pipe, y, 80)), 90 * k)
            welds.append(Weld(f"{name} foot {side}", (name, "foot plate"), "tee fillet", SURE, low))
            welds.append(
                Weld(f"{name} pipe {side}", (name, "pipe"), "fillet of a gusset along a pipe, gap 0.5", SURE, high)
            )
        ends = (
            ("outside", 76.0, 0.0, "foot plate"),
            ("snipe", reach + 15, 0.0, "foot plate"),
            ("top", radius, 80.0, "pipe"),
            ("snipe pipe", radius, 15.0, "pipe"),
        )
        for end, x, z, other in ends:
            points = turned_z(line((x, -half, z), (x, half, z)), 90 * k)
            welds.append(Weld(f"{name} {end}", (name, other), "wrap round the end", OPTIONAL, points))
    return Part("pipe-stand", "pipe with fit-up gap, gussets with snipes, head plate", members, welds)


def nozzle() -> Part:
    """Return a nozzle set into a shell, with a reinforcing pad and a slip-on flange."""
    shell, wall, r, bore = 200.0, 8.0, 44.45, 44.95
    pad = rod(80, (0, 0, 0), (0, 0, 1), 260) - rod(bore, (0, 0, 0), (0, 0, 1), 260)
    pad = (pad & rod(shell + 6, (-150, 0, 0), (1, 0, 0), 300)) - rod(shell, (-150, 0, 0), (1, 0, 0), 300)
    pad = max(pad.solids(), key=lambda s: s.center().Z)
    neck = pipe(r, 5.5, (0, 0, 150), (0, 0, 1), 150)
    flange = rod(100, (0, 0, 285), (0, 0, 1), 20) - rod(45.0, (0, 0, 285), (0, 0, 1), 20)
    for k in range(8):
        flange -= turned(rod(9, (80, 0, 285), (0, 0, 1), 20), 22.5 + 45 * k)
    drum = pipe(shell, wall, (-200, 0, 0), (1, 0, 0), 400) - rod(bore, (0, 0, 0), (0, 0, 1), 260)
    members = [
        Member("shell", drum, STEEL, "shell of 400 x 8 with a hole of 89.9"),
        Member("pad", pad, DARK, "reinforcing ring 6 mm, rolled to the shell"),
        Member("neck", neck, STEEL, "pipe 88.9 x 5.5, set into the shell"),
        Member("flange", flange, DARK, "slip-on flange, bore 90, 8 holes of 18 mm"),
    ]
    welds = [
        Weld("neck on pad", ("neck", "pad"), "fillet round a set-in nozzle", SURE, _on_drum(r, shell + 6)),
        Weld("pad on shell", ("pad", "shell"), "lap fillet on a cylinder", SURE, _on_drum(80, shell)),
        Weld("neck inside shell", ("neck", "shell"), "fillet inside the vessel", PROBABLE, _on_drum(r, shell - wall)),
        Weld(
            "flange back", ("neck", "flange"), "fillet behind a slip-on flange", SURE, circle((0, 0, 285), (0, 0, 1), r)
        ),
        Weld(
            "flange face",
            ("neck", "flange"),
            "fillet at the recessed end of the pipe",
            SURE,
            circle((0, 0, 300), (0, 0, 1), r),
        ),
    ]
    return Part("nozzle", "nozzle with reinforcing pad and slip-on flange on a shell", members, welds)


def _on_drum(radius: float, drum: float) -> FloatArray:
    """Return where a cylinder about z meets one about x, above, shape (n, 3)."""
    t = np.radians(np.linspace(0, 360, 121))
    x, y = radius * np.cos(t), radius * np.sin(t)
    points: FloatArray = np.column_stack([x, y, np.sqrt(drum**2 - y**2)])
    points[-1] = points[0]
    return points


def rods_in_plate() -> Part:
    """Return a lifting eye (a bent rod through a plate), and a pin that is set flush into it."""
    bow = Pos(0, 0, 60) * Rot(90, 0, 0) * Torus(40, 6, align=(Align.CENTER,) * 3)
    bow = bow & block((-60, -60, 60), (60, 60, 160))
    eye = bow + rod(6, (-40, 0, -6), (0, 0, 1), 66) + rod(6, (40, 0, -6), (0, 0, 1), 66)
    base = block((-100, -60, 0), (100, 60, 10))
    base -= (
        rod(6.3, (-40, 0, 0), (0, 0, 1), 10) + rod(6.3, (40, 0, 0), (0, 0, 1), 10) + rod(8, (75, 35, 0), (0, 0, 1), 10)
    )
    members = [
        Member("plate", base, STEEL, "plate 200 x 120 x 10"),
        Member("eye", eye, DARK, "round bar 12, bent, in holes of 12.6"),
        Member("pin", rod(8, (75, 35, 0), (0, 0, 1), 50), BRIGHT, "round bar 16, flush below"),
    ]
    welds = []
    for x, side in ((-40.0, "left"), (40.0, "right")):
        pair = ("eye", "plate")
        welds.append(Weld(f"eye {side} above", pair, "fillet round a bar", SURE, circle((x, 0, 10), (0, 0, 1), 6)))
        welds.append(
            Weld(
                f"eye {side} below",
                pair,
                "fillet round a bar that sticks out 6 mm",
                PROBABLE,
                circle((x, 0, 0), (0, 0, 1), 6),
            )
        )
    welds.append(Weld("pin above", ("pin", "plate"), "fillet round a bar", SURE, circle((75, 35, 10), (0, 0, 1), 8)))
    welds.append(Weld("pin below", ("pin", "plate"), "flush plug", PROBABLE, circle((75, 35, 0), (0, 0, 1), 8)))
    return Part("rods-in-plate", "bent bar through a plate with 0.3 mm play, and a flush pin", members, welds)


def half_ring() -> Part:
    """Return a half ring of pipe that carries a pipe, on two legs of flat bar; the carried pipe lies loose in it."""
    radius = 60.3 / 2
    ring = pipe(radius + 5, 5, (-30, 0, 100), (1, 0, 0), 60) - block((-40, -60, 100), (40, 60, 160))
    web = (
        block((-5, -35, 0), (5, 35, 100))
        - rod(radius + 5, (-40, 0, 100), (1, 0, 0), 80)
        - block((-40, -60, 90), (40, 60, 160))
    )
    members = [
        Member("foot", block((-50, -60, -10), (50, 60, 0)), STEEL, "plate 100 x 120 x 10"),
        Member("web", web, DARK, "plate 10 mm, cut to the ring"),
        Member("half ring", ring, STEEL, "half of a pipe 70.3 x 5"),
        Member(
            "PTFE liner",
            (pipe(radius, 0.8, (-30, 0, 100), (1, 0, 0), 60) - block((-40, -60, 100), (40, 60, 160))),
            BRIGHT,
            "plastic sheet, lies loose",
            welded=False,
        ),
    ]
    outer = radius + 5
    end = float(np.degrees(np.arccos(10 / outer)))
    welds = []
    t = np.radians(np.linspace(-90 - end, -90 + end, 41))
    t = t[np.abs(outer * np.cos(t)) <= 35]
    for x, side in ((-5.0, "a"), (5.0, "b")):
        welds.append(Weld(f"web on foot {side}", ("web", "foot"), "tee fillet", SURE, line((x, -35, 0), (x, 35, 0))))
        bow = np.column_stack([np.full(len(t), x), outer * np.cos(t), 100 + outer * np.sin(t)])
        welds.append(Weld(f"web on ring {side}", ("web", "half ring"), "fillet along the outside of a ring", SURE, bow))
    for y in (-35.0, 35.0):
        welds.append(
            Weld(f"web end {y:g}", ("web", "foot"), "wrap round the end", OPTIONAL, line((-5, y, 0), (5, y, 0)))
        )
        z = 100 - float(np.sqrt(max(outer**2 - y**2, 0.0)))
        z = max(z, 0.0) if abs(y) < outer else 100.0
        top = 90.0 if z > 90 else z
        at = float(np.sqrt(outer**2 - (100 - top) ** 2))
        welds.append(
            Weld(
                f"ring end {y:g}",
                ("web", "half ring"),
                "wrap round the end",
                OPTIONAL,
                line((-5, np.sign(y) * at, top), (5, np.sign(y) * at, top)),
            )
        )
    return Part("half-ring", "half ring on a web; a plastic liner lies in it", members, welds)


def k_joint() -> Part:
    """Return two inclined round tubes, coped, on a round chord: a K joint with a gap between them."""
    chord_r, brace_r, lean = 38.05, 24.15, np.radians(50.0)
    chord = rod(chord_r, (-300, 0, 0), (1, 0, 0), 600)
    members = [Member("chord", pipe(chord_r, 4, (-300, 0, 0), (1, 0, 0), 600), STEEL, "round tube 76.1 x 4")]
    welds = []
    for way, name in ((1.0, "brace right"), (-1.0, "brace left")):
        axis = np.array([way * np.cos(lean), 0, np.sin(lean)])
        foot = np.array([way * 45.0, 0, 0])
        brace = pipe(brace_r, 3.2, tuple(foot), tuple(axis), 260) - chord
        brace = max(brace.solids(), key=lambda s: s.volume)
        members.append(Member(name, brace, DARK, "round tube 48.3 x 3.2, coped"))
        across = np.array([0.0, 1, 0])
        up = np.cross(axis, across)
        t = np.radians(np.linspace(0, 360, 181))[:, None]
        ring = foot + brace_r * (np.cos(t) * across + np.sin(t) * up)
        z = np.sqrt(chord_r**2 - ring[:, 1] ** 2)
        points = ring + ((z - ring[:, 2]) / axis[2])[:, None] * axis
        points[-1] = points[0]
        welds.append(Weld(f"{name} on chord", (name, "chord"), "coped tube on tube, 50 degrees", SURE, points))
    return Part("k-joint", "two inclined round tubes on a chord", members, welds)
