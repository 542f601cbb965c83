"""Tubes with rounded edges and round bars side by side: parts with flare grooves that anybody can compute."""

import math
from typing import Any

from cad.kernel.modelling import fused
from cad.kernel.primitives import box, cut, cylinder, ring, square_tube

Solids = list[tuple[str, Any]]

SIDE_MM = 80.0  #: Outer side of the square tubes.


def flush_tubes(radius: float, wall: float, *, offset: float = 0.0) -> Solids:
    """Return a post along z and a rail along x that ends on it, their front sides flush or the rail's set back, mm."""
    post = square_tube(SIDE_MM, 300.0, (0.0, 0.0, 0.0), "z", wall=wall, corner_radius=radius)
    rail = square_tube(SIDE_MM, 200.0, (SIDE_MM, offset, 100.0), "x", wall=wall, corner_radius=radius)
    return [("post", post), ("rail", rail)]


def tubes_side_by_side(radius: float, gap: float) -> Solids:
    """Return two square tubes along x, the second one longer at both ends."""
    first = square_tube(SIDE_MM, 200.0, (0.0, -SIDE_MM, 0.0), "x", wall=3.0, corner_radius=radius)
    second = square_tube(SIDE_MM, 260.0, (-30.0, gap, 0.0), "x", wall=3.0, corner_radius=radius)
    return [("first", first), ("second", second)]


def bar_on_plate(radius: float, gap: float) -> Solids:
    """Return a round bar of 120 mm along x above the middle of a plate whose top is z = 0."""
    plate = box(200.0, 200.0, 10.0, (-40.0, -100.0, -10.0))
    return [("plate", plate), ("bar", cylinder(radius, 120.0, (0.0, 0.0, radius + gap), (1.0, 0.0, 0.0)))]


def round_tubes(first: float, second: float) -> Solids:
    """Return two round tubes along x that touch along a line; the axis of the second one is above that of the first."""
    solids = []
    for name, radius, low, start in (("lower", first, 0.0, 0.0), ("upper", second, first + second, 20.0)):
        tube = cylinder(radius, 150.0, (start, 0.0, low), (1.0, 0.0, 0.0))
        solids.append((name, cut(tube, cylinder(radius - 3.0, 150.0, (start, 0.0, low), (1.0, 0.0, 0.0)))))
    return solids


def half_ring_on_plate(radius: float, bar: float) -> Solids:
    """Return half a ring of a round bar that lies on a plate whose top is z = 0."""
    plate = box(200.0, 200.0, 10.0, (-100.0, -100.0, -10.0))
    return [("plate", plate), ("ring", ring(radius, bar, (0.0, 0.0, bar), turn=math.pi))]


def u_bar_on_plate() -> Solids:
    """Return a bar of 12 mm that is bent to a U with legs of 60 mm, on a plate whose top is z = 0."""
    legs = [cylinder(6.0, 60.0, (x, 0.0, 6.0), (0.0, -1.0, 0.0)) for x in (-40.0, 40.0)]
    bar = half_ring_on_plate(40.0, 6.0)[1][1]
    for leg in legs:
        bar = fused(bar, leg, unified=False)
    return [half_ring_on_plate(40.0, 6.0)[0], ("bar", bar)]


def ring_round_a_pipe() -> Solids:
    """Return a pipe of 60 mm along z with a ring of an 8 mm bar tightly round it, at z = 50."""
    pipe = cut(cylinder(30.0, 100.0, (0, 0, 0), (0, 0, 1)), cylinder(27.0, 100.0, (0, 0, 0), (0, 0, 1)))
    return [("pipe", pipe), ("ring", ring(34.0, 4.0, (0.0, 0.0, 50.0)))]


def rising_bar(slope: float) -> Solids:
    """Return a bar of 20 mm that leaves the top of a plate, z = 0, at a slope (rad)."""
    bar = cylinder(10.0, 200.0, (0.0, 0.0, 10.0), (math.cos(slope), 0.0, math.sin(slope)))
    return [("plate", box(300.0, 200.0, 10.0, (-40.0, -100.0, -10.0))), ("bar", bar)]


def plate_along_pipe(radius: float, thickness: float) -> Solids:
    """Return a pipe along x and a plate that stands with its straight edge on top of the pipe, y = 0 in its middle."""
    pipe = cut(cylinder(radius, 300.0, (-50, 0, 0), (1, 0, 0)), cylinder(radius - 3.0, 300.0, (-50, 0, 0), (1, 0, 0)))
    return [("pipe", pipe), ("plate", box(200.0, thickness, 80.0, (0.0, -thickness / 2, radius)))]


def rack_of_bars(count: int) -> Solids:
    """Return round bars of 20 mm side by side on a plate, along x."""
    bars = [cylinder(10.0, 200.0, (0.0, 20.0 * k, 10.0), (1.0, 0.0, 0.0)) for k in range(count)]
    return [("plate", box(240.0, 300.0, 10.0, (-20.0, -100.0, -10.0))), *((f"bar {k}", b) for k, b in enumerate(bars))]


def roller_bearing() -> Solids:
    """Return two rings and twelve rollers of 10 mm between them."""
    inner = cut(cylinder(30.0, 20.0, (0, 0, 0), (0, 0, 1)), cylinder(20.0, 20.0, (0, 0, 0), (0, 0, 1)))
    outer = cut(cylinder(50.0, 20.0, (0, 0, 0), (0, 0, 1)), cylinder(40.0, 20.0, (0, 0, 0), (0, 0, 1)))
    at = [(35.0 * math.cos(turn), 35.0 * math.sin(turn), 0.0) for turn in (k * math.pi / 6 for k in range(12))]
    rollers = [cylinder(5.0, 20.0, place, (0.0, 0.0, 1.0)) for place in at]
    return [("inner", inner), ("outer", outer), *((f"roller {k}", roller) for k, roller in enumerate(rollers))]


def wheel_on_rail() -> Solids:
    """Return a wheel of 80 mm with its shaft on a flat rail."""
    shaft = cylinder(10.0, 80.0, (0.0, -25.0, 40.0), (0.0, 1.0, 0.0))
    wheel = cut(cylinder(40.0, 30.0, (0.0, 0.0, 40.0), (0.0, 1.0, 0.0)), shaft)
    return [("rail", box(300.0, 60.0, 10.0, (-150.0, -15.0, -10.0))), ("wheel", wheel), ("shaft", shaft)]
