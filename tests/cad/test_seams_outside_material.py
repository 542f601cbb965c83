"""The kernel's own classifier finds no accepted frame inside a solid."""

from pathlib import Path

import numpy as np
import pytest
from OCP.BRepClass3d import BRepClass3d_SolidClassifier
from OCP.gp import gp_Pnt
from OCP.TopAbs import TopAbs_IN

from cad.samples.graphs import GRAPHS
from cad.workpiece.seams import find_seams
from cad.workpiece.workpiece import open_workpiece
from wpcal.core.arrays import FloatArray
from wpcal.seam import Seam, SeamOptions, detect_seams
from wpcal.seam.judge.stations import start_mm

ON_FACE_MM = 1e-4
"""A point this near to a face is on it: the end of a stretch lies on the solid that it ends at."""
OUT_OF_STEP_PARTS = ("as1-oc-214.stp", "dm1-id-214.stp", "house_walls.stp")


def accepted_points(seams: tuple[Seam, ...]) -> FloatArray:
    rows = [s.frames.p + start_mm(s) * s.frames.R[:, :, 2] for s in seams if s.accepted]
    return np.concatenate([np.zeros((0, 3)), *rows])


def count_inside(shapes: list[object], points: FloatArray) -> int:
    inside = 0
    for shape in shapes:
        classifier = BRepClass3d_SolidClassifier(shape)
        for p in points:
            classifier.Perform(gp_Pnt(*p.tolist()), ON_FACE_MM)
            inside += classifier.State() == TopAbs_IN
    return inside


@pytest.mark.parametrize(
    "name",
    ["crossed-tee", "gusseted-bracket", "boss-with-ribs", "pipe-through-plates", "closed-box", "frame", "saddle"],
)
def test_accepted_frames_of_own_parts(name: str) -> None:
    from tests.saved_graphs import saved_graph

    points = accepted_points(detect_seams(saved_graph(name)))
    assert len(points)
    assert count_inside([shape for _, shape in GRAPHS[name]()], points) == 0


@pytest.mark.parametrize("name", OUT_OF_STEP_PARTS)
def test_accepted_frames_of_parts_made_by_others(name: str, shared_step: Path) -> None:
    workpiece = open_workpiece(shared_step / name)
    seams, workpiece = find_seams(workpiece, SeamOptions())
    assert count_inside(list(workpiece.solids), accepted_points(seams)) == 0
