"""Do the lines of a list lie on the members that they name? Asked of the kernel, which knows no seams."""

from pathlib import Path

import numpy as np
from OCP.BRep import BRep_Builder
from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeVertex
from OCP.BRepExtrema import BRepExtrema_DistShapeShape
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_FACE
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS_Compound

from cad.step.read import read_step
from tests.benchmarks.welds.lists import Weld

SAMPLES = 5  #: Places along each weld at which distances are measured.


def off_members(step: Path, welds: tuple[Weld, ...]) -> dict[str, float]:
    """Return, for each weld, how far its line lies from the farthest of its members at most, mm."""
    shapes = {solid.name: _skin(solid.shape) for solid in read_step(step).solids}
    return {weld.name: max(_distance(shapes[name], weld) for name in weld.members) for weld in welds}


def _skin(shape: object) -> object:
    """Return the faces of a body: inside it, the distance to the body itself is nought."""
    faces, builder = TopoDS_Compound(), BRep_Builder()
    builder.MakeCompound(faces)
    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        builder.Add(faces, explorer.Current())
        explorer.Next()
    return faces


def _distance(shape: object, weld: Weld) -> float:
    """Return the greatest distance of sampled places of a weld from a body, mm."""
    step = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(weld.points, axis=0), axis=1))])
    places = (np.arange(SAMPLES) + 0.5) / SAMPLES * step[-1]
    points = np.column_stack([np.interp(places, step, weld.points[:, k]) for k in range(3)])
    return max(
        BRepExtrema_DistShapeShape(BRepBuilderAPI_MakeVertex(gp_Pnt(*p)).Vertex(), shape).Value()
        for p in points.tolist()
    )
