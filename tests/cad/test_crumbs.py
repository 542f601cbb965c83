"""A crumb that a drawing leaves on a weldment of one solid does not change its seams; a member does."""

from typing import Any

import pytest
from build123d import Align, Box, Pos

from cad.kernel.to_brep import to_brep
from wpcal.seam import detect_seams

LOW = (Align.CENTER, Align.CENTER, Align.MIN)
FUSED = Box(200, 120, 10, align=LOW) + Pos(0, 0, 10) * Box(150, 8, 60, align=LOW)


SHORT_END_MM = 8.0
"""The ends of the web: beside a body that covers a part of its side, one is welded round with the rest."""


def inner_seams(*others: Any) -> list[float]:
    """Return the lengths of the accepted seams inside the fused tee, mm."""
    shapes = [("tee", FUSED.solid().wrapped), *((f"S{k}", other.solid().wrapped) for k, other in enumerate(others))]
    seams = [seam for seam in detect_seams(to_brep(shapes)) if seam.accepted and set(seam.solids) == {"tee"}]
    return sorted(seam.length_mm for seam in seams)


def test_a_crumb_changes_nothing() -> None:
    alone = inner_seams()
    assert alone[-2:] == pytest.approx([150.0, 150.0], rel=0, abs=1e-6)
    assert inner_seams(Pos(60, 40, 10) * Box(0.5, 0.5, 3, align=LOW)) == pytest.approx(alone, rel=0, abs=1e-9)


def test_a_body_that_touches_another_is_still_taken_apart() -> None:
    beside = inner_seams(Pos(60, 40, 10) * Box(20, 20, 40, align=LOW))
    assert 0.0 <= sum(beside) - 2 * 150.0 + 1e-6 <= 2 * SHORT_END_MM
