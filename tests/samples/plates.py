"""Weldments whose plates stand near to each other: a straight way between two seams leads the wire through a plate.

`python -m tests.samples.plates FOLDER` writes them.
"""

import sys
from collections.abc import Callable
from pathlib import Path

from cad.kernel.call import kernel_call
from cad.kernel.primitives import box, cut, cylinder, prism, square_tube
from cad.samples.parts import DARK, STEEL, saddle
from cad.step.new_file import Member, new_step_text
from wpcal.core.records import write_file


def t_joint() -> list[Member]:
    """Return a plate with a web of 8 mm on it: the way from one side to the other crosses the web."""
    return [("base", box(240, 140, 10, (0, 0, 0)), STEEL), ("web", box(200, 8, 60, (20, 66, 10)), DARK)]


def bracket() -> list[Member]:
    """Return five plates, two gussets and a tube post: 30 seams in corners of two and three plates."""
    return [
        ("base", box(400, 260, 12, (0, 0, 0)), STEEL),
        ("back", box(360, 8, 160, (20, 200, 12)), DARK),
        ("left", box(8, 140, 110, (60, 60, 12)), STEEL),
        ("right", box(8, 140, 110, (332, 60, 12)), STEEL),
        ("shelf", box(264, 90, 8, (68, 110, 90)), DARK),
        *((f"gusset {x}", prism([(x, 208, 12), (x, 248, 12), (x, 208, 92)], (8, 0, 0)), STEEL) for x in (120, 272)),
        ("post", cut(cylinder(30, 90, (200, 60, 12), (0, 0, 1)), cylinder(26, 90, (200, 60, 12), (0, 0, 1))), DARK),
    ]


def box_frame() -> list[Member]:
    """Return a frame of square tubes with a plate across it: seams inside of a box."""
    side = 50.0
    return [
        *(
            (name, square_tube(side, 500, (0, y, 0), "x", wall=4.0, corner_radius=6.0), STEEL)
            for name, y in (("front", 0.0), ("behind", 350.0))
        ),
        *(
            (f"across {x:g}", square_tube(side, 300, (x, side, 0), "y", wall=4.0, corner_radius=6.0), DARK)
            for x in (0.0, 225.0, 450.0)
        ),
        ("plate", box(175, 8, 120, (50, 196, 0)), STEEL),
    ]


PARTS: dict[str, Callable[[], list[Member]]] = {
    "t_joint": t_joint,
    "saddle": saddle,
    "bracket": bracket,
    "box_frame": box_frame,
}


def write_part(name: str, folder: Path) -> Path:
    """Write one of them as STEP."""
    path = folder / f"{name}.step"
    with kernel_call(f"making {name}"):
        members = PARTS[name]()
    write_file(path, new_step_text(members, name), overwrite=True)
    return path


if __name__ == "__main__":
    for part in PARTS:
        write_part(part, Path(sys.argv[1]))
