"""`Reading`: what a controller says of its arm, and `RobotLink`: what reads it."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.numbers import parse_number
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform

USER_VARIABLE, PASSWORD_VARIABLE = "WPCAL_LINK_USER", "WPCAL_LINK_PASSWORD"
LONGEST_NAME = 64  #: Characters of a tool or a frame; controllers allow 32.
MOST_JOINTS = 12  #: Six of the arm, six external.


class LinkError(InputError):
    """A position could not be read, or must not be used."""

    code = "link"


@dataclass(frozen=True, slots=True, eq=False)
class Setting:
    """A tool or a user frame that is active on the controller."""

    name: str  #: Its number or name there; empty if the controller does not tell.
    values: RigidTransform | None = None  #: Tool in the flange, or frame in the base; None if it does not tell.

    def __str__(self) -> str:
        if self.name or self.values is None:
            return self.name or "not told by the robot"
        return f"({', '.join(f'{value:.4g}' for value in self.values.t_mm)} mm; number not told by the robot)"


@dataclass(frozen=True, slots=True, eq=False)
class Reading:
    """A position of the arm.

    The frame `base` is the one in which programs of this controller are without a user frame.
    """

    T_base_tool: RigidTransform
    tool: Setting
    frame: Setting  #: Which frame the pendant shows; the position does not depend on it.
    joints_rad: FloatArray | None  #: shape (n,). As shown on the pendant; a rail in mm.
    asked_s: float  #: By `time.monotonic`, when it was asked for: the position is not older.
    configuration: str = ""  #: Of the arm, in the words of the controller; empty if it does not tell.


class RobotLink(Protocol):
    """An open connection to a controller."""

    def read(self) -> Reading:
        """Return the position.

        Raises `LinkError` when the controller does not answer in time, or not with a position.
        """

    def results(self, plan: Path) -> dict[str, bytes]:
        """Return the files in which the touch program of a plan stores its results, by name.

        `plan`: The file of the plan; the program that was written is beside it.

        Raises `LinkError` when there is none, or files are not read over this link.
        """

    def close(self) -> None:
        """End the connection."""


Credentials = Callable[[str], tuple[str, str]]
"""Returns user and password for a host. They are never part of a message."""


def credentials_of_environment(host: str) -> tuple[str, str]:
    """Return what the environment says. Raises `LinkError` when it does not."""
    user, password = os.environ.get(USER_VARIABLE), os.environ.get(PASSWORD_VARIABLE)
    if user is None or password is None:
        raise LinkError(f"{host} asks who reads: set {USER_VARIABLE} and {PASSWORD_VARIABLE}")
    return user, password


HOST_PORT = re.compile(r"(?P<host>[^\s/@?#:]+|[^\s/@?#:]*:[^\s/@?#:]*:[^\s/@?#]*)(?::(?P<port>[0-9]{0,5}))?")
"""An address with several colons is one of IPv6, without a port."""
KEYS = ("tool", "frame", "pin", "unit", "arm")


@dataclass(frozen=True, slots=True, kw_only=True)
class Address:
    """Where a controller is, and what must be active on it: ``HOST[:PORT][,tool=7][,frame=2][,KEY=VALUE]``."""

    host: str
    port: int | None = None
    tool: str | None = None  #: A reading with another tool is refused.
    frame: str | None = None  #: A reading with another frame is refused.
    pin: str | None = None  #: SHA-256 of the controller's certificate.
    unit: str | None = None  #: Name of the arm on a controller with several.
    arm: str | None = None  #: The model of the robot: its joints are compared with its positions.

    @classmethod
    def parse(cls, text: str) -> Address:
        """Return the address that a text is. Raises `LinkError` when it is none."""
        place, *words = [word.strip() for word in text.split(",")]
        found = HOST_PORT.fullmatch(place)
        given = dict(word.split("=", 1) for word in words if word.count("=") == 1)
        is_sound = len(given) == len(words) and set(given) <= set(KEYS)
        if not is_sound or found is None or not 0 < int(found["port"] or 1) < 65536:
            expected = f"expected HOST[:PORT] and {', '.join(f'{key}=…' for key in KEYS)} behind commas"
            raise LinkError(f"{text!r} is not the address of a robot; {expected}")
        return cls(host=found["host"], port=int(found["port"]) if found["port"] else None, **given)


def pose(values: Sequence[str | float], *, target: str = "base", source: str = "tool") -> RigidTransform:
    """Return the transform of x, y, z in mm and angles about x, y, z in degrees, ``R = Rz Ry Rx``.

    Raises `LinkError` when these are not six finite numbers.
    """
    x, y, z, *angles = numbers(values, 6)
    return RigidTransform(rotation_from_zyx(*np.radians(angles)), np.array([x, y, z]), target, source)


def numbers(values: Sequence[str | float], count: int | None = None) -> list[float]:
    """Return finite numbers as a controller prints them, with the point as decimal mark.

    Raises `LinkError` when one of them is none, or there are not `count`.
    """
    try:
        found = [parse_number(str(value)) for value in values]
    except InputError as error:
        raise LinkError(f"the controller answered a position that is not one: {error}") from None
    if len(found) != count if count is not None else len(found) > MOST_JOINTS:
        raise LinkError(f"the controller answered {len(found)} numbers, expected {count or f'at most {MOST_JOINTS}'}")
    return found


def setting_name(text: str) -> str:
    """Return the name of a tool or a frame as a controller answered it.

    Raises `LinkError` when it is longer than names are, or is not printable.
    """
    text = text.strip()
    if len(text) > LONGEST_NAME or not text.isprintable():
        raise LinkError(f"the controller answered a name that is not one: {text[:LONGEST_NAME]!r}")
    return text
