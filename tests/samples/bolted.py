"""Small parts with members that are bolted, and others that only look so. No bolt is in the file unless said."""

from collections.abc import Callable, Sequence
from typing import Any

from cad.kernel.modelling import fused
from cad.kernel.primitives import box, cut, cylinder

UP = (0.0, 0.0, 1.0)
ALONG_Y = (0.0, 1.0, 0.0)
Solids = list[tuple[str, Any]]  #: Names and kernel solids.


def _hole(x: float, y: float, diameter: float = 11.0) -> Any:
    return cylinder(diameter / 2, 100, (x, y, -50), UP)


def _slot(x: float, y: float) -> Any:
    """Return a slot 11 x 31 mm along x."""
    middle = box(20, 11, 100, (x - 10, y - 5.5, -50))
    return fused(fused(_hole(x - 10, y), middle), _hole(x + 10, y))


def _lap(low: Sequence[Any], high: Sequence[Any]) -> Solids:
    """Return two sheets of 6 mm that lie on each other, with what is cut out of each."""
    return [("low", cut(box(120, 80, 6, (0, 0, 0)), *low)), ("high", cut(box(120, 50, 6, (70, 15, 6)), *high))]


def _holes_that_line_up() -> Solids:
    return _lap([_hole(85, 25, 9), _hole(85, 55, 9)], [_hole(85, 25), _hole(85, 55)])


def _slots_that_line_up() -> Solids:
    return _lap([_hole(88, 25), _hole(88, 55)], [_slot(90, 25), _slot(90, 55)])


def _counterbored_cap() -> Solids:
    """Return a block with two holes under a cap whose holes have room for the heads of socket screws."""
    return [
        ("block", cut(box(100, 60, 20, (0, 0, 0)), _hole(20, 30, 9.5), _hole(80, 30, 9.5))),
        ("cap", cut(box(100, 60, 6, (0, 0, 20)), _hole(20, 30, 17.8), _hole(80, 30, 17.8))),
    ]


def _one_hole_that_lines_up() -> Solids:
    return _lap([_hole(90, 40)], [_hole(90, 40)])


def _holes_that_do_not_line_up() -> Solids:
    return _lap([_hole(85, 25), _hole(85, 55)], [_hole(95, 25), _hole(95, 55)])


def _covered_holes() -> Solids:
    """Return a sheet with two holes for bolts under a block that covers them."""
    return [
        ("foot", cut(box(200, 100, 8, (0, 0, 0)), _hole(60, 50), _hole(140, 50))),
        ("block", box(160, 60, 30, (20, 20, 8))),
    ]


def _ring_over_a_hole() -> Solids:
    return [
        ("sheet", cut(box(100, 100, 8, (-50, -50, 0)), _hole(0, 0, 20))),
        ("ring", cut(cylinder(20, 15, (0, 0, 8), UP), _hole(0, 0, 20))),
    ]


def _gusset_with_holes() -> Solids:
    """Return a gusset that stands on a plate, and a strap that is bolted to it."""
    holes = [cylinder(5.5, 60, (x, 0, 60), ALONG_Y) for x in (80, 110)]
    return [
        ("plate", box(200, 100, 10, (0, -50, 0))),
        ("gusset", cut(box(160, 10, 80, (20, 0, 10)), *holes)),
        ("strap", cut(box(60, 10, 120, (65, 10, 40)), *holes)),
    ]


def _panel_on_brackets() -> Solids:
    """Return a post with two welded brackets, and a panel that is bolted to both and touches the post."""
    holes = [cylinder(4.5, 60, (85, -30, z), ALONG_Y) for z in (50, 70, 230, 250)]
    return [
        ("post", box(60, 60, 300, (0, 0, 0))),
        ("bracket low", cut(box(50, 6, 60, (60, 0, 30)), *holes)),
        ("bracket high", cut(box(50, 6, 60, (60, 0, 210)), *holes)),
        ("panel", cut(box(200, 12, 280, (40, -12, 10)), *holes)),
    ]


BOLTED_GRAPHS: dict[str, Callable[[], Solids]] = {
    "holes-in-line": _holes_that_line_up,
    "slots-in-line": _slots_that_line_up,
    "counterbored-cap": _counterbored_cap,
    "one-hole-in-line": _one_hole_that_lines_up,
    "holes-apart": _holes_that_do_not_line_up,
    "covered-holes": _covered_holes,
    "ring-over-hole": _ring_over_a_hole,
    "gusset-with-holes": _gusset_with_holes,
    "panel-on-brackets": _panel_on_brackets,
}
"""Name and maker of each part."""
