"""A bracket to time planning with: five plates, two gussets and a tube post, about 30 seams."""

from pathlib import Path

from cad.kernel.call import kernel_call
from cad.kernel.primitives import box, cut, cylinder, prism
from cad.samples.parts import DARK, STEEL
from cad.step.new_file import Member, new_step_text
from wpcal.core.records import write_file

LONG, WIDE, SHEET, HIGH = 420, 320, 10, 140  #: Of the base and of the walls on it, mm.
LEG = 60  #: Of the gussets, mm.


def bench_bracket() -> list[Member]:
    """Draw the bracket: a base, a back wall, two side walls and a rib, gussets at the back wall, a post on the base."""
    back, side, rib = WIDE - 30, 40, 200
    foot = (310.0, 90.0, float(SHEET))
    post, bore = (cylinder(radius, 120, foot, (0, 0, 1)) for radius in (30, 26))
    return [
        ("base", box(LONG, WIDE, SHEET, (0, 0, 0)), STEEL),
        ("back", box(LONG - 40, SHEET, HIGH, (20, back, SHEET)), DARK),
        ("left", box(SHEET, back - 80, HIGH - 30, (side, 80, SHEET)), DARK),
        ("right", box(SHEET, 110, HIGH - 60, (LONG - side - SHEET, back - 110, SHEET)), DARK),
        ("rib", box(SHEET, 150, HIGH - 50, (rib, back - 150, SHEET)), DARK),
        *((f"gusset {x}", _gusset(x, back), STEEL) for x in (115, 290)),
        ("post", cut(post, bore), DARK),
    ]


def _gusset(x: float, back: float) -> object:
    corners = [(x, back, SHEET), (x, back - LEG, SHEET), (x, back, SHEET + LEG)]
    return prism([tuple(map(float, p)) for p in corners], (8.0, 0.0, 0.0))


def write_bench_bracket(folder: Path) -> Path:
    """Write the bracket as STEP."""
    path = folder / "bench_bracket.step"
    with kernel_call("making a bracket"):
        members = bench_bracket()
    write_file(path, new_step_text(members, "bench_bracket"), overwrite=True)
    return path
