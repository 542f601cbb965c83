"""A long steel structure of tubes, plates and gussets with any number of bays: a large part with known seams.

Benchmarks measure reading and seam finding on it (`tests/benchmarks/bench_extraction.py`). Every member has its own
geometry in the file, as in files of CAD systems whose parts were drawn one by one.
"""

import math
from collections.abc import Iterator
from typing import Any

from cad.kernel.primitives import Point, box, cut, cylinder, prism, square_tube
from cad.samples.parts import DARK, STEEL
from cad.step.new_file import Member

BAYS_PER_ROW = 20  #: Bays are in rows side by side, so that the structure stays compact.
BAY_MM, DEPTH_MM, HEIGHT_MM, ROW_MM = 900.0, 700.0, 1000.0, 1500.0
POST_MM, RAIL_MM, CORNER_MM, WALL_MM = 60.0, 40.0, 6.0, 3.0
PLATE_MM, PLATE_THICK_MM, BOLT_MM = 150.0, 12.0, 14.0
PIPE_MM = 42.4
LEG_MM, SNIPE_MM, GUSSET_THICK_MM = 80.0, 20.0, 8.0
RAIL_HEIGHTS_MM = (200.0, 800.0)  #: Undersides of the rails above the base plates.


def steel_structure(bays: int) -> list[Member]:
    """Return a structure with a number of bays.

    Each bay has two posts of square tube on base plates with holes, four rails along x, two along y, a round pipe and
    two gussets. A row ends with two more posts, two rails along y and a pipe.
    """
    return [member for row in range(math.ceil(bays / BAYS_PER_ROW)) for member in _row(row, bays)]


def seam_counts(bays: int) -> tuple[int, float]:
    """Return how many seams of the structure a torch reaches, and their length, mm, in closed form.

    Every end of a post, rail or pipe has one closed fillet around it. Each of the two legs of a gusset has three
    straight fillets; no torch reaches the fourth, in the hole at the cut corner. There the gusset is in the way of the
    wire along the fillet of its rail, which is cut at both of its sides.
    """
    frames = bays + math.ceil(bays / BAYS_PER_ROW)
    square = {side: 4 * (side - 2 * CORNER_MM) + 2 * math.pi * CORNER_MM for side in (POST_MM, RAIL_MM)}
    leg = 2 * (LEG_MM - SNIPE_MM) + GUSSET_THICK_MM
    loops = frames * (2 * square[POST_MM] + 4 * square[RAIL_MM] + 2 * math.pi * PIPE_MM) + bays * 8 * square[RAIL_MM]
    return frames * (2 + 4 + 2) + bays * (8 + 12), loops + bays * (4 * leg - 2 * GUSSET_THICK_MM)


def _row(row: int, bays: int) -> Iterator[Member]:
    y = row * ROW_MM
    count = min(BAYS_PER_ROW, bays - row * BAYS_PER_ROW)
    for frame in range(count + 1):
        yield from _frame(f"{row + 1}.{frame + 1}", (frame * BAY_MM, y, 0.0))
        if frame < count:
            yield from _bay(f"{row + 1}.{frame + 1}", (frame * BAY_MM, y, 0.0))


def _frame(name: str, corner: Point) -> Iterator[Member]:
    """Two posts on their plates, with the rails and the pipe between them, from the first post's corner."""
    x, y, z = corner
    for side, behind in (("front", 0.0), ("back", DEPTH_MM)):
        yield f"plate {name} {side}", _base_plate((x, y + behind, z)), DARK
        yield f"post {name} {side}", _square_tube(POST_MM, HEIGHT_MM, (x, y + behind, z), "z"), STEEL
    inside, long = (POST_MM - RAIL_MM) / 2, DEPTH_MM - POST_MM
    for height in RAIL_HEIGHTS_MM:
        tube = _square_tube(RAIL_MM, long, (x + inside, y + POST_MM, z + height), "y")
        yield f"cross rail {name} {height:.0f}", tube, STEEL
    middle = (x + POST_MM / 2, y + POST_MM, z + HEIGHT_MM / 2)
    pipe = cylinder(PIPE_MM / 2, long, middle, (0, 1, 0))
    yield f"pipe {name}", cut(pipe, cylinder(PIPE_MM / 2 - WALL_MM, long, middle, (0, 1, 0))), DARK


def _bay(name: str, corner: Point) -> Iterator[Member]:
    """Four rails along x between the posts of two frames, and gussets on the two lower ones."""
    x, y, z = corner
    inside = (POST_MM - RAIL_MM) / 2
    for side, behind in (("front", 0.0), ("back", DEPTH_MM)):
        for height in RAIL_HEIGHTS_MM:
            at = (x + POST_MM, y + behind + inside, z + height)
            yield f"rail {name} {side} {height:.0f}", _square_tube(RAIL_MM, BAY_MM - POST_MM, at, "x"), STEEL
        middle = y + behind + (POST_MM - GUSSET_THICK_MM) / 2
        yield f"gusset {name} {side}", _gusset((x + POST_MM, middle, z + RAIL_HEIGHTS_MM[0] + RAIL_MM)), DARK


def _base_plate(corner: Point) -> Any:
    """Return the plate under the post of that corner, with four bolt holes."""
    x, y, z = corner[0] - (PLATE_MM - POST_MM) / 2, corner[1] - (PLATE_MM - POST_MM) / 2, corner[2] - PLATE_THICK_MM
    inset = 20.0
    holes = [
        cylinder(BOLT_MM / 2, PLATE_THICK_MM, (x + dx, y + dy, z), (0, 0, 1))
        for dx in (inset, PLATE_MM - inset)
        for dy in (inset, PLATE_MM - inset)
    ]
    return cut(box(PLATE_MM, PLATE_MM, PLATE_THICK_MM, (x, y, z)), *holes)


def _square_tube(side: float, length: float, corner: Point, axis: str) -> Any:
    """Return a square tube with rounded edges, from the corner of its start along x, y or z."""
    return square_tube(side, length, corner, axis, wall=WALL_MM, corner_radius=CORNER_MM)


def _gusset(corner: Point) -> Any:
    """Return a triangle with cut corners in the plane x, z, between a rail and a post, from their corner."""
    x, y, z = corner
    corners = [(x + dx, y, z + dz) for dx, dz in ((SNIPE_MM, 0.0), (LEG_MM, 0.0), (0.0, LEG_MM), (0.0, SNIPE_MM))]
    return prism(corners, (0, GUSSET_THICK_MM, 0))
