"""Faults of a whole plan of one robot, found without wpcal: from the written files, the URDF files and real meshes."""

import json
from pathlib import Path
from typing import Any

import numpy as np

from tests.real_cells import Array, RealCell, of_record

FINER = 10  #: States between two of the plan.
PATH_MM, AXIS_DEG = 0.1, 1.0
"""The asked tolerance of 0.05 mm, and as much again for what a straight line in the joints leaves between points."""
ROUND_OFF = 1e-6  #: Relative: numbers of files are rounded.
MOST = 5  #: Faults of one kind that are listed.


def plan_faults(
    folder: Path,
    cell_json: Path,
    urdfs: dict[str, Path],
    seams_json: Path,
    part: Array | None,
    coupled: tuple[tuple[str, str], ...] = (),
) -> list[str]:
    """Return what is wrong with the plan in a folder; empty if nothing is.

    `coupled`: joints whose angles in the plan do not hold the motion of another one, which the URDF file adds.
    """
    plan = json.loads((folder / "plan.json").read_text(encoding="utf-8"))
    T = of_record(plan["T_carrier_part"])
    cell = RealCell(cell_json, urdfs, part, T)
    points = plan["points"]
    q = np.radians([point["axes"] for point in points])
    t = np.array([point["t_s"] for point in points])
    limits = _limits(cell, q, t)[:MOST]
    for joint, other in coupled:
        q[:, cell.robot.number[joint]] += q[:, cell.robot.number[other]]
    return [
        *limits,
        *_hits(cell, points, q)[:MOST],
        *_off_path(cell, plan, points, q, seams_json)[:MOST],
        *_missing(plan, points, seams_json)[:MOST],
    ]


def _limits(cell: RealCell, q: Array, t: Array) -> list[str]:
    every = [*cell.robot.limits, *(cell.turn.limits if cell.turn else [])]
    found = []
    for axis, (low, high, speed) in enumerate(every[: q.shape[1]]):
        if q[:, axis].min() < low - ROUND_OFF or q[:, axis].max() > high + ROUND_OFF:
            found.append(f"axis {axis + 1} is beyond its limits")
        fast = np.abs(np.diff(q[:, axis])) / np.diff(t)
        if fast.max() > speed * (1 + 1e-4):
            found.append(f"axis {axis + 1} turns with {fast.max():.3f} rad/s, {speed:.3f} allowed")
    return found


def _hits(cell: RealCell, points: list[dict[str, Any]], q: Array) -> list[str]:
    found = []
    for row in range(len(q) - 1):
        for share in np.arange(FINER) / FINER:
            hit = cell.collision(q[row] + share * (q[row + 1] - q[row]))
            if hit:
                found.append(f"point {row + 1} ({points[row]['phase']}): {hit[0]} meets {hit[1]}")
                break
    return found


def _off_path(
    cell: RealCell, plan: dict[str, Any], points: list[dict[str, Any]], q: Array, seams_json: Path
) -> list[str]:
    record = json.loads(seams_json.read_text(encoding="utf-8"))
    seams = {seam["name"]: seam for seam in record["seams"]}
    of = {piece["name"]: piece["seam"] for piece in plan["seams"]}
    to_part = np.eye(4)
    found = []
    for row in range(len(q) - 1):
        one, two = points[row], points[row + 1]
        if two["phase"] != "weld" or one["s_mm"] is None or one["seam"] != two["seam"] or two["seam"] not in of:
            continue
        seam = seams[of[two["seam"]]]
        if record.get("T_base_part") is not None and seam.get("frame", record.get("frame")) != "part":
            to_part = np.linalg.inv(np.array(record["T_base_part"]))
        frames = np.array([frame["p_mm"] for frame in seam["frames"]]) @ to_part[:3, :3].T + to_part[:3, 3]
        for share in np.arange(FINER + 1) / FINER:
            at = cell.places(q[row] + share * (q[row + 1] - q[row]))
            tip = (np.linalg.inv(at["part"]) @ at["tool"])[:3, 3]
            off = distance(tip, frames)
            if off > PATH_MM + chord(frames):
                found.append(f"{two['seam']} at {two['s_mm']:.1f} mm: {off:.2f} mm off the seam")
                break
    return found


def distance(p: Array, line: Array) -> float:
    """Return the distance of a point from a row of points joined by lines, mm."""
    a, u = line[:-1], np.diff(line, axis=0)
    share = np.clip(np.einsum("ij,ij->i", p - a, u) / np.maximum((u**2).sum(axis=1), 1e-12), 0.0, 1.0)
    return float(np.linalg.norm(a + share[:, None] * u - p, axis=1).min())


def chord(line: Array) -> float:
    """Return how far a smooth curve may be off the lines between its points, mm: an eighth of the bend of each step."""
    if len(line) < 3:
        return 0.0
    bend = np.linalg.norm(np.diff(line, n=2, axis=0), axis=1)
    return float(np.median(bend)) / 8.0


def _missing(plan: dict[str, Any], points: list[dict[str, Any]], seams_json: Path) -> list[str]:
    """Return accepted seams of which a stretch is neither welded nor told."""
    record = json.loads(seams_json.read_text(encoding="utf-8"))
    found = []
    for seam in record["seams"]:
        if not seam["accepted"]:
            continue
        own = [piece for piece in plan["seams"] if piece["seam"] == seam["name"]]
        names = {piece["name"] for piece in own}
        s = [point["s_mm"] for point in points if point["seam"] in names and point["s_mm"] is not None]
        told = sum(gap["to_mm"] - gap["from_mm"] for gap in plan["unwelded"] if gap["seam"] == seam["name"])
        welded = sum(abs(piece["to_mm"] - piece["from_mm"]) for piece in own)
        reached = max(s, default=0.0) - min(s, default=0.0)
        first = next((row for row, point in enumerate(points) if point["seam"] in names), 0)
        if first and points[first]["phase"] == "weld" and len(s) > 1:  # no approach: the move before ends on the seam
            reached += abs(s[1] - s[0])
        if welded + told < seam["length_mm"] - 0.5 or (not told and reached < seam["length_mm"] - 0.5):
            found.append(f"{seam['name']}: {welded:.0f} of {seam['length_mm']:.0f} mm welded, {told:.0f} mm told")
    return found
