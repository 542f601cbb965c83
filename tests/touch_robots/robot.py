"""An arm without joints that holds a wire: it moves on lines, feels the part, and fails where it drives into it.

What a language knows (frames, tools, signals) is in the module of that language. Here are the true things: where the
part stands, where on the flange the wire is, how late the controller notices a contact, and how it stops.
"""

from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation, Slerp

from tests.touch_robots.solid import NEAR_MM, Array, Solid, distance
from tests.touch_robots.sweep import way_to_contact
from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.machine import Place, ProgramError, rigid
from wpcal.core.same_bits import inverse_pose

TOUCH_MM = 1e-6  #: Wire and part closer than this touch.
LEAST_STEP_MM = 0.02  #: Between two looks on the way through the air.
LEAVING_MM = 2.0  #: The wire is free of what it touched after this way.


class CrashError(AssertionError):
    """The wire or the nozzle was driven into the part where nothing looked for it."""


@dataclass
class Torch:
    """The true wire: it leaves the flange at `T_flange_tool`, whose z it follows."""

    T_flange_tool: Array
    wire_mm: float = 1.2
    stick_out_mm: float = 15.0
    nozzle_radius_mm: float = 0.0
    """0: no nozzle."""
    nozzle_length_mm: float = 60.0


@dataclass
class Senses:
    """How the controller notices a contact."""

    latency_s: float = 0.0
    """From contact to the place that is stored."""
    stop_s: float = 0.0
    """From there until the robot stands, at half the speed."""
    sigma_mm: float = 0.0
    """Of the stored place, per axis."""
    rng: np.random.Generator = field(default_factory=lambda: np.random.default_rng(0))
    always_on: bool = False
    """The wire is stuck to something: the signal never ends."""
    never_on: bool = False
    """The sensing voltage is not there."""


@dataclass
class Hit:
    """One search as it happened, in the base: the true pose at contact, and the stored one."""

    T_base_tool: Array
    stored: Array | None
    """None where the program asks for it."""


class Robot:
    """Moves the tool of a program; the true wire follows through the flange."""

    def __init__(self, solid: Solid, torch: Torch, senses: Senses | None = None) -> None:
        self.solid, self.torch, self.senses = solid, torch, senses or Senses()
        self.T_base_flange: Array | None = rigid(Rotation.from_euler("x", np.pi).as_matrix(), [500.0, 0.0, 1500.0])
        self.hits: list[Hit] = []
        self.at = Place("", 0)
        self.is_home = False
        self.air_mm = 0.0
        self._stands_at_touch = False

    # -- where things are ------------------------------------------------------------------------------------------

    def T_base_tool(self, T_flange_tool: Array) -> Array:
        if self.T_base_flange is None:
            raise ProgramError("the place of the robot is asked for before its first move to a point")
        return self.T_base_flange @ T_flange_tool

    def stand(self) -> None:
        """Every motion of this robot has ended."""

    def is_on(self) -> bool:
        """Return whether the touch signal is on."""
        if self.senses.always_on or self.senses.never_on or self.T_base_flange is None:
            return self.senses.always_on
        return self._stands_at_touch or self._gap(self.T_base_flange) <= TOUCH_MM

    def _wire(self, T_base_flange: Array) -> tuple[Array, Array, Array]:
        T = T_base_flange @ self.torch.T_flange_tool
        tip, along = T[:3, 3], T[:3, 2]
        return tip, tip - self.torch.stick_out_mm * along, along

    def _gap(self, T_base_flange: Array) -> float:
        """Return how far the wire is from the part; negative within its radius.

        At the tip it is taken for a line that leaves a ball: never thicker than it is.
        """
        tip, tail, along = self._wire(T_base_flange)
        low, high = np.minimum(tip, tail), np.maximum(tip, tail)
        near = self.solid.near(low, high)
        radius = 0.5 * self.torch.wire_mm
        if len(near) == 0:
            return max(NEAR_MM, self.solid.beyond(low, high)) - radius
        return min(distance(near, tip, tail), distance(near, tip - radius * along, tail) - radius, NEAR_MM)

    # -- moves -----------------------------------------------------------------------------------------------------

    def joint_move(self, joints: Array | None = None, **_: Any) -> None:
        """Move to joint angles: without an arm nobody knows where that is."""
        self.T_base_flange, self.is_home = None, True

    def move(self, T_base_tool: Array, T_flange_tool: Array, *, is_line: bool = True) -> None:
        """Go to a pose on a line, turning evenly. The part must not be in the way, without a line at its end only."""
        goal = T_base_tool @ inverse_pose(T_flange_tool)
        start, self.T_base_flange = self.T_base_flange, goal
        self._stands_at_touch = False
        self._check(start if start is not None and is_line else goal, goal)

    def arc(self, via: Array, goal: Array, T_flange_tool: Array) -> None:
        """Touch programs have no arcs."""
        raise ProgramError("an arc in a touch program")

    def switch(self, does: Does) -> None:
        """Nothing is welded here."""

    def output(self, number: object, value: object) -> None:
        """The sensing voltage is always there, unless `senses` say otherwise."""

    def refuse(self, error: ProgramError) -> None:
        """End the run."""
        raise error

    def _check(self, start: Array, goal: Array) -> None:
        begin, end = (T @ self.torch.T_flange_tool for T in (start, goal))
        way = float(np.linalg.norm(end[:3, 3] - begin[:3, 3]))
        turn = Rotation.from_matrix(np.stack([begin[:3, :3], end[:3, :3]]))
        angle = float((turn[0].inv() * turn[1]).magnitude())
        reach = self.torch.stick_out_mm + (self.torch.nozzle_length_mm if self.torch.nozzle_radius_mm else 0.0)
        span = way + angle * reach
        self.air_mm += way
        between = Slerp([0.0, 1.0], turn)
        at, leaving = 0.0, span > 0.0 and self._gap(start) <= TOUCH_MM
        while at <= 1.0:
            place = begin[:3, 3] + at * (end[:3, 3] - begin[:3, 3])
            T = rigid(between(at).as_matrix(), place) @ inverse_pose(self.torch.T_flange_tool)
            gap = self._gap(T)
            if gap > TOUCH_MM:
                leaving = False
            elif not leaving or at * span > LEAVING_MM:
                raise CrashError(
                    f"the wire meets the part {at * way:.2f} mm after the beginning of a move of {way:.1f}"
                )
            free = self._nozzle_gap(T)
            if free < 0.0:
                raise CrashError(
                    f"the nozzle meets the part {at * way:.2f} mm after the beginning of a move of {way:.1f}"
                )
            if at == 1.0:
                return
            at = min(1.0, at + max(min(gap, free), LEAST_STEP_MM) / max(span, TOUCH_MM))

    def _nozzle_gap(self, T_base_flange: Array) -> float:
        radius = self.torch.nozzle_radius_mm
        if radius == 0.0:
            return np.inf
        _, tail, along = self._wire(T_base_flange)
        mouth, back = tail - radius * along, tail - self.torch.nozzle_length_mm * along
        reach = np.full(3, radius)
        near = self.solid.near(np.minimum(mouth, back) - reach, np.maximum(mouth, back) + reach)
        if len(near) == 0:
            return max(NEAR_MM, self.solid.beyond(np.minimum(mouth, back), np.maximum(mouth, back)) - radius)
        return min(distance(near, mouth, back) - radius, NEAR_MM)

    def search(
        self, T_base_tool: Array, T_flange_tool: Array, speed_mm_s: float, *, is_edge: bool = True
    ) -> Array | None:
        """Go to a pose on a line until the signal comes; return the stored pose of the tool, or None without one.

        `is_edge`: only a signal that comes on the way counts, not one that is on at the start.
        """
        if self.T_base_flange is None:
            raise ProgramError("a search begins at an unknown place")
        goal = T_base_tool @ inverse_pose(T_flange_tool)
        start = self.T_base_flange
        if self.senses.always_on and not is_edge:
            return self._store(start, start, T_flange_tool, np.zeros(3), speed_mm_s)
        contact = None if self.senses.never_on or self.senses.always_on else self.contact(start, goal)
        if contact is None:
            if self.senses.never_on and self.contact(start, goal) is not None:
                raise CrashError("the wire meets the part on a search whose signal does not come")
            self.T_base_flange = goal
            return None
        along = (goal - start)[:3, 3] / self._way(start, goal)
        return self._store(contact, start, T_flange_tool, along, speed_mm_s)

    def _way(self, start: Array, goal: Array) -> float:
        begin, end = (T @ self.torch.T_flange_tool for T in (start, goal))
        way = float(np.linalg.norm(end[:3, 3] - begin[:3, 3]))
        if not np.allclose(start[:3, :3], goal[:3, :3], rtol=0.0, atol=1e-4):
            raise ProgramError("the tool turns during a search")
        if way < TOUCH_MM:
            raise ProgramError("a search has no length")
        if way < 0.999 * np.linalg.norm((goal - start)[:3, 3]):
            raise ProgramError("the tool turns during a search")
        return way

    def contact(self, start: Array, goal: Array) -> Array | None:
        """Return where on the line from `start` to `goal` the wire meets the part."""
        shift, way = (goal - start)[:3, 3], self._way(start, goal)
        tip, tail, _ = self._wire(start)
        ends = np.array([tip, tail, tip + shift, tail + shift])
        near = self.solid.near(ends.min(axis=0), ends.max(axis=0))
        radius = 0.5 * self.torch.wire_mm
        gone = 0.0 if self._gap(start) <= TOUCH_MM else way_to_contact(near, tip, tail, radius, shift / way)
        if gone > way:
            return None
        T = start.copy()
        T[:3, 3] += shift * gone / way
        return T

    def _store(self, contact: Array, start: Array, T_flange_tool: Array, along: Array, speed: float) -> Array:
        senses = self.senses
        stored, stands = contact.copy(), contact.copy()
        stored[:3, 3] += along * speed * senses.latency_s
        stands[:3, 3] = stored[:3, 3] + along * speed * senses.stop_s * 0.5
        self.T_base_flange, self._stands_at_touch = stands, True
        seen = stored @ T_flange_tool
        if senses.sigma_mm:
            seen[:3, 3] += senses.rng.normal(scale=senses.sigma_mm, size=3)
        self.hits.append(Hit(contact @ T_flange_tool, seen))
        return seen

    def reading(self, T_flange_tool: Array) -> Array:
        """Return where the controller says that the standing tool is: the noise of a stored place is in it as well."""
        seen = self.T_base_tool(T_flange_tool).copy()
        if self.senses.sigma_mm:
            seen[:3, 3] += self.senses.rng.normal(scale=self.senses.sigma_mm, size=3)
        return seen


class Welder(Robot):
    """A robot that also welds: in programs that do not touch it writes down where its tool goes."""

    def __init__(self, *given: Any) -> None:
        super().__init__(*given)
        self.welded: list[Array] = []

    def move(self, T_base_tool: Array, T_flange_tool: Array, *, is_line: bool = True) -> None:
        """Go to a pose; on the way to and along seams nothing is felt."""
        if "touch" in self.at.file:
            super().move(T_base_tool, T_flange_tool, is_line=is_line)
            return
        self.welded.append(T_base_tool)
        self.T_base_flange = T_base_tool @ inverse_pose(T_flange_tool)

    def arc(self, via: Array, goal: Array, T_flange_tool: Array) -> None:
        """Go on an arc."""
        self.move(via, T_flange_tool)
        self.move(goal, T_flange_tool)
