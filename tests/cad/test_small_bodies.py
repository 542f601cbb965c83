"""Round the foot of a small bar there is one weld, not one per side. A crumb that a drawing leaves changes nothing."""

from typing import Any

import pytest
from build123d import Align, Box, Pos

from cad.kernel.to_brep import to_brep
from wpcal.seam import Seam, SeamOptions, detect_seams

LOW = (Align.CENTER, Align.CENTER, Align.MIN)


FUSED = Box(200, 120, 10, align=LOW) + Pos(0, 0, 10) * Box(150, 8, 60, align=LOW)
SHORT_END_MM = 8.0
"""The ends of the web: beside a body that covers a part of its side, one is welded round with the rest."""


def accepted_of(first: Any, *others: Any, **options: Any) -> list[Seam]:
    """Return the accepted seams of a part."""
    shapes = [(f"S{k}", shape.solid().wrapped) for k, shape in enumerate((first, *others))]
    return [seam for seam in detect_seams(to_brep(shapes), SeamOptions(**options)) if seam.accepted]


def accepted(bar: Any, **options: Any) -> list[Seam]:
    """Return the accepted seams of a bar on a plate."""
    return accepted_of(Box(120, 80, 8, align=(Align.CENTER, Align.CENTER, Align.MAX)), bar, **options)


def inner_seams(*others: Any) -> list[float]:
    """Return the lengths of the accepted seams inside the fused tee, mm."""
    return sorted(seam.length_mm for seam in accepted_of(FUSED, *others) if set(seam.solids) == {"S0"})


def test_a_weld_round_a_small_foot_is_one_closed_seam_with_and_without_wrap() -> None:
    foot = Box(10, 5, 60, align=LOW)
    for wrap in (False, True):
        (seam,) = accepted(foot, wrap=wrap)
        assert (seam.closed, round(seam.length_mm, 6)) == (True, 30.0)


def test_the_sides_that_a_torch_reaches_are_one_run() -> None:
    """Under a low arch the inner side of each foot stays open."""
    arch = Pos(0, 0, 10) * Box(50, 10, 5, align=LOW)
    arch += Pos(-22.5, 0, 0) * Box(5, 10, 10, align=LOW) + Pos(22.5, 0, 0) * Box(5, 10, 10, align=LOW)
    seams = accepted(arch)
    assert [(seam.closed, round(seam.length_mm, 6)) for seam in seams] == [(False, 20.0), (False, 20.0)]


def test_a_long_side_is_a_seam_of_its_own() -> None:
    assert sorted(round(seam.length_mm, 6) for seam in accepted(Box(30, 10, 60, align=LOW))) == [30.0, 30.0]


def test_a_crumb_changes_nothing() -> None:
    alone = inner_seams()
    assert alone[-2:] == pytest.approx([150.0, 150.0], rel=0, abs=1e-6)
    assert inner_seams(Pos(60, 40, 10) * Box(0.5, 0.5, 3, align=LOW)) == pytest.approx(alone, rel=0, abs=1e-9)


def test_a_body_that_touches_another_is_still_taken_apart() -> None:
    beside = inner_seams(Pos(60, 40, 10) * Box(20, 20, 40, align=LOW))
    assert 0.0 <= sum(beside) - 2 * 150.0 + 1e-6 <= 2 * SHORT_END_MM
