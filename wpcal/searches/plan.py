"""A plan of touches: searches in the part's coordinates, in the order in which the robot makes them."""

from __future__ import annotations

import re
from collections import Counter
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform

SEARCH_NAME = re.compile(r"[A-Za-z][A-Za-z0-9]{0,7}")
"""Names of searches: identifiers in every language of a controller, with room for a prefix of 8 characters."""


class Contact(StrEnum):
    """What of the torch meets the face."""

    SIDE = "side"
    """The side of the wire: the tool centre point is the wire's radius from the face."""
    END = "end"
    """The end of the wire: the tool centre point is on the face, and the error of the stick-out enters one to one."""


class SearchKind(StrEnum):
    """What a search measures."""

    PART = "part"
    POST = "post"
    """A post at a known place in the base, which solves the stick-out."""


@dataclass(frozen=True, slots=True, eq=False)
class Search:
    """One search: the way to its start, the straight move until contact, the way back.

    All points are places of the tool centre point in `part`, mm; of a post in `base`. During the search the tool keeps
    its orientation.

    Parameters
    ----------
    name : str
        Unique in the plan; see `SEARCH_NAME`.
    target : str
        What is touched, in the words of a taught table's `kind`: ``plane``, ``edge``, ``cylinder``, ``hole``, …
    feature : str
        Its name in `wpcal features`, or empty.
    contact_part : ndarray, shape (3,)
        The point of the part that is touched where it stands as planned.
    normal_part : ndarray, shape (3,)
        Outward unit normal there.
    contact : Contact
    radius_mm : float
        Distance of the tool centre point from the face at contact, along the outward normal.
    R_part_tool : ndarray, shape (3, 3)
        Axes of the tool in `part` as columns; z leaves the wire tip.
    via : ndarray, shape (k, 3)
        Points on the way from the search before (or from home) to `approach`, often none. The moves between them are
        linear, and the tool has the orientation of this search from the first of them on: it turns on the way to it.
    approach, start, end, retract : ndarray, shape (3,)
        The robot goes to `approach` in the air, to `start` on a line, searches to `end` on a line, and leaves to
        `retract` by way of `start`. The stroke is from `start` to `end`.
    covariance_part : ndarray, shape (3, 3)
        Of the tool centre point that the controller stores, mm²: repeatability, stick-out along the wire, latency along
        the direction.
    joints : ndarray, shape (3, axes), or None
        Shown angles of the arm at `approach`, `start` and `end`, rad; None if no arm is given.
    kind : SearchKind

    Raises
    ------
    InputError
        When the name is not one, or the stroke is zero.
    """

    name: str
    target: str
    feature: str
    contact_part: FloatArray
    normal_part: FloatArray
    contact: Contact
    radius_mm: float
    R_part_tool: FloatArray
    via: FloatArray
    approach: FloatArray
    start: FloatArray
    end: FloatArray
    retract: FloatArray
    covariance_part: FloatArray
    joints: FloatArray | None = None
    kind: SearchKind = SearchKind.PART

    def __post_init__(self) -> None:
        if not SEARCH_NAME.fullmatch(self.name):
            raise InputError(f"search {self.name!r}: expected a letter and at most seven letters or digits")
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
        """The tool centre point at contact where the part stands as planned, shape (3,), mm."""
        return self.contact_part + self.radius_mm * self.normal_part


@dataclass(frozen=True, slots=True, eq=False)
class TouchPlan:
    """Searches for one part in one cell.

    Parameters
    ----------
    part : str
        File name of the STEP file.
    searches : tuple of Search
        In the order in which they run.
    T_base_part : RigidTransform
        Where the part stands as planned. Programs use it as their work object (user frame), so that their points are
        `part` coordinates.
    wire_mm : float
        Diameter of the wire.
    stick_out_mm : float
        From the contact tip to the tool centre point.
    home_joints : ndarray, shape (axes,), or None
        Shown angles before the first search and after the last one, rad; None if no arm is given.
    fingerprint : str
        Eight hexadecimal digits of what the program depends on. The program stores it beside its results, so that
        results of another plan are recognised.

    Raises
    ------
    InputError
        When two searches have one name (upper and lower case are one in most languages).
    """

    part: str
    searches: tuple[Search, ...]
    T_base_part: RigidTransform
    wire_mm: float
    stick_out_mm: float
    home_joints: FloatArray | None
    fingerprint: str

    def __post_init__(self) -> None:
        twice = [name for name, n in Counter(search.name.upper() for search in self.searches).items() if n > 1]
        if twice:
            raise InputError(f"two searches are named {twice[0]}")
