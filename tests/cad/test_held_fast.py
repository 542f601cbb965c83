"""A ring between two shoulders was stretched or snapped on; a ring that slides onto its seat is welded."""

from collections.abc import Callable
from typing import Any

import pytest
from build123d import Align, Cylinder, Pos, Rot

from cad.kernel.to_brep import to_brep
from wpcal.brep.trim import TrimmedFaces
from wpcal.seam import SeamOptions, detect_seams
from wpcal.seam.judge.held_fast import is_held_fast
from wpcal.seam.limits import Level
from wpcal.seam.options import Judging
from wpcal.seam.rules import Rule

Made = Callable[[], tuple[Any, Any]]
LOW = (Align.CENTER, Align.CENTER, Align.MIN)


def tube(outer: float, inner: float, low: float, high: float) -> Any:
    return Pos(0, 0, low) * (Cylinder(outer, high - low, align=LOW) - Cylinder(inner, high - low, align=LOW))


def rim(*lips: float) -> Any:
    """Return a wheel rim of radius 100 with lips of radius 112 at heights."""
    body = tube(100, 92, 0, 120)
    for low in lips:
        body += tube(112, 92, low, low + 10)
    return body


def housing() -> Any:
    """Return a block with a groove in its bore."""
    return Cylinder(60, 50, align=LOW) - Cylinder(30, 50, align=LOW) - Pos(0, 0, 20) * Cylinder(36, 8, align=LOW)


HELD: dict[str, Made] = {
    "a tyre on a rim": lambda: (rim(0, 110), tube(140, 100, 10, 110)),
    "a tyre modelled into its rim": lambda: (rim(0, 110), tube(140, 100, 4, 116)),
    "a seal in the groove of a bore": lambda: (housing(), tube(36, 32, 20, 28)),
}
SLID_ON: dict[str, Made] = {
    "a ring at the collar of a tube": lambda: (rim(110), tube(140, 100, 10, 110)),
    "a flange at the end of a tube": lambda: (rim(), tube(160, 100, 0, 16)),
    "a bush in a stepped bore": lambda: (housing() - Pos(0, 0, 20) * Cylinder(36, 40, align=LOW), tube(36, 32, 20, 28)),
}


def graph_of(made: Made) -> Any:
    turned = [(name, (Rot(20, 35, 0) * shape).solid().wrapped) for name, shape in zip("ab", made(), strict=True)]
    return to_brep(turned)


@pytest.mark.parametrize("name", [*HELD, *SLID_ON])
def test_a_ring_between_shoulders_is_held_and_one_that_slides_onto_its_seat_is_not(name: str) -> None:
    graph = graph_of({**HELD, **SLID_ON}[name])
    assert is_held_fast(graph, TrimmedFaces.of(graph), 1, 0, 0.5) == (name in HELD)


def test_a_tyre_is_a_candidate_that_generous_takes_and_a_ring_at_a_collar_is_welded() -> None:
    tyre = graph_of(HELD["a tyre on a rim"])
    seams = detect_seams(tyre)
    assert seams
    assert not any(seam.accepted for seam in seams)
    assert {one.rule for seam in seams for one in seam.findings} >= {Rule.HELD_FAST.key}
    assert any(s.accepted for s in detect_seams(tyre, SeamOptions(judging=Judging(level=Level.GENEROUS))))
    assert any(seam.accepted for seam in detect_seams(graph_of(SLID_ON["a ring at the collar of a tube"])))
