"""Rays meet bent pipes with free-form faces where the kernel's own rays meet them."""

from pathlib import Path

import numpy as np
from OCP.gp import gp_Dir, gp_Lin, gp_Pnt
from OCP.IntCurvesFace import IntCurvesFace_ShapeIntersector

from cad.workpiece.workpiece import open_workpiece
from wpcal.brep.hits import find_hits
from wpcal.core.arrays import BoolArray, FloatArray

RAYS, LENGTH_MM = 200, 600.0
NEAR_MM = 1e-5
LEAST_SHARE = 0.998
"""Share of the kernel's hits that are found, and of the found ones that are the kernel's; the rest graze a pipe."""


def test_rays_through_bent_free_form_pipes(shared_step: Path) -> None:
    """Four pipes of one face each, outside and inside: their seam edge runs along the pipe."""
    workpiece = open_workpiece(shared_step.parent / "blind" / "mini" / "em_re.step")
    graph, trimmed = workpiece.graph, workpiece.trimmed
    assert len(graph.nurbs_surfaces) == 8
    rng = np.random.default_rng(4)
    low, high = (corner[graph.face_nurbs >= 0] for corner in trimmed.face_box)
    origins = rng.uniform(low.min(axis=0), high.max(axis=0), (RAYS, 3))
    rays = rng.normal(size=(RAYS, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    found = find_hits(graph, trimmed, origins, rays, length_mm=LENGTH_MM)
    expected: list[list[float]] = [[] for _ in range(RAYS)]
    for shape in workpiece.solids:
        kernel = IntCurvesFace_ShapeIntersector()
        kernel.Load(shape, 1e-6)
        for row in range(RAYS):
            kernel.Perform(gp_Lin(gp_Pnt(*origins[row].tolist()), gp_Dir(*rays[row].tolist())), 0.0, LENGTH_MM)
            expected[row] += [kernel.WParameter(k) for k in range(1, kernel.NbPnt() + 1)]
    assert sum(map(len, expected)) > RAYS
    hits = [np.sort(wanted) for wanted in expected]
    found_at = [found.at_mm[found.ray == row] for row in range(RAYS)]
    for these, those in ((hits, found_at), (found_at, hits)):
        met = [is_among(at, there) for at, there in zip(these, those, strict=True)]
        assert np.concatenate(met).mean() >= LEAST_SHARE


def is_among(at: FloatArray, there: FloatArray) -> BoolArray:
    return (np.abs(at[:, None] - there) <= NEAR_MM).any(axis=1)
