"""Accepted seams against a list of welds: how many welds are found, and how many seams are right.

A weld is found where accepted seams lie within its `tol_mm` + 0.3 mm, parallel within 32 degrees, along 90 % of its
length. A seam is right if 90 % of it lies along welds, and at least half of it along sure or probable ones; optional if
the rest is along optional ones. All other seams are wrong.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from tests.benchmarks.welds.lists import OPTIONAL, PROBABLE, SURE, Weld
from wpcal.core.arrays import BoolArray, FloatArray

STEP_MM = 0.5  #: Points along lines at which they are compared.
SLACK_MM = 0.3  #: Added to every tolerance: curves are compared at points.
LEAST_COSINE = 0.85  #: Directions within 32 degrees: a seam that crosses a weld is not along it.
COVERED = 0.9  #: Share of a weld that must be found, and of a seam that must lie along welds.
HALF = 0.5  #: Share of a right seam that lies along sure or probable welds; otherwise it counts as optional.


@dataclass(frozen=True, slots=True)
class Samples:
    """Points along a line, shape (n, 3), their share of its length, shape (n,), and its directions, shape (n, 3)."""

    p: FloatArray
    length: FloatArray
    way: FloatArray

    @property
    def total_mm(self) -> float:
        return float(self.length.sum())


def sampled(points: FloatArray) -> Samples:
    """Return the middles of pieces of at most `STEP_MM` of a line of shape (n, 3)."""
    step = np.diff(points, axis=0)
    length = np.linalg.norm(step, axis=1)
    start, step, length = points[:-1][length > 0], step[length > 0], length[length > 0]
    count = np.maximum(1, np.ceil(length / STEP_MM)).astype(int)
    row = np.repeat(np.arange(len(count)), count)
    k = np.arange(len(row)) - np.repeat(np.cumsum(count) - count, count)
    share = ((k + 0.5) / count[row])[:, None]
    return Samples(start[row] + step[row] * share, (length / count)[row], (step / length[:, None])[row])


def along(samples: Samples, other: Samples, within_mm: FloatArray) -> BoolArray:
    """Tell which samples lie along other lines, shape (n,): near a parallel sample of them.

    `within_mm`: shape (m,). For each sample of `other`, how near.
    """
    near: BoolArray = np.zeros(len(samples.p), dtype=bool)
    if len(samples.p) and len(other.p):
        most_mm = float(within_mm.max())
        pairs = cKDTree(samples.p).sparse_distance_matrix(cKDTree(other.p), most_mm, output_type="ndarray")
        i, j = pairs["i"], pairs["j"]
        cosine = np.abs(np.einsum("ij,ij->i", samples.way[i], other.way[j]))
        near[i[(cosine > LEAST_COSINE) & (pairs["v"] <= within_mm[j])]] = True
    return near


@dataclass(frozen=True, slots=True)
class Found:
    """Welds of one class: how many of them and how much of their length is found."""

    found: int
    of: int
    found_mm: float
    of_mm: float


@dataclass(frozen=True, slots=True)
class WeldScore:
    """The seams of one part against its list."""

    part: str
    sure: Found
    probable: Found
    accepted: int
    right: int
    optional: int
    accepted_mm: float
    right_mm: float
    optional_mm: float
    missed: tuple[dict[str, Any], ...] = field(default=(), repr=False)
    wrong_seams: tuple[dict[str, Any], ...] = field(default=(), repr=False)

    @property
    def wrong(self) -> int:
        return self.accepted - self.right - self.optional

    @property
    def wrong_mm(self) -> float:
        return self.accepted_mm - self.right_mm - self.optional_mm

    def to_record(self) -> dict[str, Any]:
        """Return the score as it is written in JSON."""
        classes = {
            name: {"found": c.found, "of": c.of, "found_mm": round(c.found_mm, 1), "of_mm": round(c.of_mm, 1)}
            for name, c in (("sure", self.sure), ("probable", self.probable))
        }
        numbers = {"accepted": self.accepted, "right": self.right, "optional": self.optional, "wrong": self.wrong}
        lengths = {f"{name}_mm": round(getattr(self, f"{name}_mm"), 1) for name in numbers}
        lists = {"missed": list(self.missed), "wrong_seams": list(self.wrong_seams)}
        return {"part": self.part, **classes, **numbers, **lengths, **lists}


def seam_samples(seam: Mapping[str, Any]) -> Samples:
    """Return samples of a seam of `seams.json`; a closed one ends where it begins."""
    points = np.array([frame["p_mm"] for frame in seam["frames"]], dtype=np.float64).reshape(-1, 3)
    if seam["closed"] and len(points) and np.linalg.norm(points[0] - points[-1]) > 1e-3:
        points = np.vstack([points, points[:1]])
    return sampled(points)


def score(part: str, welds: Sequence[Weld], seams: Sequence[Mapping[str, Any]]) -> WeldScore:
    """Compare the accepted seams of a part (`seams` of `seams.json`, frame part) with its list."""
    accepted = [seam for seam in seams if seam["accepted"]]
    runs = [seam_samples(seam) for seam in accepted]
    listed = [sampled(weld.points) for weld in welds]
    every = _joined(runs)
    missed: list[dict[str, Any]] = []
    classes = {
        cls: _found(cls, [pair for pair in zip(welds, listed, strict=True) if pair[0].cls == cls], every, missed)
        for cls in (SURE, PROBABLE)
    }
    counts = {"right": 0, "optional": 0}
    lengths = {"right_mm": 0.0, "optional_mm": 0.0}
    wrong = []
    ends = np.cumsum([len(run.p) for run in runs], dtype=int)
    hits, optionals = (np.split(_on_welds(every, welds, listed, wanted=wanted), ends)[:-1] for wanted in (True, False))
    for seam, run, hit, optional in zip(accepted, runs, hits, optionals, strict=True):
        right_mm, either_mm = float(run.length[hit].sum()), float(run.length[hit | optional].sum())
        lengths["right_mm"] += right_mm
        lengths["optional_mm"] += float(run.length[optional & ~hit].sum())
        if either_mm >= COVERED * run.total_mm:
            counts["right" if right_mm >= HALF * run.total_mm else "optional"] += 1
        else:
            wrong.append(_wrong_record(seam, run, either_mm))
    total = sum(run.total_mm for run in runs)
    sure, probable = classes[SURE], classes[PROBABLE]
    return WeldScore(
        part,
        sure,
        probable,
        len(accepted),
        **counts,
        accepted_mm=total,
        **lengths,
        missed=tuple(missed),
        wrong_seams=tuple(wrong),
    )


def _joined(runs: Sequence[Samples]) -> Samples:
    """Return the samples of several lines as one."""
    if not runs:
        return sampled(np.zeros((0, 3)))
    return Samples(
        np.concatenate([run.p for run in runs]),
        np.concatenate([run.length for run in runs]),
        np.concatenate([run.way for run in runs]),
    )


def _found(cls: str, pairs: Sequence[tuple[Weld, Samples]], every: Samples, missed: list[dict[str, Any]]) -> Found:
    """Return what is found of one class, and append to `missed` what is not."""
    count, found_mm = 0, 0.0
    for weld, samples in pairs:
        within_mm = np.full(len(every.p), weld.tol_mm + SLACK_MM)
        covered = float(samples.length[along(samples, every, within_mm)].sum())
        found_mm += covered
        if covered >= COVERED * samples.total_mm:
            count += 1
        else:
            share = round(covered / samples.total_mm, 2)
            place = np.round(weld.points[len(weld.points) // 2], 1).tolist()
            facts = {"id": weld.name, "class": cls, "kind": weld.kind, "members": list(weld.members)}
            missed.append({**facts, "length_mm": round(samples.total_mm, 1), "found": share, "at_mm": place})
    return Found(count, len(pairs), found_mm, sum(samples.total_mm for _, samples in pairs))


def _on_welds(every: Samples, welds: Sequence[Weld], listed: Sequence[Samples], *, wanted: bool) -> BoolArray:
    """Tell which samples of seams lie along welds that are wanted, or along optional ones, shape (n,)."""
    pairs = [pair for pair in zip(welds, listed, strict=True) if (pair[0].cls != OPTIONAL) is wanted]
    within_mm = np.repeat([weld.tol_mm + SLACK_MM for weld, _ in pairs], [len(samples.p) for _, samples in pairs])
    return along(every, _joined([samples for _, samples in pairs]), within_mm)


def _wrong_record(seam: Mapping[str, Any], run: Samples, either_mm: float) -> dict[str, Any]:
    """Return what a person needs to find a wrong seam: its name, kind, members, length and middle."""
    facts = {key: seam[key] for key in ("name", "joint", "weld", "solids") if key in seam}
    place = np.round(run.p[len(run.p) // 2], 1).tolist() if len(run.p) else None
    share = round(either_mm / run.total_mm, 2) if run.total_mm else 0.0
    return {**facts, "length_mm": round(run.total_mm, 1), "on_welds": share, "at_mm": place}
