"""Precision and recall of the seams found on a real part against a list of expected ones, made by hand."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.brep.trim import distance_to_segments
from wpcal.core.arrays import FloatArray
from wpcal.seam import Seam

EXPECTED = Path(__file__).with_name("expected_seams")
SPACING_MM = 1.0  #: Points along an expected line and a found seam at which they are compared.
COVERED = 0.9
"""Share of an expected seam that accepted ones must run along; the corner of three sheets belongs to one only."""
LENGTH_SHARE = 0.01
"""A whole loop has the expected length within this share: the list gives it to a tenth of a millimetre."""


@dataclass(frozen=True, slots=True)
class Score:
    """How many of the expected seams were found, and how many of the accepted ones were expected."""

    expected: int
    found: int
    accepted: int
    right: int
    candidates: int

    @property
    def recall(self) -> float:
        """Share of the expected seams that the accepted ones cover."""
        return self.found / self.expected

    @property
    def precision(self) -> float:
        """Share of the accepted seams that run along an expected one, between the same solids."""
        return self.right / self.accepted if self.accepted else 0.0


def expected_seams(stem: str) -> list[dict[str, Any]]:
    """Return the list of one part."""
    seams: list[dict[str, Any]] = json.loads((EXPECTED / f"{stem}.json").read_text(encoding="utf-8"))["seams"]
    return seams


def score(stem: str, seams: Sequence[Seam]) -> Score:
    """Compare the seams found on a part with the list."""
    wanted = expected_seams(stem)
    accepted = [seam for seam in seams if seam.accepted]
    told = [seam for seam in seams if seam.accepted or seam.blocked_by]  # the list says where joints are, not torches
    found = sum(is_found(item, told) for item in wanted)
    right = sum(any(is_along(seam, item, told) for item in wanted) for seam in accepted)
    return Score(len(wanted), found, len(accepted), right, len(seams))


def same_solids(seam: Seam, item: dict[str, Any]) -> bool:
    return sorted(seam.solids) == item["solids"]


def is_found(item: dict[str, Any], accepted: Sequence[Seam]) -> bool:
    """Tell whether accepted seams between the same solids run along an expected one."""
    points = samples(np.array(item["path_mm"])) if "path_mm" in item else np.array(item["points_mm"])
    near = np.zeros(len(points), dtype=bool)
    length = 0.0
    for seam in accepted:
        if same_solids(seam, item):
            near |= distance(points, seam.frames.p) <= item["within_mm"]
            length += seam.length_mm
    if "points_mm" in item and abs(length - item["length_mm"]) > LENGTH_SHARE * item["length_mm"]:
        return False
    return bool(near.mean() >= COVERED)


def is_along(seam: Seam, item: dict[str, Any], told: Sequence[Seam] = ()) -> bool:
    """Tell whether an accepted seam runs along an expected one, as a loop whole.

    A loop may be cut where no torch gets: then all of its stretches together, those in `told`, are the loop.
    """
    if not same_solids(seam, item):
        return False
    if "path_mm" in item:
        return bool((distance(samples(seam.frames.p), np.array(item["path_mm"])) <= item["within_mm"]).all())
    return is_found(item, [seam] if seam.closed else told)


def samples(path: FloatArray) -> FloatArray:
    """Return points every `SPACING_MM` along a polyline."""
    steps = np.linalg.norm(np.diff(path, axis=0), axis=1)
    s = np.concatenate([[0.0], np.cumsum(steps)])
    at = np.linspace(0.0, s[-1], max(2, int(np.ceil(s[-1] / SPACING_MM)) + 1))
    return np.stack([np.interp(at, s, path[:, k]) for k in range(3)], axis=1)


def distance(points: FloatArray, path: FloatArray) -> FloatArray:
    """Return the distance of points from a polyline."""
    off = [distance_to_segments(points, *np.broadcast_arrays(a, b, points)[:2]) for a, b in pairwise(path)]
    return np.asarray(np.min(off, axis=0), dtype=np.float64)
