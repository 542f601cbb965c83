"""The options by which seams are found, accepted and cut into frames."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from enum import Enum

from wpcal.brep.graph import BrepGraph
from wpcal.core.errors import InputError
from wpcal.core.options import opt, opt_deg
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape
from wpcal.seam.limits import LEAST_SEAM_MM, MEETING_MM, MOST_BRIDGE_MM, Level, usual_gap_mm

MOST_LEAN_DEG = 60.0  #: At a square fillet a torch that leans by 45 degrees from the bisector lies on a plate.


class ConcaveEdges(Enum):
    """Whether concave edges inside one solid are taken as seams."""

    ALWAYS = "always"
    NEVER = "never"
    AUTO = "auto"


@dataclass(frozen=True, slots=True)
class StepOptions:
    """How a seam is cut into steps.

    Raises `InputError` if a value is not positive, a turn above half a turn, or the least step larger than the largest.
    """

    chord_mm: float = opt(0.1, "Largest chord error.")
    min_step_mm: float = opt(1.0, "Smallest step along a seam.")
    max_step_mm: float = opt(10.0, "Largest step along a seam.")
    turn_rad: float = opt_deg(45.0, "Largest turn of the frame between points.")

    def __post_init__(self) -> None:
        for name in ("chord_mm", "max_step_mm"):
            if not getattr(self, name) > 0:
                raise InputError(f"{name} must be positive, got {getattr(self, name)}")
        if not 0 < self.turn_rad <= math.pi:
            raise InputError(f"--turn-deg must be above 0 and at most 180, got {math.degrees(self.turn_rad):g}")
        if not 0 <= self.min_step_mm <= self.max_step_mm:
            raise InputError(f"min_step_mm must be between 0 and max_step_mm, got {self.min_step_mm}")


STOCK = ("plate", "bar", "tube", "profile", "piece")  #: What a person may say of a member that is welded as a whole.
WELDMENT, CAST = "weldment", "cast"
KINDS = (*STOCK, WELDMENT, CAST)


@dataclass(frozen=True, slots=True)
class SaidMember:
    """What a person says about one member."""

    member: str  #: Its name: that of a solid, or ``frame/2``.
    word: str  #: One of `KINDS`, or the name of another member: the two are one.
    at_mm: tuple[float, float, float] | None = None  #: Where its middle was when it was said, in `part`, mm.


def read_said(typed: Sequence[str]) -> tuple[SaidMember, ...]:
    """Read ``NAME=KIND``, each. Raises `InputError` if one of the two is missing, or something is said twice."""
    said = tuple(SaidMember(name, word) for name, _, word in (text.rpartition("=") for text in typed))
    if not all(one.member and one.word for one in said) or len({one.member for one in said}) < len(said):
        raise InputError(f"--member: expected NAME=KIND, such as frame/2=plate, once per name, got {', '.join(typed)}")
    return said


@dataclass(frozen=True, slots=True)
class Judging:
    """What a person says about members, and how sure a seam must be."""

    weld: tuple[str, ...] = opt(
        (),
        "The solids of this name can be welded, whatever the evidence; * and ? match any letters. The name may be that "
        "of a product or an instance above them.",
        metavar="NAME",
        many=True,
    )
    not_welded: tuple[str, ...] = opt(
        (),
        "The solids of this name are not welded. If --weld fits, too, the name with more letters counts.",
        "--not",
        metavar="NAME",
        many=True,
    )
    members: tuple[SaidMember, ...] = opt(
        (),
        "What a member is (--all lists them): plate, bar, tube, profile or piece: welded to others, not in itself; "
        "cast (or bought): not welded; weldment: its inner corners are welds; the name of another one: both are one.",
        "--member",
        metavar="NAME=KIND",
        many=True,
        read=read_said,
    )
    level: Level = opt(
        Level.USUAL,
        "How sure a seam must be.",
        switches={
            "--strict": (Level.STRICT, "Accept only what is sure."),
            "--generous": (Level.GENEROUS, "Accept also what one doubtful finding speaks against."),
        },
    )

    def after(self, before: Judging) -> Judging:
        """Return what is said here, and what was said before about others."""
        known = {*self.weld, *self.not_welded, *(one.member for one in self.members)}
        weld, not_welded = (tuple(one for one in own if one not in known) for own in (before.weld, before.not_welded))
        members = tuple(one for one in before.members if one.member not in known)
        return Judging(self.weld + weld, self.not_welded + not_welded, self.members + members, self.level)


@dataclass(frozen=True, slots=True)
class Play:
    """A gap that several joints of an assembly have."""

    #: `least_mm`, `gap_mm`, `most_mm`: The narrowest, the median and the widest of these gaps.
    least_mm: float
    gap_mm: float
    most_mm: float
    joints: int  #: How many joints have it.


@dataclass(frozen=True, slots=True)
class Reach:
    """The torch with which reach is judged, and how far it may lean and turn.

    Raises `InputError` if a range does not hold 0, or goes beyond 60 degrees (the spin: 180).
    """

    torch: TorchShape = opt(
        USUAL_TORCH,
        "The torch with which reach is judged: one of wpcal torches, a file of that form, or a cell file.",
        metavar="NAME|FILE",
        read="wpcal.robot.torch.file:find_torch",
        show=lambda torch: torch.name,
    )
    work_deg: tuple[float, float] = opt(
        (-15.0, 15.0), "How far the torch may lean across a seam.", "--work-range-deg", metavar="FROM,TO"
    )
    travel_deg: tuple[float, float] = opt(
        (-35.0, 35.0),
        "How far the torch may lean along a seam; push is positive.",
        "--travel-range-deg",
        metavar="FROM,TO",
    )
    spin_deg: tuple[float, float] = opt(
        (-180.0, 180.0),
        "How far a bent neck may be turned about the wire, either way; at 0 it bends against the travel.",
        "--neck-range-deg",
        type=float,
        read=lambda most: (-most, most),
        show=lambda turn: turn[1],
    )
    lean_deg_per_mm: float = opt(
        5.0,
        "The most by which a lean changes per mm of seam, where the torch is free meanwhile: the wrist then turns "
        "by 30 deg/s at a usual 6 mm/s, without a jerk.",
        least=1.0,
    )

    def __post_init__(self) -> None:
        for name, most in (("work", MOST_LEAN_DEG), ("travel", MOST_LEAN_DEG), ("spin", 180.0)):
            low, high = getattr(self, f"{name}_deg")
            if not -most <= low <= 0.0 <= high <= most:
                raise InputError(
                    f"{name} angles of the torch: expected a range around 0 within {most:g} degrees either way, got "
                    f"{low:g} to {high:g}"
                )


@dataclass(frozen=True, slots=True)
class SeamOptions:
    """How seams are found, accepted and cut into frames. Raises `InputError` if a length is negative or not finite."""

    gap_mm: float | None = opt(None, "Largest gap between members.  [default: by part size, at most 0.5]")
    concave: ConcaveEdges = opt(
        ConcaveEdges.AUTO,
        "Take concave edges inside one solid as seams; auto: only of solids built up of plates, bars and tubes.",
    )
    split_rad: float = opt_deg(30.0, "A seam ends where it turns by more.")
    steps: StepOptions = field(default_factory=StepOptions)
    min_length_mm: float = opt(LEAST_SEAM_MM, "Least length of an accepted seam.")
    join_mm: float = opt(
        MOST_BRIDGE_MM, "Join contacts in one line across interruptions of at most this length; 0 joins none."
    )
    judging: Judging = Judging()
    reach: Reach = Reach()
    wrap: bool = opt(
        False, "Weld seams that meet at a corner of a member in one run round it, with the short ends between them."
    )
    play: tuple[Play, ...] | None = None

    def __post_init__(self) -> None:
        if self.gap_mm is not None and not self.gap_mm > 0:
            raise InputError(f"--gap-mm must be positive, got {self.gap_mm}")
        if not 0 <= self.split_rad <= math.pi:
            raise InputError(f"--split-deg must be between 0 and 180, got {math.degrees(self.split_rad):g}")
        for name in ("min_length_mm", "join_mm"):
            if not 0 <= getattr(self, name) < math.inf:
                raise InputError(f"{name} must be 0 or more, got {getattr(self, name)}")

    def gap_for(self, graph: BrepGraph) -> float:
        """Return the gap to use on a part, mm."""
        return usual_gap_mm(graph.size_mm) if self.gap_mm is None else self.gap_mm

    @property
    def most_join_mm(self) -> float:
        """How far the ends of two seams that a person joins may be from each other, mm."""
        return max(MEETING_MM, self.join_mm)

    @property
    def min_edge_mm(self) -> float:
        """Least length of a concave edge, and of a bead's side, that is considered, mm.

        It never exceeds the default: a long seam may consist of edges that are shorter than the seam must be.
        """
        return min(self.min_length_mm, LEAST_SEAM_MM)
