"""The welds round the end of a square tube that stands on an equal one, flush with it on two sides."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from tests.benchmarks.welds.lists import OPTIONAL, PROBABLE, SURE, Weld, arc, line

DEEPER_MM = 0.5
"""A flare-bevel groove lies between the flush plane and the depth of the corner radius; so much is added to that."""


@dataclass(frozen=True, slots=True)
class Tube:
    """A square tube: its side and the radius of its edges, mm."""

    side: float
    radius: float

    @property
    def flare_tol_mm(self) -> float:
        return self.radius + DEEPER_MM


def tube_end(
    members: tuple[str, str],
    corner: Sequence[float],
    u: Sequence[float],
    v: Sequence[float],
    out: Sequence[float],
    *,
    tube: Tube,
    flush_low: bool = False,
    flush_high: bool = False,
) -> Iterator[Weld]:
    """Yield the welds round an end.

    u runs along the other tube, v across it: across, both tubes are flush and meet on their radii. At an end of the
    other tube the side across u is flush with its open end. `out` is the axis of the tube that ends here.
    """
    c, eu, ev, n = (np.array(a, dtype=float) for a in (corner, u, v, out))
    where, side, radius = " ".join(members), tube.side, tube.radius

    def at(a: float, b: float) -> list[float]:
        point: list[float] = (c + a * eu + b * ev).tolist()
        return point

    for a, flush in ((0.0, flush_low), (side, flush_high)):
        points = line(at(a, radius), at(a, side - radius))
        kind, cls = ("flush with the open end of the other tube", PROBABLE) if flush else ("tee fillet", SURE)
        yield Weld(f"{where} across {a:g}", members, kind, cls, points)
    for b, way_v in ((0.0, -1.0), (side, 1.0)):
        points = line(at(radius, b), at(side - radius, b))
        yield Weld(f"{where} flush {b:g}", members, "flare bevel, flush sides", PROBABLE, points, tube.flare_tol_mm)
        for a, way_u in ((radius, -1.0), (side - radius, 1.0)):
            turn = -90.0 * way_u * way_v * float(np.sign(np.cross(eu, ev) @ n))
            points = arc(at(a, b - way_v * radius), n, way_v * ev, radius, turn)
            yield Weld(f"{where} corner {a:g} {b:g}", members, "round the corner", OPTIONAL, points, tube.flare_tol_mm)
