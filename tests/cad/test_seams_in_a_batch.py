"""Law of frames of many seams at once: those of a seam are bit for bit the same alone and with any others."""

from functools import cache

import numpy as np
import pytest

from cad.kernel.to_brep import to_brep
from tests.few import few
from tests.samples.flares import flush_tubes, half_ring_on_plate
from tests.saved_graphs import saved_graph
from wpcal.brep import BrepGraph
from wpcal.brep.trim import TrimmedFaces
from wpcal.seam import Seam, SeamOptions, StepOptions, detect_seams
from wpcal.seam.find.flare_grooves import add_grooves
from wpcal.seam.path.build import with_frames

GROOVES = {"tubes": lambda: flush_tubes(6.1, 3.05), "ring": lambda: half_ring_on_plate(30.0, 4.0)}
"""Their frames follow balls, which are searched."""
PARTS = ("small-rod", "bent-sheet", "frame", "saddle-60", *GROOVES)
"""Straight seams of several pieces, curves of a free form, and turning frames, too."""
FINE = SeamOptions(steps=StepOptions(chord_mm=0.02, max_step_mm=3.0, turn_rad=np.radians(2.0)))


@cache
def seams_of(name: str) -> tuple[BrepGraph, tuple[Seam, ...]]:
    graph, options = to_brep(GROOVES[name]()) if name in GROOVES else saved_graph(name), SeamOptions()
    graph, flares = add_grooves(graph, TrimmedFaces.of(graph), options)
    return graph, detect_seams(graph, options, flares=flares)


@pytest.mark.parametrize("name", few(PARTS, 2))
def test_a_seam_has_the_same_frames_alone_and_among_others(name: str) -> None:
    graph, seams = seams_of(name)
    together = with_frames(graph, seams, FINE)
    assert len(together) == len(seams) > 0
    for seam, own in zip(seams, together, strict=True):
        (alone,) = with_frames(graph, [seam], FINE)
        assert alone.length_mm == own.length_mm
        for column in ("s_mm", "p", "R", "angle_rad"):
            np.testing.assert_array_equal(getattr(alone.frames, column), getattr(own.frames, column))
    backwards = with_frames(graph, seams[::-1], FINE)[::-1]
    for one, other in zip(together, backwards, strict=True):
        np.testing.assert_array_equal(one.frames.matrices, other.frames.matrices)


@pytest.mark.deep
def test_the_parts_of_this_law_have_grooves_and_seams_of_several_pieces() -> None:
    found = [seams_of(name) for name in PARTS]
    assert any((graph.balls_mm[seam.pieces.edge] > 0).any() for graph, seams in found for seam in seams)
    assert any(len(seam.pieces) > 2 for _, seams in found for seam in seams)
