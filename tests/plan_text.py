"""Programs of plans with one robot and a fixed part, read as text and run beside the plan: RAPID and KRL.

Every instruction goes from one place of the plan to a later one. The places between must be on the line, the arc or the
straight move in the joints that the controller makes of it, and configurations must be those of the joints.
"""

import re
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tests.moves_of_programs import circle_through
from tests.plan_faults import AXIS_DEG, PATH_MM
from tests.program_text import READERS as TEXTS
from tests.program_text import Step, numbers
from tests.real_cells import Array, RealCell

JOINT_DEG = 1e-3  #: Rounding of the files, of five decimals and more.
FINER = 10  #: Places between two points of the plan.

Fits = Callable[[str, Array], bool]
"""From the name of a target and joints, deg, to whether its configuration is theirs."""


def rapid(files: dict[str, str]) -> Fits:
    """Read the configurations of a module."""
    (text,) = files.values()
    conf = {n: numbers(c) for n, c in re.findall(r"robtarget (\w+):=\[\[.*?\],\[.*?\],\[(.*?)\]", text)}

    def fits(name: str, q: Array) -> bool:
        quarters = np.abs(np.floor(q[[0, 3, 5]] / 90.0) - conf[name][:3])
        at_edge = np.abs(q[[0, 3, 5]] - 90.0 * np.round(q[[0, 3, 5]] / 90.0)) < JOINT_DEG
        odd = abs(q[4]) < JOINT_DEG or bool(conf[name][3] % 2) == (q[4] < 0.0)
        return bool(((quarters == 0) | at_edge).all() and odd)

    return fits


def krl(files: dict[str, str]) -> Fits:
    """Read the configurations of a module."""
    (data,) = (text for name, text in files.items() if name.endswith(".dat"))
    rows = re.findall(r"E6POS (\w+)=\{.*?S (\d+),T (\d+)", data)
    conf = {name: (int(status), int(turn)) for name, status, turn in rows}

    def fits(name: str, q: Array) -> bool:
        status, turn = conf[name]
        bits = np.array([turn >> k & 1 for k in range(6)])
        good = (bits == (q[:6] < 0.0)) | (np.abs(q[:6]) < JOINT_DEG)
        return bool(good.all() and (status >> 2 & 1 == (q[4] < 0.0) or abs(q[4]) < JOINT_DEG))

    return fits


READERS = {"rapid": rapid, "krl": krl}


def way_of(plan: dict[str, Any], cell: RealCell) -> tuple[Array, Array]:
    """Return the axes (n, k), deg, and the tool in the base (n, 4, 4) at `FINER` places of every step of a plan."""
    points = np.array([point["axes"] for point in plan["points"]])
    at = np.arange((len(points) - 1) * FINER + 1) / FINER
    q = np.stack([np.interp(at, np.arange(len(points)), axis) for axis in points.T], axis=1)
    return q, np.linalg.inv(cell.T_robot) @ np.array([cell.places(np.radians(row))["tool"] for row in q])


def text_faults(language: str, files: dict[str, str], way: tuple[Array, Array], *, chord_mm: float = 0.0) -> list[str]:
    """Return where a program and the way of its plan differ; empty if they do not.

    Plans follow the lines between the frames of a seam, programs write arcs through them: an arc may be off the plan by
    `chord_mm` more, which is measured on the frames (`tests.plan_faults.chord`).
    """
    (q, T), found, now = way, list[str](), -1
    fits, (moves, *_) = READERS[language](files), TEXTS[language](files).steps()
    for move in moves:
        later = slice(max(now, 0), None)
        most_mm = PATH_MM if move.via is None else PATH_MM + chord_mm
        if move.joints is not None:
            off = np.abs(q[later, : len(move.joints)] - move.joints).max(axis=1) / JOINT_DEG
        else:
            turn = Rotation.from_matrix(T[later, :3, :3]) * Rotation.from_matrix(move.goal[:3, :3]).inv()
            off = np.linalg.norm(T[later, :3, 3] - move.goal[:3, 3], axis=1) / most_mm
            off = np.maximum(off, np.degrees(turn.magnitude()) / AXIS_DEG)
        near = np.flatnonzero(off <= 1.0)
        if not len(near):
            return [*found, f"{move.name} is not on the plan after point {max(now, 0) // FINER + 1}"]
        run = near[: int(np.argmax(np.diff(near, append=near[-1] + 2) > 1)) + 1]  # the first places in a row
        to = max(now, 0) + int(run[np.argmin(off[run])])
        name = f"{move.name} (point {to / FINER + 1:.1f})"
        if move.joints is None and not fits(move.name, q[to]):
            found.append(f"{name} has another configuration")
        beside = _off(move, q[now : to + 1], T[now : to + 1]) if 0 <= now < to else 0.0
        if beside > (JOINT_DEG if move.joints is not None else most_mm):
            found.append(f"{name}: the plan is {beside:.3f} off its way")
        now = to
    return (
        found
        if now == len(q) - 1
        else [*found, f"the program ends at point {now / FINER + 1:.1f} of {len(q) // FINER + 1}"]
    )


def _off(move: Step, q: Array, T: Array) -> float:
    """Return how far the points between are from the way of the controller, deg or mm."""
    if move.joints is not None:
        step = q[-1] - q[0]
        share = (q - q[0]) @ step / (step @ step)
        return float(np.abs(q - q[0] - share[:, None] * step).max())
    p = T[:, :3, 3]
    if move.via is None:
        step = p[-1] - p[0]
        share = (p - p[0]) @ step / max(float(step @ step), 1e-12)
        return float(np.linalg.norm(p - p[0] - share[:, None] * step, axis=1).max())
    centre, normal, _, _ = circle_through(p[0], move.via[:3, 3], p[-1])
    radius = np.linalg.norm(p[0] - centre)
    height = (p - centre) @ normal
    flat = np.linalg.norm(p - centre - height[:, None] * normal, axis=1)
    return float(np.hypot(height, flat - radius).max())
