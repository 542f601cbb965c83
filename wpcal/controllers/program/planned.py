"""What a planned program has besides its paths: joint moves between the seams, and the axes outside the arm.

Between two joint targets the controller moves as the plan was checked. Positions on the seams state the joints and the
external axes that the plan has there, so that nothing is left to the controller.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wpcal.controllers.language.rounding import texts
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform

ALONE = "only_"  #: The name of a routine that welds one seam, from home and home again, is this and its name.


@dataclass(frozen=True, slots=True, eq=False)
class JointMoves:
    """Joint moves, one after the other."""

    joints: FloatArray  #: shape (n, 6). Where they lead: shown angles of the arm, rad.
    external: FloatArray  #: shape (n, e). External axes there, rad, a rail in mm.

    #: shape (n,). How far from its end the tool may leave each move for the next one, mm; None: every move stops.
    zone_mm: FloatArray | None = None
    zone_share: FloatArray | None = None  #: shape (n,). The same as a share of the move.

    def __len__(self) -> int:
        return len(self.joints)

    def rows(self, first: int, last: int | None) -> JointMoves:
        """Return some of them."""
        zones = (None if each is None else each[first:last] for each in (self.zone_mm, self.zone_share))
        return JointMoves(self.joints[first:last], self.external[first:last], *zones)


@dataclass(frozen=True, slots=True, eq=False)
class PlannedMoves:
    """The moves off the seams, and what a plan says about itself."""

    #: Before each path, from home on, and after the last, to home: one more than paths. Those before a path end at its
    #: approach.
    air: tuple[JointMoves, ...]
    rail: str | None  #: The name of the rail; its values are the first column of the external axes.
    turning: tuple[str, ...]  #: The names of the positioner's axes: the other columns.
    T_flange_tool: RigidTransform  #: z is the wire.
    joint_percent: float  #: Of the largest joint speeds, in joint moves.
    about: tuple[str, ...]  #: For a person to read in the header.
    #: For each path the moves from home on, without the last one to its approach, and those from its retract home; both
    #: without moves if not known.
    ways: tuple[tuple[JointMoves, JointMoves], ...] = ()
    follows: bool = False  #: Whether the positioner turns along a seam.
    #: Whether positions are then in the part that it carries: what a program calls the base is the flange of the
    #: positioner. Otherwise they are in the base of the robot, and the moves along such a seam are lines.
    is_carried: bool = True

    def zone(self, number: int) -> tuple[float, float]:
        """Return the zone of the move with this number, mm and as a share of it; zeros where it stops."""
        for moves, numbers in self.numbered():
            if number in numbers and moves.zone_mm is not None and moves.zone_share is not None:
                row = number - numbers[0]
                return float(moves.zone_mm[row]), float(moves.zone_share[row])
        return 0.0, 0.0

    @property
    def zones_mm(self) -> list[float]:
        """The sizes of all zones, mm, the smallest first."""
        return sorted({float(mm) for moves in self.legs if moves.zone_mm is not None for mm in moves.zone_mm if mm})

    @property
    def axis_count(self) -> int:
        """Number of external axes."""
        return len(self.turning) + (self.rail is not None)

    @property
    def legs(self) -> tuple[JointMoves, ...]:
        """All joint moves: `air`, then `ways`."""
        return (*self.air, *(moves for way in self.ways for moves in way))

    def numbered(self) -> Iterator[tuple[JointMoves, tuple[int, ...]]]:
        """Yield `legs` with the numbers of their targets, from 1 on."""
        last = 0
        for moves in self.legs:
            yield moves, tuple(range(last + 1, last + len(moves) + 1))
            last += len(moves)

    def standing_axes(self, language: str) -> list[str]:
        """Return what a header says about external axes that stand still, for a language that has none.

        Raises `InputError` when one of them moves.
        """
        names = [name for name in (self.rail, *self.turning) if name]
        if not names:
            return []
        external = np.concatenate([moves.external for moves in self.air])
        if np.ptp(external, axis=0).any() or self.follows:
            raise InputError(
                f"{language}: this plan moves {', '.join(names)}, and programs in {language} move the arm only; write "
                "another language, or plan with the part fixed"
            )
        (values,) = self.external_texts(external[:1], 4)
        units = ["mm" if name == self.rail else "deg" for name in names]
        places = ", ".join(f"{name} at {v} {unit}" for name, v, unit in zip(names, values, units, strict=True))
        return [f"this program does not move {', '.join(names)}: bring before {places}"]

    def external_texts(self, external: FloatArray, decimals: int) -> list[list[str]]:
        """Return external axes of shape (n, e) as texts: a rail in mm, and degrees."""
        rails = int(self.rail is not None)
        return texts(np.column_stack([external[:, :rails], np.degrees(external[:, rails:])]), decimals)
