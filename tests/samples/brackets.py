"""Brackets drawn at random: a base plate with webs, gussets and tube posts, as solids that touch.

What stands on the base does not overlap, so every seam between two solids is one that a welder would see.
"""

from pathlib import Path

import numpy as np

from cad.kernel.call import kernel_call
from cad.kernel.primitives import box, cut, cylinder, prism
from cad.samples.parts import DARK, STEEL
from cad.step.new_file import Member, new_step_text
from wpcal.core.records import write_file

MOST_TRIES = 40
GAP_MM = 4.0  #: Between what does not touch: a wire passes, a nozzle does not.


def bracket(rng: np.random.Generator) -> list[Member]:
    """Draw one bracket, lengths in whole mm."""
    return _Drawing(rng).members


class _Drawing:
    """A base plate, and what was found room for on it."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.rng = rng
        self.size = np.array([rng.integers(180, 420), rng.integers(140, 300)])
        self.thick = int(rng.integers(8, 16))
        self.taken: list[np.ndarray] = []
        self.members: list[Member] = [("base", box(*map(int, self.size), self.thick, (0, 0, 0)), STEEL)]
        for number in range(int(rng.integers(2, 6))):
            self._stand(number)

    def _stand(self, number: int) -> None:
        """Put a web along x or y, or a tube post, where there is room."""
        room = next((room for room in map(self._room, range(MOST_TRIES)) if self._is_free(room)), None)
        if room is None:
            return
        self.taken.append(room)
        (x, y), (a, b) = room[0].tolist(), (room[1] - room[0]).tolist()
        height = int(self.rng.integers(30, 140))
        if a == b:
            foot = (x + a / 2, y + a / 2, self.thick)
            post, bore = (cylinder(radius, height, foot, (0, 0, 1)) for radius in (a / 2, a / 2 - 4))
            self.members.append((f"post {number}", cut(post, bore), DARK))
            return
        self.members.append((f"web {number}", box(a, b, height, (x, y, self.thick)), DARK))
        if self.rng.random() < 0.6:
            self._stiffen(number, room, height)

    def _room(self, _: int) -> np.ndarray:
        """Draw the least and the greatest corner of a rectangle on the base, shape (2, 2)."""
        kind, web = self.rng.integers(3), int(self.rng.integers(5, 13))
        long = int(self.rng.integers(60, int(0.8 * self.size[0 if kind == 0 else 1])))
        size = np.array([(long, web), (web, long), (40, 40)][kind])
        low = self.rng.integers(10, np.maximum(self.size - size - 9, 11))
        return np.stack([low, low + size])

    def _is_free(self, room: np.ndarray, beside: np.ndarray | None = None) -> bool:
        near = [other for other in self.taken if other is not beside and _near(room, other)]
        return bool((room[1] <= self.size - 5).all()) and not near

    def _stiffen(self, number: int, web: np.ndarray, height: int) -> None:
        """Put a triangle between a web and the base, if there is room beside the web."""
        along = int(np.argmax(web[1] - web[0]))
        sheet, leg = int(self.rng.integers(5, 11)), int(min(self.rng.integers(25, 60), height - 5))
        low, size = np.empty(2, dtype=int), np.empty(2, dtype=int)
        low[along], size[along] = self.rng.integers(web[0, along] + 5, web[1, along] - sheet - 4), sheet
        low[1 - along], size[1 - along] = web[1, 1 - along], leg
        room = np.stack([low, low + size])
        if not self._is_free(room, beside=web):
            return
        self.taken.append(room)
        corners = np.zeros((3, 3))
        corners[:, :2], corners[:, 2] = low, self.thick
        corners[1, 1 - along] += leg
        corners[2, 2] += leg
        way = np.zeros(3)
        way[along] = sheet
        self.members.append((f"gusset {number}", prism([tuple(p) for p in corners], tuple(way)), STEEL))


def _near(one: np.ndarray, other: np.ndarray) -> bool:
    return bool((one[0] < other[1] + GAP_MM).all() and (other[0] < one[1] + GAP_MM).all())


def write_bracket(seed: int, folder: Path) -> Path:
    """Write the bracket of a seed as STEP."""
    path = folder / f"bracket{seed}.step"
    with kernel_call("making a bracket"):
        members = bracket(np.random.default_rng(seed))
    write_file(path, new_step_text(members, f"bracket{seed}"), overwrite=True)
    return path
