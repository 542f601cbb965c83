"""The frames of seams as records of ``seams.json``, and back; those of all seams are one array per field."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from itertools import accumulate, chain, pairwise
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray, IntArray
from wpcal.core.rotations import quaternion_from_rotation
from wpcal.core.transform import RigidTransform
from wpcal.seam.path.position import weld_positions
from wpcal.seam.seam import Seam, SeamFrames


def frame_records(
    seams: Sequence[Seam],
    T_base_part: RigidTransform | None,
    u95_mm: Sequence[FloatArray] | None,
    columns: Mapping[str, Sequence[FloatArray]] | None = None,
) -> list[list[dict[str, Any]]]:
    """Return the records of the frames of each seam. Frames with the same axes share their lists.

    `u95_mm`: shape (n,). For each seam, the 95 % error at each of its n frames, mm.
    `columns`: shape (n,). More numbers of the frames of each seam, by the name of their field.
    """
    if not seams:
        return []
    counts = [len(seam.frames) for seam in seams]
    frames = SeamFrames.joined([seam.frames for seam in seams])
    frames = frames if T_base_part is None else frames.moved(T_base_part)
    first, turn = _same_axes(frames.R)
    R, q = frames.R[first].tolist(), quaternion_from_rotation(frames.R[first]).tolist()
    fields = (frames.s_mm, frames.p, turn, np.degrees(frames.angle_rad))
    records: list[dict[str, Any]] = [
        {"s_mm": s, "p_mm": p, "R": R[k], "q_xyzw": q[k], "angle_deg": angle}
        for s, p, k, angle in zip(*(field.tolist() for field in fields), strict=True)
    ]
    spans = list(pairwise(accumulate(counts, initial=0)))
    _add_leans(seams, [records[start:end] for start, end in spans])
    known = {} if u95_mm is None else {"u95_mm": u95_mm}
    for name, values in {**known, **(columns or {})}.items():
        for record, value in zip(records, chain.from_iterable(np.asarray(v).tolist() for v in values), strict=True):
            record[name] = value
    if T_base_part is not None:
        _add_positions(seams, counts, frames.R, records)
    return [records[start:end] for start, end in spans]


def _same_axes(R: FloatArray) -> tuple[IntArray, IntArray]:
    """Return a frame of each of the different axes, shape (n, 3, 3), and which each frame has, equal in all bits."""
    bits = np.ascontiguousarray(R).reshape(-1, 9).view(np.dtype((np.void, 9 * R.itemsize))).ravel()
    _, first, number = np.unique(bits, return_index=True, return_inverse=True)
    return first, number


def _add_leans(seams: Sequence[Seam], records: Sequence[list[dict[str, Any]]]) -> None:
    """Add work and travel angle, and the spin if there is one, in degrees; None where no torch gets."""
    leans = [seam.lean_rad for seam in seams if seam.lean_rad is not None]
    degrees = iter(np.degrees(np.concatenate(leans)).tolist() if leans else ())
    for seam, own in zip(seams, records, strict=True):
        if seam.lean_rad is None:
            continue
        spins = [None] * len(own) if seam.spin_rad is None else np.degrees(seam.spin_rad).tolist()
        for record, spin in zip(own, spins, strict=True):
            work, travel = next(degrees)
            turned = {} if spin is None else {"spin": spin}
            record["lean_deg"] = None if math.isnan(work) else {"work": work, "travel": travel, **turned}


def _add_positions(
    seams: Sequence[Seam], counts: Sequence[int], R: FloatArray, records: Sequence[dict[str, Any]]
) -> None:
    """Add slope, rotation and position; `R`, shape (n, 3, 3), are the axes of all n frames in `base`."""
    welds = list(dict.fromkeys(seam.weld for seam in seams))
    own = np.repeat([welds.index(seam.weld) for seam in seams], counts)
    for number, weld in enumerate(welds):
        rows = np.flatnonzero(own == number)
        found = weld_positions(R[rows], weld)
        slope, rotation = np.degrees(found.slope_rad).tolist(), np.degrees(found.rotation_rad).tolist()
        for row, up, around, name in zip(rows.tolist(), slope, rotation, found.name, strict=True):
            records[row]["slope_deg"] = up
            records[row]["rotation_deg"] = None if math.isnan(around) else around
            records[row]["position"] = name


def frames_from_records(rows: Sequence[dict[str, Any]], frame: str) -> SeamFrames:
    """Return the frames of a seam, in the coordinates `frame` of the file."""
    n = len(rows)
    return SeamFrames(
        np.array([row["s_mm"] for row in rows], dtype=np.float64),
        np.array([row["p_mm"] for row in rows], dtype=np.float64).reshape(n, 3),
        np.array([row["R"] for row in rows], dtype=np.float64).reshape(n, 3, 3),
        np.radians([row["angle_deg"] for row in rows]),
        frame,
    )


def leans_from_records(rows: Sequence[dict[str, Any]]) -> tuple[FloatArray | None, FloatArray | None]:
    """Return the leans, and the spins if any frame has one, in radians; NaN where no torch gets."""
    if not rows or any("lean_deg" not in row for row in rows):
        return None, None
    nowhere = {"work": np.nan, "travel": np.nan, "spin": np.nan}
    leans = [row["lean_deg"] or nowhere for row in rows]
    has_spin = any("spin" in lean for lean in leans if lean is not nowhere)
    spins = np.radians([lean.get("spin", 0.0) for lean in leans]) if has_spin else None
    return np.radians([[lean["work"], lean["travel"]] for lean in leans]), spins
