"""The shape of the torch: seams are judged with it, and every pose and move of a program is compared with the part."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.robot.moves.sweep import Reaching

CHORD_DEG = 12.0
"""The bend of a neck is felt as straight tubes that turn by at most this: they are within 0.6 % of its radius."""
WIRE_STEP_MM = 2.5  #: Steps in which a longer wire is tried: what an operator sets by eye.
CONE_STEP_MM = 0.5  #: A cone that is felt as straight tubes is felt at most this much wider than it is.
CORNERS = 64  #: Planners measure round pieces as prisms around them with this many sides.
PRISM = 1.0 / math.cos(math.pi / CORNERS)  #: This much wider is a prism at its corners: 0.12 %.
LONGER_WIRE_MM = 50.0  #: No wire welds that sticks out by this much more than usual: it glows and bends.


@dataclass(frozen=True, slots=True)
class Neck:
    """What is behind the nozzle of a torch: a neck that may bend, and the body on it."""

    angle_deg: float  #: By how much the neck bends away from the wire; 0 is straight.
    from_mm: float  #: From the mouth of the nozzle to where the bend begins.
    bend_mm: float  #: Radius of the centre line of the bend.
    radius_mm: float  #: Outer radius of the neck.
    body_from_mm: float  #: From the mouth along the centre line to where the body begins; behind the bend.
    body_radius_mm: float  #: Outer radius of the body.

    def __post_init__(self) -> None:
        for name in ("from_mm", "radius_mm", "body_from_mm", "body_radius_mm"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(f"torch neck {name}: expected a positive number, got {getattr(self, name):g}")
        if not 0.0 <= self.bend_mm < math.inf:
            raise InputError(f"torch neck bend_mm: expected 0 or more, got {self.bend_mm:g}")
        if not 0.0 <= self.angle_deg <= 180.0:
            raise InputError(f"torch neck angle_deg: expected 0 to 180, got {self.angle_deg:g}")
        if self.body_from_mm < self.bend_end_mm:
            raise InputError(
                f"torch neck body_from_mm: the body begins at {self.body_from_mm:g} mm, before the end of the bend at "
                f"{self.bend_end_mm:.1f} mm"
            )

    @property
    def bend_end_mm(self) -> float:
        """From the mouth along the centre line to the end of the bend, mm."""
        return self.from_mm + math.radians(self.angle_deg) * self.bend_mm


@dataclass(frozen=True, slots=True, eq=False)
class Tube:
    """A straight round piece of a torch, in the torch's own frame.

    The origin of that frame is the middle of the mouth, z leads back along the wire, and the neck bends towards x.
    """

    #: `start`, `end`: shape (3,). Ends of its axis, mm.
    start: FloatArray
    end: FloatArray
    radius_mm: float


@dataclass(frozen=True)
class TorchShape:
    """A torch: a wire, a round nozzle around it from its mouth on, and behind that a neck and a body.

    Without a neck, one radius goes on to the end: a straight torch.

    Raises `InputError` when a length is not positive, or the pieces do not follow each other.
    """

    #: From the tip of the wire to the mouth of the nozzle; only the wire is nearer to the joint. 20 mm is usual with
    #: spray arcs.
    wire_mm: float = 20.0
    nozzle_radius_mm: float = 11.0  #: Outer radius. Gas nozzles of usual size have 10 to 13 mm.
    #: From the tip of the wire along the centre line to where the wrist has room to turn: a usual torch has 300 mm.
    #: What comes behind is not compared with the part.
    length_mm: float = 300.0
    name: str = "stated"
    mouth_radius_mm: float | None = None  #: Outer radius at the mouth of a conical nozzle; None for a cylindrical one.
    taper_mm: float = 0.0  #: Length of the cone.
    neck: Neck | None = None
    #: The longest wire with which this torch still welds; None: `wire_mm`. Seams that need more than `wire_mm` say so.
    most_wire_mm: float | None = None

    def __post_init__(self) -> None:
        for name in ("wire_mm", "nozzle_radius_mm", "length_mm"):
            if not 0.0 < getattr(self, name) < math.inf:
                raise InputError(f"torch {name}: expected a positive number, got {getattr(self, name):g}")
        if self.wire_mm >= self.length_mm:
            raise InputError(f"torch: the wire ({self.wire_mm:g} mm) is longer than the torch ({self.length_mm:g} mm)")
        if not self.nozzle_radius_mm / 2.0 <= self.mouth_mm <= self.nozzle_radius_mm:
            raise InputError(
                f"torch mouth: expected a radius from half of the nozzle's ({self.nozzle_radius_mm:g} mm) to all of "
                f"it, got {self.mouth_mm:g} mm"
            )
        if (self.mouth_radius_mm is None) != (self.taper_mm == 0.0) or not 0.0 <= self.taper_mm <= self.front_mm:
            raise InputError(
                f"torch: a conical nozzle needs the radius of its mouth and the length of its cone, at most "
                f"{self.front_mm:g} mm; got {self.taper_mm:g} mm"
            )
        most_mm = self.wire_mm + LONGER_WIRE_MM
        if self.most_wire_mm is not None and not self.wire_mm <= self.most_wire_mm <= most_mm:
            raise InputError(
                f"torch: the longest wire ({self.most_wire_mm:g} mm) is not between the usual wire "
                f"({self.wire_mm:g} mm) and {LONGER_WIRE_MM:g} mm more"
            )
        if self.neck is not None and self.neck.body_from_mm > self.length_mm - self.wire_mm:
            raise InputError(f"torch: its body begins behind its end, {self.length_mm:g} mm from the tip of the wire")

    @property
    def mouth_mm(self) -> float:
        """Outer radius at the mouth of the nozzle, mm."""
        return self.nozzle_radius_mm if self.mouth_radius_mm is None else self.mouth_radius_mm

    @property
    def front_mm(self) -> float:
        """From the mouth to where the nozzle ends and the neck bends, mm; of a straight torch to its end."""
        return self.length_mm - self.wire_mm if self.neck is None else self.neck.from_mm

    @property
    def wires_mm(self) -> tuple[float, ...]:
        """The lengths of wire that are tried, mm: the usual one first."""
        most = self.most_wire_mm or self.wire_mm
        count = math.ceil((most - self.wire_mm) / WIRE_STEP_MM - 1e-9)
        return (self.wire_mm, *(min(self.wire_mm + step * WIRE_STEP_MM, most) for step in range(1, count + 1)))

    def require_on_it(self, standoff_mm: float) -> None:
        """Refuse a tool centre point that is not on the torch. Raises `InputError`."""
        if not 0.0 <= standoff_mm <= self.length_mm:
            raise InputError(
                f"the standoff: expected 0 to {self.length_mm:g} mm, where the torch ends, got {standoff_mm:g} mm"
            )

    def with_more_wire(self, more_mm: float) -> TorchShape:
        """Return the same torch with a longer wire; its end stays where it is behind the mouth."""
        wire_mm, length_mm = self.wire_mm + more_mm, self.length_mm + more_mm
        most = None if self.most_wire_mm is None else max(self.most_wire_mm, wire_mm)
        return replace(self, wire_mm=wire_mm, length_mm=length_mm, most_wire_mm=most)

    @cached_property
    def tubes(self) -> tuple[Tube, ...]:
        """The neck and the body as straight pieces, from the nozzle to the end; none for a straight torch."""
        if self.neck is None:
            return ()
        neck, angle = self.neck, math.radians(self.neck.angle_deg)
        count = max(1, math.ceil(neck.angle_deg / CHORD_DEG)) if neck.bend_mm > 0 and angle > 0 else 0
        turn = np.linspace(0.0, angle, count + 1)
        bend = np.stack([neck.bend_mm * (1 - np.cos(turn)), 0 * turn, neck.from_mm + neck.bend_mm * np.sin(turn)], 1)
        sag = neck.bend_mm * (1.0 - math.cos(angle / (2 * count))) if count else 0.0
        way = np.array([math.sin(angle), 0.0, math.cos(angle)])
        body = bend[-1] + (neck.body_from_mm - neck.bend_end_mm) * way
        end = bend[-1] + (self.length_mm - self.wire_mm - neck.bend_end_mm) * way
        found = [Tube(a, b, neck.radius_mm + sag) for a, b in pairwise(bend)]
        straight = [Tube(bend[-1], body, neck.radius_mm), Tube(body, end, neck.body_radius_mm)]
        return (*found, *(tube for tube in straight if np.linalg.norm(tube.end - tube.start) > 0))

    @cached_property
    def nozzle_tubes(self) -> tuple[Tube, ...]:
        """Straight pieces around wire and nozzle, from the tip on: the wire, which bends, is as wide as the mouth."""
        count = max(1, math.ceil((self.nozzle_radius_mm - self.mouth_mm) / CONE_STEP_MM))
        share = np.arange(1, count + 1) / count
        radii = self.mouth_mm + share * (self.nozzle_radius_mm - self.mouth_mm)
        ends = np.array([-self.wire_mm, *(share[:-1] * self.taper_mm), self.front_mm])[:, None] * [0.0, 0.0, 1.0]
        return tuple(Tube(*each, float(radius)) for each, radius in zip(pairwise(ends), radii, strict=True))

    @property
    def bends(self) -> bool:
        """Whether it makes a difference how far the torch is turned about its wire."""
        return self.neck is not None and self.neck.angle_deg > 0.0

    @property
    def reaching(self) -> Reaching:
        """How far its points are from the tip and from the line of the wire."""
        front, radius = self.wire_mm + self.front_mm, self.nozzle_radius_mm
        far, aside = [math.hypot(front, radius)], [radius]
        for tube in self.tubes:
            for x, _, z in (tube.start, tube.end):
                far.append(math.hypot(x, self.wire_mm + z) + tube.radius_mm)
                aside.append(abs(x) + tube.radius_mm)
        return Reaching(self.wire_mm, max(far), max(aside))

    def __str__(self) -> str:
        """Describe the torch for people."""
        nozzle = f"nozzle radius {self.nozzle_radius_mm:g} mm, wire {self.wire_mm:g} mm"
        if self.mouth_radius_mm is not None:
            nozzle = f"conical nozzle, radius {self.mouth_radius_mm:g} to {self.nozzle_radius_mm:g} mm, " + (
                f"wire {self.wire_mm:g} mm"
            )
        if self.neck is None:
            return f"a straight torch of {self.length_mm:g} mm, {nozzle}"
        return f"{self.name}, a torch of {self.length_mm:g} mm with a neck of {self.neck.angle_deg:g} degrees, {nozzle}"


USUAL_TORCH = TorchShape(name="straight", most_wire_mm=25.0)
"""The torch that is assumed unless the caller states another one."""
