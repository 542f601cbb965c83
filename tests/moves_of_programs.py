"""What controllers do with written programs: the moves along one seam are interpolated, without wpcal.

The moves between ARC ON and ARC OFF come from `tests.program_text`. Sources of what controllers do between two poses:
`wpcal.robot.moves.interpolation`.
"""

from collections.abc import Callable
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from tests.program_text import READERS as TEXTS
from tests.program_text import Pose

VIA_TURNS = ("fanuc", "inform", "val3", "as")
"""Controllers that turn the tool through the pose in the middle of an arc."""


class Step(NamedTuple):
    """One move: the pose in its middle (None for a line), and that at its end."""

    via: Pose | None
    to: Pose


class Weld(NamedTuple):
    """The moves along a seam; `uses_via`: the controller turns the tool through the pose in the middle of an arc."""

    start: Pose
    steps: list[Step]
    uses_via: bool


def welds_of(name: str, files: dict[str, str]) -> list[Weld]:
    """The moves along each seam of a program, in its order."""
    found = TEXTS[name](files)
    events = found.routines[0]
    kinds = [event.kind for event in events]
    poses = [[found.poses[name] for name in event.names] for event in events]
    return [
        Weld(
            poses[on - 1][-1],
            [Step(None, *own) if len(own) == 1 else Step(*own) for own in poses[on + 1 : kinds.index("ARC OFF", on)]],
            uses_via=name in VIA_TURNS,
        )
        for on, kind in enumerate(kinds)
        if kind == "ARC ON"
    ]


def weld_of(name: str, files: dict[str, str]) -> Weld:
    """The moves of a program with one seam."""
    return welds_of(name, files)[0]


READERS: dict[str, Callable[[dict[str, str]], Weld]] = {
    name: partial(weld_of, name) for name in ("rapid", "krl", "fanuc", "inform", "urscript", "val3", "as")
}


def followed(weld: Weld, count: int) -> Pose:
    """Return the tool at `count` places of every move: positions (m, 3), mm, and the rotations."""
    t, (p0, R0) = np.linspace(0.0, 1.0, count), weld.start
    places, turns = [], []
    for via, (p1, R1) in weld.steps:
        middle = 0.5
        if via is None:
            places.append(p0 + t[:, None] * (p1 - p0))
        else:
            centre, normal, sweep, middle = circle_through(p0, via[0], p1)
            places.append(centre + Rotation.from_rotvec(np.outer(t * sweep, normal)).apply(p0 - centre))
        if via is not None and weld.uses_via:
            slerp = Slerp([0.0, middle, 1.0], Rotation.concatenate([R0, via[1], R1]))
        else:
            slerp = Slerp([0.0, 1.0], Rotation.concatenate([R0, R1]))
        turns.append(slerp(t))
        p0, R0 = p1, R1
    return np.concatenate(places), Rotation.concatenate(turns)


def circle_through(a: Any, b: Any, c: Any) -> tuple[Any, Any, float, float]:
    """Return centre, axis, angle from a through b to c, and the share of it at b."""
    e1 = (c - a) / np.linalg.norm(c - a)
    e2 = (b - a) - ((b - a) @ e1) * e1
    e2 /= np.linalg.norm(e2)
    half, (u, v) = np.linalg.norm(c - a) / 2, ((b - a) @ e1, (b - a) @ e2)
    height = (u * u + v * v - 2 * u * half) / (2 * v)
    centre = a + half * e1 + height * e2
    normal = np.cross(e2, e1)  # from a over b, which is on the side of e2, to c

    def angle(q: Any) -> float:
        r = a - centre
        return float(np.arctan2((q - centre) @ np.cross(normal, r), (q - centre) @ r) % (2 * np.pi))

    return centre, normal, angle(c), angle(b) / angle(c)
