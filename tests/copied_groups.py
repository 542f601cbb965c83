"""Parts that hold one group of solids twice, and the comparison of their seams with those of a search of each group."""

import numpy as np
import pytest

from tests.saved_graphs import moved
from wpcal.brep import BrepGraph
from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.transform import RigidTransform
from wpcal.seam import Seam

FAR = np.array([1500.0, -730.0, 1.25])  #: mm: farther than a torch feels.
WITHIN_MM = 400.0
MOVED_MM = 1e-8
"""Frames of copies are those of the first group, moved. Round-off shifts places along free-form curves by 3e-9 mm."""


def shifted(graph: BrepGraph, shift: FloatArray) -> BrepGraph:
    """Return a graph at another place, not turned."""
    return moved(graph, RigidTransform(np.eye(3), shift, "moved", "part"))


def together(a: BrepGraph, b: BrepGraph) -> BrepGraph:
    """Return two graphs as one part; the solids of the second one have longer names."""

    def later(numbers: IntArray, count: int) -> IntArray:
        return np.where(numbers < 0, -1, numbers + count)

    counted = {
        "face_solid": len(a.solid_names),
        "face_nurbs": len(a.nurbs_surfaces),
        "edge_nurbs": len(a.nurbs_curves),
        "edge_vertices": len(a.vertex_p),
        "coedge_face": a.face_count,
        "coedge_edge": a.edge_count,
    }
    plain = [f"{what}_{name}" for what in ("face", "edge") for name in ("kind", "frame", "param")]
    plain += ["face_outward", "edge_range", "vertex_p", "coedge_forward"]
    columns = {name: np.concatenate([getattr(a, name), getattr(b, name)]) for name in plain}
    columns |= {name: np.concatenate([getattr(a, name), later(getattr(b, name), n)]) for name, n in counted.items()}
    names = (*a.solid_names, *(f"{name} of b" for name in b.solid_names))
    parts = {name: (*getattr(a, name), *getattr(b, name)) for name in ("nurbs_surfaces", "nurbs_curves", "solid_facts")}
    return BrepGraph(solid_names=names, **columns, **parts)


def check_same(found: tuple[Seam, ...], wanted: tuple[Seam, ...], within_mm: float = MOVED_MM) -> None:
    words = ("name", "joint", "weld", "solids", "closed", "reachable", "accepted", "source")
    assert len(found) == len(wanted)
    for seam, own in zip(found, wanted, strict=True):
        for name in (*words, "inside"):
            assert getattr(seam, name) == getattr(own, name), name
        assert [finding.rule for finding in seam.findings] == [finding.rule for finding in own.findings]
        if not seam.blocked_by:  # of two solids that a nozzle meets at once, round-off chooses one
            assert (seam.against, seam.blocked_by) == (own.against, own.blocked_by)
        assert seam.confidence == pytest.approx(own.confidence, rel=0, abs=within_mm)  # a gap counts as measured
        if not any("no torch reaches" in text for text in seam.reasons):
            assert seam.reasons == own.reasons
        assert {type(text) for text in seam.reasons} == {str}
        assert seam.length_mm == pytest.approx(own.length_mm, rel=0, abs=within_mm)
        np.testing.assert_allclose(seam.frames.matrices, own.frames.matrices, rtol=0, atol=within_mm)
        np.testing.assert_array_equal(seam.lean_rad, own.lean_rad)
        np.testing.assert_array_equal(seam.pieces.wall, own.pieces.wall)
        np.testing.assert_array_equal(seam.pieces.base, own.pieces.base)
        np.testing.assert_allclose(seam.candidate.middle_mm, own.candidate.middle_mm, rtol=0, atol=within_mm)
