"""`WeldSequence`: all seams that can be welded, in an order, with approach, retract and the moves between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.same_bits import product
from wpcal.core.wording import listed
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.shape import BY_LENGTH
from wpcal.planning.sequence.air_path import AirPath
from wpcal.planning.sequence.cuts import Unwelded
from wpcal.planning.sequence.motion_check import CheckedMove
from wpcal.planning.sequence.order import axis_seconds
from wpcal.planning.sequence.seam_task import Candidate
from wpcal.planning.sequence.targets import SequenceTargets
from wpcal.seam.path.position import usual_position

AIR_SHARE = 0.5
"""Part of the joint speeds that moves through the air use: arms need some of the rest to speed up and slow down."""


@dataclass(frozen=True, slots=True, eq=False)
class Way:
    """Ways between home and one piece, each proved free, shapes (m, k); empty where none was found."""

    from_home: FloatArray  #: To the first state of the piece.
    to_home: FloatArray  #: From its last state.


@dataclass(frozen=True, slots=True, eq=False)
class WeldPiece:
    """One stretch with its approach and retract."""

    name: str  #: The seam's, with a letter where the seam is welded in pieces.
    candidate: Candidate
    #: `before`, `after`: shapes (a, k) and (b, k). States on the wire's line before and after the stretch, in the order
    #: of travel; perhaps none.
    before: FloatArray
    after: FloatArray
    check: CheckedMove  #: Of approach, stretch and retract.
    speed_mm_s: float
    slowed_by: str | None  #: The axis that does not allow the asked speed.

    @property
    def states(self) -> FloatArray:
        """All axes of approach, stretch and retract, shape (a + n + b, k), rad and mm."""
        return np.concatenate([self.before, self.candidate.q, self.after])

    def position(self, cell: Cell) -> str:
        """Return the weld position of most of its points."""
        task, places = self.candidate.task, cell.part_places(self.candidate.q)
        return usual_position(product(places[:, :3, :3], task.R)[task.is_source], task.weld)


@dataclass(frozen=True, slots=True)
class SequenceValues:
    """What plans are compared by; smaller is better."""

    #: Mean over the welded length of the largest distance of each piece from the asked weld position.
    position_deg: float
    torch_deg: float  #: Root mean square deviation of the torch from its target angles.
    motion_deg_per_mm: float  #: Root mean square of the joint rates along the seams.
    #: Welds and moves between them; of a plan that is not worked out, straight moves at the same share of the speeds.
    time_s: float


@dataclass(frozen=True, slots=True, eq=False)
class WeldSequence:
    """A complete plan."""

    cell: Cell  #: With the part in its place.
    targets: SequenceTargets
    pieces: tuple[WeldPiece, ...]  #: In the order of welding.
    air: tuple[AirPath, ...]  #: From home to the first piece, between pieces, and home: one more than pieces.
    unwelded: tuple[Unwelded, ...]
    values: SequenceValues
    ways: tuple[Way, ...]  #: One per piece: for a piece that is welded by itself.

    @property
    def welded_mm(self) -> float:
        """Length of all pieces, mm."""
        return sum(piece.candidate.task.length_mm for piece in self.pieces)

    @property
    def out_of_position(self) -> tuple[WeldPiece, ...]:
        """Pieces that are farther from the asked weld position than the tolerance."""
        tol = self.targets.position_tol_rad
        return tuple(piece for piece in self.pieces if piece.candidate.off_position_rad > tol)

    @property
    def is_free(self) -> bool:
        """Whether every move is proved free of collision."""
        return all(piece.check.is_free for piece in self.pieces) and all(path.check.is_free for path in self.air)

    def open_points(self, *, has_part: bool) -> tuple[str, ...]:
        """Return what was not checked, not welded, off position or without a way, one line each; empty: nothing is."""
        cell = self.cell
        bare = [("the arm", cell.links), ("the positioner", True if cell.carrier is None else cell.carrier.links)]
        found = [f"NOT CHECKED: {what} has no bodies" for what, bodies in bare if not bodies]
        if any(shape.name.endswith(BY_LENGTH) for shape in cell.links):
            found.append("NOT CHECKED: the true shape of the arm: its bodies are estimated from its lengths")
        if not has_part:
            found.append("NOT CHECKED: the part: its triangles are not known")
        if hit := [piece for piece in self.pieces if not piece.check.is_free]:
            found.append(f"NOT FREE: {_names(hit)}")
        if left_mm := sum(gap.to_mm - gap.from_mm for gap in self.unwelded):
            found.append(f"NOT WELDED: {left_mm:.0f} of {self.welded_mm + left_mm:.0f} mm")
        if off := self.out_of_position:
            most = max(math.degrees(piece.candidate.off_position_rad) for piece in off)
            found.append(f"OFF POSITION: {_names(off)}, by up to {math.ceil(most)} deg")
        of_data = ((piece, piece.candidate.task.position) for piece in self.pieces)
        if other := [
            f"{piece.name} ({p}, is {now})" for piece, p in of_data if p and (now := piece.position(cell)) != p
        ]:
            found.append(f"WELD DATA OF ANOTHER POSITION: {', '.join(other)}")
        of_speed = ((piece, piece.candidate.task.speed_mm_s) for piece in self.pieces if piece.slowed_by)
        if slow := [f"{piece.name} ({mm_s:g} mm/s, is {piece.speed_mm_s:.1f})" for piece, mm_s in of_speed if mm_s]:
            found.append(f"SLOWER THAN ITS WELD DATA: {', '.join(slow)}; the same wire feed lays a larger bead")
        alone = zip(self.pieces, self.ways, strict=True)
        if lost := [piece for piece, way in alone if not (len(way.from_home) and len(way.to_home))]:
            found.append(f"NO FREE WAY BY ITSELF: {_names(lost)}, from home or to home")
        return tuple(found)

    @property
    def short_ways(self) -> tuple[str, ...]:
        """Which pieces the torch comes to or leaves by less than was asked: one line, or none."""
        asked, found = self.targets.approach_mm, list[str]()
        for piece in self.pieces:
            p = self.cell.tool_in_part(piece.states)[:, :3, 3]
            ends = len(piece.before), len(p) - 1 - len(piece.after)
            least = min(float(np.linalg.norm(p[one] - p[end])) for one, end in zip((0, -1), ends, strict=True))
            found += [f"{piece.name} {least:.0f} mm"] if least < asked - 0.5 else []
        told = f"approach or retract below {asked:g} mm, to where the wire is clear: {', '.join(found)}"
        return (told,) * bool(found)

    @property
    def checked(self) -> str:
        """What was compared with what, in one line."""
        checks = [piece.check for piece in self.pieces] + [path.check for path in self.air]
        count = sum(len(check.at) for check in checks)
        least = min(float(check.margin_mm.min()) for check in checks)
        return (
            f"{count} states on all moves; between two of them no body moves farther than is free around it; the least "
            f"distance is at least {least:.1f} mm beyond the safety distance"
        )


def _names(pieces: Sequence[WeldPiece]) -> str:
    return listed([piece.name for piece in pieces])


def sequence_values(cell: Cell, targets: SequenceTargets, chosen: list[Candidate], air_s: float) -> SequenceValues:
    """Return what plans are compared by."""
    length = np.array([candidate.task.length_mm for candidate in chosen])
    share = length / length.sum()
    position = float(product(share, [math.degrees(candidate.off_position_rad) for candidate in chosen]))
    torch = math.sqrt(float(product(share, [math.degrees(candidate.off_torch_rad) ** 2 for candidate in chosen])))
    motion = math.sqrt(float(product(share, [math.degrees(candidate.motion_rad_mm) ** 2 for candidate in chosen])))
    weld = sum(c.task.length_mm / c.weld_speed(cell, targets.speed_mm_s)[0] for c in chosen)
    return SequenceValues(position, torch, motion, weld + air_s)


def air_seconds(cell: Cell, way: FloatArray) -> FloatArray:
    """Return the time of every straight move between states (n, k) through the air, s, shape (n - 1,)."""
    return axis_seconds(way[:-1], way[1:], AIR_SHARE * cell.speeds)
