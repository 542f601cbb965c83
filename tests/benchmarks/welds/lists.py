"""Lists of the welds of a part: read, written, and built from lines and arcs.

A list says where a welder would weld. `fixtures/welds/schema.json` describes the file,
`fixtures/welds/README.md` the rules.
"""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.core.arrays import FloatArray

FOLDER = Path(__file__).parents[3] / "fixtures" / "welds"
SCHEMA = "wpcal/welds/1"
SURE, PROBABLE, OPTIONAL = "A", "B", "O"
"""Any welder would weld it; most would; it counts neither as missed nor as wrong."""
USUAL_TOL_MM = 2.0
"""How far a seam may lie from the line of a fillet: a root edge, a fit-up gap or a radius moves it by so much."""
ARC_STEP_DEG = 3.0  #: Of the points on arcs: a chord of 3 degrees leaves a circle of 100 mm by 0.03 mm.


@dataclass(frozen=True, slots=True)
class Weld:
    """One weld of a list: a line in part coordinates, mm."""

    name: str
    members: tuple[str, ...]  #: Names of the bodies that it joins. A weld inside one fused body names that body once.
    kind: str  #: In words: tee fillet, flare bevel, lap fillet ….
    cls: str  #: `SURE`, `PROBABLE` or `OPTIONAL`.
    points: FloatArray  #: shape (n, 3). Its line. The first point of a closed weld is repeated at the end.
    tol_mm: float = USUAL_TOL_MM  #: How far a seam may lie from the line.

    @property
    def closed(self) -> bool:
        return len(self.points) > 2 and bool(np.allclose(self.points[0], self.points[-1], atol=1e-6))

    @property
    def length_mm(self) -> float:
        return float(np.linalg.norm(np.diff(self.points, axis=0), axis=1).sum())

    def to_record(self) -> dict[str, Any]:
        return {
            "id": self.name,
            "members": list(self.members),
            "kind": self.kind,
            "class": self.cls,
            "closed": self.closed,
            "length_mm": round(self.length_mm, 2),
            "tol_mm": self.tol_mm,
            "points_mm": (np.round(self.points, 3) + 0.0).tolist(),
        }


def read_record(path: Path) -> dict[str, Any]:
    """Return a list as it is in its file."""
    record: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
    return record


def welds_of(record: dict[str, Any]) -> tuple[Weld, ...]:
    """Return the welds of a list."""
    return tuple(
        Weld(
            item["id"],
            tuple(item["members"]),
            item["kind"],
            item["class"],
            np.array(item["points_mm"], dtype=np.float64),
            item["tol_mm"],
        )
        for item in record["welds"]
    )


def to_json(record: dict[str, Any]) -> str:
    """Return a list as text: one line per weld, so that a change of a list can be read."""
    welds = ",\n".join(f"  {json.dumps(weld, ensure_ascii=False)}" for weld in record["welds"])
    bodies = ",\n".join(f"  {json.dumps(body, ensure_ascii=False)}" for body in record["bodies"])
    head = {key: value for key, value in record.items() if key not in ("welds", "bodies")}
    text = json.dumps(head, indent=1, ensure_ascii=False)[:-2]
    return f'{text},\n "bodies": [\n{bodies}\n ],\n "welds": [\n{welds}\n ]\n}}\n'


def sha256(path: Path) -> str:
    return hashlib.sha256(path.read_bytes()).hexdigest()


# ---- lines ----------------------------------------------------------------------------------------------------------


def line(*points: Sequence[float]) -> FloatArray:
    """Return a line through corners, shape (n, 3)."""
    return np.array(points, dtype=np.float64)


def loop(*points: Sequence[float]) -> FloatArray:
    """Return a closed line through corners, shape (n + 1, 3)."""
    return line(*points, points[0])


def arc(
    centre: Sequence[float], axis: Sequence[float], start: Sequence[float], radius: float, turn_deg: float = 360.0
) -> FloatArray:
    """Return an arc about an axis, from the direction `start`, shape (n, 3)."""
    z = np.array(axis, dtype=np.float64) / np.linalg.norm(axis)
    x = np.array(start, dtype=np.float64)
    x -= (x @ z) * z
    x /= np.linalg.norm(x)
    angles = np.radians(np.linspace(0.0, turn_deg, max(2, round(abs(turn_deg) / ARC_STEP_DEG) + 1)))[:, None]
    points: FloatArray = np.array(centre) + radius * (np.cos(angles) * x + np.sin(angles) * np.cross(z, x))
    if abs(turn_deg) == 360.0:
        points[-1] = points[0]
    return points


def circle(centre: Sequence[float], axis: Sequence[float], radius: float) -> FloatArray:
    """Return a whole circle, shape (n, 3)."""
    return arc(centre, axis, (1, 0, 0) if abs(axis[0]) < 0.9 else (0, 1, 0), radius)


def turned_z(points: FloatArray, degrees: float) -> FloatArray:
    """Return points of shape (n, 3) turned about the z axis."""
    c, s = np.cos(np.radians(degrees)), np.sin(np.radians(degrees))
    return points @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
