"""Places on a sheet: scales, labels that keep clear of each other, segments joined to polylines."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cad.sheet.draw import chained
from cad.sheet.labels import place_labels
from cad.sheet.paper import Box, nice_scale, scale_words

NO_SEGMENTS = np.zeros((0, 2, 2))
CELL = Box(0.0, 0.0, 120.0, 90.0)
SIZE = np.array([16.0, 5.0])


@given(largest=st.floats(1e-4, 1e4))
def test_a_scale_is_the_next_smaller_of_the_series(largest):
    scale = nice_scale(largest)
    assert largest / 1.51 < scale <= largest * (1 + 1e-9)  # 1.5 is the widest gap of the series; the rest is round-off
    number = scale if scale >= 1 else 1 / scale
    assert f"{number:.2e}".split("e")[0] in ("1.00", "1.50", "2.00", "2.50", "3.00", "4.00", "5.00", "6.00", "8.00")


@pytest.mark.parametrize(
    ("largest", "words"), [(1.0, "1:1"), (0.51, "1:2"), (0.2, "1:5"), (2.4, "2:1"), (0.07, "1:15")]
)
def test_scales_in_words(largest, words):
    assert scale_words(nice_scale(largest)) == words


def overlap(a, b):
    return a.x < b.right and b.x < a.right and a.y < b.top and b.y < a.top


@given(seed=st.integers(0, 2**32))
def test_labels_overlap_neither_each_other_nor_points(seed):
    rng = np.random.default_rng(seed)
    p = rng.uniform([20, 15], [100, 75], (8, 2))
    labels = place_labels(p, np.tile(SIZE, (8, 1)), NO_SEGMENTS, CELL, avoid=NO_SEGMENTS)
    for i, label in enumerate(labels):
        assert not any(overlap(label.box, other.box) for other in labels[i + 1 :])
        inside = (p > [label.box.x, label.box.y]) & (p < [label.box.right, label.box.top])
        assert not inside.all(axis=1).any()
        assert label.box.x >= CELL.x
        assert label.box.top <= CELL.top


def test_points_at_one_place_get_a_label_each():
    p = np.full((4, 2), 50.0)
    labels = place_labels(p, np.tile(SIZE, (4, 1)), NO_SEGMENTS, CELL, avoid=NO_SEGMENTS)
    assert not any(overlap(a.box, b.box) for i, a in enumerate(labels) for b in labels[i + 1 :])


def test_a_label_leaves_the_lines_free():
    """The point is on the lower edge of a rectangle: the label stands below it."""
    corners = np.array([[30.0, 40], [90, 40], [90, 80], [30, 80]])
    lines = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    (label,) = place_labels(np.array([[60.0, 40]]), SIZE[None], lines, CELL, avoid=NO_SEGMENTS)
    assert label.box.top < 40


def test_what_is_to_be_avoided_is_avoided():
    avoid = np.array([[[40.0, 0], [40, 38]], [[80, 0], [80, 38]], [[40, 30], [80, 30]]])
    corners = np.array([[30.0, 40], [90, 40], [90, 80], [30, 80]])
    lines = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    (label,) = place_labels(np.array([[60.0, 40]]), SIZE[None], lines, CELL, avoid=avoid)
    inside = (np.array([50.0, 30]) > [label.box.x, label.box.y]) & (
        np.array([50, 30]) < [label.box.right, label.box.top]
    )
    assert not inside.all()


def test_segments_are_joined_up_to_where_three_meet():
    """A square with a tail: one chain around from the node of three, and the tail."""
    corners = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    square = np.stack([corners, np.roll(corners, -1, axis=0)], axis=1)
    tail = np.array([[[0.0, 0], [-1, 0]], [[-1, 0], [-2, 0]]])
    chains = sorted(chained(np.concatenate([square, tail])), key=len)
    assert [len(chain) for chain in chains] == [3, 5]
    np.testing.assert_array_equal(chains[1][0], [0, 0])
    np.testing.assert_array_equal(chains[1][-1], [0, 0])
    length = sum(np.linalg.norm(np.diff(chain, axis=0), axis=1).sum() for chain in chains)
    assert length == 6.0
