"""Pairs of solids that no straight move takes apart: flat and round ones, all pairs of a part together."""

from typing import Any

import numpy as np
import pytest
from build123d import Box, Cylinder, Pos, Rot

from cad.kernel.to_brep import to_brep
from wpcal.brep.trim import TrimmedFaces
from wpcal.seam.judge.closed_in import find_held

GAP_MM = 0.5
Pairs = dict[str, tuple[Any, Any, bool]]


@pytest.fixture(scope="module")
def made() -> Pairs:
    """Pairs of solids, and whether they are held."""
    frame = Box(500, 400, 30) - Box(420, 320, 40)
    in_groove, in_hole, lying = Box(432, 332, 6), Box(420, 320, 6), Pos(0, 0, 20) * Box(450, 350, 10)
    key = Pos(0, 0, 7) * Box(20, 80, 6) + Box(8, 80, 10)
    slotted = Box(120, 80, 30) - Pos(0, 0, 7) * Box(20, 90, 6) - Pos(0, 0, 3) * Box(8, 90, 16)
    core, turn = Cylinder(20, 40), Rot(20, 30, 40)
    return {
        "pane in a groove": (frame - in_groove, in_groove, True),
        "pane in a hole": (frame, in_hole, False),
        "pane on a frame": (frame, lying, False),
        "key in a slot": (slotted, key, False),
        "core in a closed drum": (Cylinder(30, 60) - core, core, True),
        "core in an open drum": (Cylinder(30, 60) - core - Pos(0, 0, 30) * core, core, False),
        "shaft in a bore": (Box(80, 80, 40) - Cylinder(15, 60), Cylinder(15, 100), False),
        "tilted pane": (turn * (frame - in_groove), turn * in_groove, True),
        "far away": (frame, Pos(2000, 0, 0) * core, False),
    }


@pytest.fixture(scope="module")
def part(made: Pairs) -> TrimmedFaces:
    """All pairs, a metre apart."""
    shapes = [
        (f"{name} {number}", (Pos(0, 5000 * row, 0) * shape).solid().wrapped)
        for row, (name, (*both, _)) in enumerate(made.items())
        for number, shape in enumerate(both)
    ]
    return TrimmedFaces.of(to_brep(shapes))


def test_pairs_that_no_straight_move_takes_apart_are_held(part: TrimmedFaces, made: Pairs) -> None:
    pairs = np.arange(2 * len(made)).reshape(-1, 2)
    expected = [is_held for *_, is_held in made.values()]
    assert find_held(part.graph, part, pairs, GAP_MM).tolist() == expected
    turned = pairs[::-1, ::-1]
    assert find_held(part.graph, part, turned, GAP_MM).tolist() == expected[::-1]


def test_no_pair_is_no_answer(part: TrimmedFaces) -> None:
    assert find_held(part.graph, part, np.zeros((0, 2), dtype=np.int64), GAP_MM).shape == (0,)
