"""A plan of touches: searches in the part's coordinates, in the order in which the robot makes them."""

from __future__ import annotations

import hashlib
import re
from collections import Counter
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from wpcal.calibrate.errors.prediction import COVERAGE, length_quantile
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm

SEARCH_NAME = re.compile(r"[A-Za-z][A-Za-z0-9]{0,7}")
"""Names of searches: identifiers in every language of a controller, with room for a prefix of 8 characters."""
UNIT_ATOL = 1e-4  #: A normal in a file (four printed digits) may differ this much from a unit vector.
FINGERPRINT_DIGITS = 6  #: Decimals of mm and degrees that count as the same plan: far below what a controller stores.
MOST_TOUCHES = 60  #: Far more than anybody makes: the error falls with the root of the number.


class Contact(StrEnum):
    """What of the torch meets the face."""

    SIDE = "side"  #: The side of the wire: its tip is the wire's radius from the face.
    END = "end"
    """The end of the wire: its tip is on the face, and the error of the stick-out enters one to one."""


class SearchKind(StrEnum):
    """What a search measures."""

    PART = "part"
    POST = "post"  #: A post at a known place in the base, which solves the stick-out: it does not move with the part.


@dataclass(frozen=True, slots=True)
class Served:
    """What a search does for a seam of a weldment whose bodies may move."""

    seam: str  #: The worst seam of the touched body before the search.
    #: `before_mm`, `after_mm`: Its largest 95 % error before and after the search, in the order in which the searches
    #: help most; None while the searches leave the part free.
    before_mm: float | None
    after_mm: float | None


@dataclass(frozen=True, slots=True)
class PlannedBody:
    """A body that may move, with the tack tolerance that the plan assumes."""

    name: str
    #: `tack_mm`, `tack_mrad`: Standard deviations of the place of its centre and of its turn, per axis.
    tack_mm: float
    tack_mrad: float


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """One search: the way to its start, the straight move until contact, the way back.

    All points are places of the tip of the wire in `part` where it stands as planned (the work object of the program),
    mm; also those of a post, whose place in the base is `TouchPlan.T_base_part` times it. During the search the tool
    keeps its orientation.

    Raises `InputError` when the name is not one, or the stroke is zero.
    """

    name: str  #: Unique in the plan; see `SEARCH_NAME`.
    #: What is touched, in the words of a taught table's `kind`: ``plane``, ``edge``, ``cylinder``, ``hole``, ….
    target: str
    feature: str  #: Its name in `wpcal features`, or empty.
    contact_part: FloatArray  #: shape (3,). The point of the part that is touched where it stands as planned.
    normal_part: FloatArray  #: shape (3,). Outward unit normal there.
    contact: Contact
    radius_mm: float  #: Distance of the tip from the face at contact, along the outward normal.
    R_part_tool: FloatArray  #: shape (3, 3). Axes of the tool in `part` as columns; z leaves the wire tip.
    #: shape (k, 3). Points on the way from the search before (or from home) to `approach`, often none. The moves
    #: between them are linear; where the tool turns: see `TouchPlan.axes`.
    via: FloatArray
    #: `approach`, `start`, `end`, `retract`: shape (3,). The robot goes to `approach` in the air, to `start` on a line,
    #: searches to `end` on a line, and leaves to `retract` by way of `start`. The stroke is from `start` to `end`.
    approach: FloatArray
    start: FloatArray
    end: FloatArray
    retract: FloatArray
    #: shape (3, 3). Of the tool centre point that the controller stores, mm²: repeatability, stick-out along the wire,
    #: latency along the direction.
    covariance_part: FloatArray
    #: shape (3, axes). Shown angles of the arm at `approach`, `start` and `end`, rad; None if no arm is given.
    joints: FloatArray | None = None
    via_joints: FloatArray | None = None  #: shape (k, axes). Shown angles at `via`, rad; None if no arm is given.
    kind: SearchKind = SearchKind.PART
    body: str = ""  #: The body that is touched, if bodies may move; otherwise empty.
    serves: Served | None = None
    axis: FloatArray | None = None  #: shape (2, 3). A point of the axis of a round face, and its direction; None: flat.

    def __post_init__(self) -> None:
        if not SEARCH_NAME.fullmatch(self.name):
            raise InputError(f"search {self.name!r}: expected a letter and at most seven letters or digits")
        if abs(float(np.linalg.norm(self.normal_part)) - 1.0) > UNIT_ATOL:
            raise InputError(f"search {self.name}: its normal is not a unit vector")
        if not self.stroke_mm > 0.0:
            raise InputError(f"search {self.name}: its start and its end are the same point")

    @property
    def stroke_mm(self) -> float:
        """Length of the search, mm."""
        return float(np.linalg.norm(self.end - self.start))

    @property
    def direction(self) -> FloatArray:
        """Unit vector of the search, shape (3,)."""
        return (self.end - self.start) / self.stroke_mm

    @property
    def planned(self) -> FloatArray:
        """The tip of the wire at contact where the part stands as planned, shape (3,), mm."""
        return self.contact_part + self.radius_mm * self.normal_part

    @property
    def error_95_mm(self) -> float:
        """What the error of the stored place along the search stays below with 95 % probability, mm."""
        along = self.direction @ self.covariance_part @ self.direction
        return float(length_quantile(np.array([[[along]]]), COVERAGE)[0])


@dataclass(frozen=True, slots=True)
class SeamPrediction:
    """What the touches of a plan promise for the seams."""

    error_95_mm: float  #: Largest predicted 95 % error along the seams.
    seam: str  #: The seam where it occurs.
    by_seam_mm: tuple[tuple[str, float], ...]  #: The largest error of each seam.
    #: What no point of the seams exceeds, with 95 % probability: `wpcal calibrate` compares it with its tolerance.
    joint_95_mm: float | None = None
    unseen_mm: float = 0.0  #: The part of `error_95_mm` that comes from motions of bodies which no touch sees.
    why_not: str = ""  #: Why a tolerance that was asked for is not reached; otherwise empty.


@dataclass(frozen=True, slots=True, eq=False)
class FirstStage:
    """What is known of the place of the part after the searches of a first stage, beside the place of the plan."""

    centre_part: FloatArray  #: shape (3,). About which the part is turned, mm.
    covariance: (
        FloatArray  #: shape (6, 6). Of its turn (rad) and of the motion of the centre (mm), along axes of `part`.
    )


@dataclass(frozen=True, slots=True, eq=False)
class TouchPlan:
    """Searches for one part in one cell.

    Raises `InputError` when two searches have one name (upper and lower case are one in most languages).
    """

    part: str  #: File name of the STEP file.
    searches: tuple[Search, ...]  #: In the order in which they run.
    #: Where the part stands as planned. Programs use it as their work object (user frame), so that their points are
    #: `part` coordinates.
    T_base_part: RigidTransform
    wire_mm: float  #: Diameter of the wire.
    stick_out_mm: float  #: From the contact tip to the tip of the wire.
    #: shape (axes,). Shown angles before the first search and after the last one, rad; None if no arm is given.
    home_joints: FloatArray | None = None
    robot: str = ""  #: Name of the arm; empty if none is given.
    arm: Arm | None = None  #: The arm itself: programs state the configuration with it.
    predicted: SeamPrediction | None = None
    notes: tuple[str, ...] = ()  #: What a person should know of the plan.
    bodies: tuple[PlannedBody, ...] = ()  #: The bodies that may move; empty if the part is one.
    #: Of searches that do not hold the part, after which others can be planned; `predicted` is then what these promise.
    first_stage: FirstStage | None = None
    standoff_mm: float = 0.0  #: From the tool centre point of the controller along the wire to its tip: see `ahead`.

    def __post_init__(self) -> None:
        twice = [name for name, n in Counter(search.name.upper() for search in self.searches).items() if n > 1]
        if twice:
            raise InputError(f"two searches are named {twice[0]}")

    @property
    def fingerprint(self) -> str:
        """Eight hexadecimal digits of what the program depends on, the same after writing and reading.

        The program stores them beside its results, so that results of another plan are recognised.
        """
        place = self.T_base_part.to_record()
        numbers = [*place["xyz_mm"], *place["rpy_deg"], self.wire_mm, self.stick_out_mm]
        numbers += [self.standoff_mm] * (self.standoff_mm > 0.0)
        for search in self.searches:
            points = (search.contact_part, search.normal_part, search.start, search.end, search.R_part_tool)
            numbers += [search.radius_mm, *(float(v) for each in points for v in each.ravel())]
        rounded = np.round(numbers, FINGERPRINT_DIGITS) + 0.0
        names = ",".join(f"{search.name}/{search.kind}" for search in self.searches)
        text = f"{names} {' '.join(f'{v:.{FINGERPRINT_DIGITS}f}' for v in rounded)}"
        return hashlib.sha256(text.encode()).hexdigest()[:8]

    def axes(self, number: int) -> FloatArray:
        """Return the axes of the tool at `via`, approach, start, end and retract of a search in `part`, (k + 4, 3, 3).

        It turns in the middle of the way, which is over the part.
        """
        search, before = self.searches[number], self.searches[max(number - 1, 0)]
        turned = len(search.via) // 2
        return np.stack([before.R_part_tool] * turned + [search.R_part_tool] * (len(search.via) - turned + 4))

    def ahead(self, search: Search) -> FloatArray:
        """Return the way from the tool centre point of the controller to the tip of the wire in `part`, shape (3,), mm.

        Programs move the tool centre point and store its places; all points of a search are places of the tip.
        """
        return np.asarray(self.standoff_mm * search.R_part_tool[:, 2])

    def search(self, name: str) -> Search:
        """Return the search of a name; upper and lower case are one. Raises `InputError` when there is none."""
        for search in self.searches:
            if search.name.upper() == name.upper():
                return search
        raise InputError(f"no search {name!r} in the plan; it has {', '.join(each.name for each in self.searches)}")
