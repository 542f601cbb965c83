"""Strips of faces hold every piece of boundary that crosses a meridian, each once, and no piece of another face."""

import numpy as np
import pytest

from wpcal.brep.strips import Strips
from wpcal.core.arrays import BoolArray, FloatArray, IntArray

COUNTS = np.array([4, 0, 60, 300, 1, 25])  #: Pieces of each face; one has none, as a whole sphere.


def boundaries(rng: np.random.Generator, turns: BoolArray) -> tuple[IntArray, FloatArray, FloatArray]:
    """Pieces of faces in u: lengths on some; angles on others, all around or, on the last face, on a narrow part."""
    face = np.repeat(np.arange(len(COUNTS)), COUNTS)
    begin = rng.uniform(-40.0, 900.0, len(face))
    run = rng.normal(size=len(face)) * 10.0 ** rng.uniform(-3.0, 3.0, len(face))
    angle = np.where(face == len(COUNTS) - 1, 3.0 + rng.uniform(0.0, 0.4, len(face)), rng.uniform(-9, 9, len(face)))
    turn = np.where(face == len(COUNTS) - 1, 0.2, 3.0) * rng.uniform(-1.0, 1.0, len(face))
    begin, run = np.where(turns[face], angle, begin), np.where(turns[face], turn, run)
    end = begin + run + np.where(turns[face], 2.0 * np.pi * rng.integers(-1, 2, len(face)), 0.0)
    return np.concatenate([[0], np.cumsum(COUNTS)]), begin, end


def crosses(turns: bool, u: float, begin: FloatArray, end: FloatArray) -> BoolArray:
    """Tell whether pieces cross a meridian; those that turn go the shorter way."""
    if not turns:
        return (begin <= u) != (end <= u)
    a, b = (np.angle(np.exp(1j * (side - u))) for side in (begin, end))
    return ((a <= 0) != (b <= 0)) & (np.abs(b - a) < np.pi)


@pytest.mark.parametrize("turns", [[False] * 6, [True] * 6, [False, True, True, False, True, True]])
@pytest.mark.parametrize("most", [50, 500_000])
def test_every_piece_that_crosses_is_there_once(turns: list[bool], most: int) -> None:
    rng, goes_round = np.random.default_rng(3), np.array(turns)
    start, begin, end = boundaries(rng, goes_round)
    face = rng.integers(0, len(COUNTS), 600)
    u = np.where(goes_round[face], rng.uniform(-7, 7, 600), rng.uniform(-100, 1000, 600))
    for row in np.flatnonzero(COUNTS[face])[:200]:  # ends of pieces, too
        u[row] = begin[start[face[row]]]
    found = list(Strips.of(goes_round, start, begin, end).pairs(face, u, most))
    row, piece = np.concatenate(found, axis=1)
    assert (np.diff(row) >= 0).all()
    assert ((piece >= start[face[row]]) & (piece < start[face[row] + 1])).all()
    assert len(np.unique(np.stack([row, piece]), axis=1).T) == len(row)
    listed = set(zip(row.tolist(), piece.tolist(), strict=True))
    for number in range(len(face)):
        own = np.arange(start[face[number]], start[face[number] + 1])
        crossing = own[crosses(goes_round[face[number]], u[number], begin[own], end[own])]
        assert all((number, one) in listed for one in crossing.tolist())


def test_few_pieces_are_in_a_strip() -> None:
    angle = np.arange(400) * 2.0 * np.pi / 400
    u = np.cos(angle)  # a round hole in a plate
    strips = Strips.of(np.array([False]), np.array([0, 400]), u, np.roll(u, -1))
    row, _ = np.concatenate(list(strips.pairs(np.zeros(200, dtype=np.int64), np.linspace(-0.9, 0.9, 200), 10**6)), 1)
    assert len(row) < 200 * 10
