"""The reference features of a part: all searches together, in the order of the list."""

from __future__ import annotations

from wpcal.brep.graph import BrepGraph
from wpcal.taught.features.corners import find_edge_ends, find_midpoints, find_vertices, find_virtual_corners
from wpcal.taught.features.holes import find_holes
from wpcal.taught.features.planes import find_planes
from wpcal.taught.features.reference import ReferenceFeature
from wpcal.taught.features.rounds import find_axes, find_bosses, find_circles, find_spheres
from wpcal.taught.features.slots import find_slots
from wpcal.taught.features.walls import Coaxial, Walls


def find_features(graph: BrepGraph) -> tuple[ReferenceFeature, ...]:
    """Find the features that can be taught on a part.

    Returns: Corners (``V``), circular rims (``C``), holes (``H``, the centre of the entry rim), sphere centres (``S``),
    midpoints of straight edges (``M``), bosses (``B``), slots (``L``), virtual corners (``X``), edge ends (``E``),
    datum planes (``P``) and cylinder axes (``A``). They are numbered within their kind by position (rounded to 1e-3 mm,
    sorted by x, y, z, then solid and size). The numbers are the same in every run and for every order of the faces in
    the file; a new kind never renumbers another one.
    """
    walls = Walls.of(Coaxial.of(graph))
    found = (
        find_vertices(graph),
        find_circles(graph),
        find_holes(walls),
        find_spheres(graph),
        find_midpoints(graph),
        find_bosses(walls),
        find_slots(walls),
        find_virtual_corners(graph),
        find_edge_ends(graph),
        find_planes(graph),
        find_axes(walls),
    )
    return tuple(feature for kind in found for feature in kind.named(graph))
