"""Options: a field of a frozen dataclass says its default, help and bounds once, for the library and for every command.

The bridge to the command line is `wpcal.cli.option_groups`; this module knows no click and no NumPy. A field whose name
ends in ``_rad`` is stated in degrees (``--…-deg``); an enumeration is stated by its values; a tuple of numbers as text
with commas.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import MISSING, dataclass, field
from typing import Any

from wpcal.core.errors import InputError

OPTION, GROUP, ONLY = "option", "group", "only"
"""Keys in the metadata of a field."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Option:
    """What a field says as an option."""

    help: str
    flags: tuple[str, ...] = ()  #: As typed. If empty: the field's name with dashes.
    #: `least`, `above`, `most`: Closed lower, open lower and closed upper bound, in the unit of the flag.
    least: float | None = None
    above: float | None = None
    most: float | None = None
    metavar: str | None = None
    many: bool = False  #: Whether the option may be repeated.
    #: Members of the field's enumeration, or words, that may be chosen; by default all members.
    choices: tuple[Any, ...] | None = None
    #: For an enumeration without a flag of its own: flags, each with the member that it chooses and its help.
    switches: Mapping[str, tuple[Any, str]] | None = None
    #: Makes the field's value of what was typed; ``"module:function"`` is imported when it is needed.
    read: Callable[[Any], Any] | str | None = None
    show: Callable[[Any], Any] | None = None  #: The inverse of `read` for the default.
    type: type | None = None  #: What is typed, where `read` takes something other than a text.
    if_alone: str | None = None  #: The value of the flag when it is typed without one.
    is_shown: bool = True  #: Whether the help says the default.


def group(where: str | type[Any], *, only: tuple[str, ...] = ()) -> Any:
    """Declare a field that is an inner group: a class, or where it is (``"module:Class"``).

    `only`: The fields of the group that are options; the others are left at their defaults. Empty: all.
    """
    return field(metadata={GROUP: where, ONLY: only})


def opt(default: Any, help: str, *flags: str, default_factory: Any = MISSING, **settings: Any) -> Any:  # noqa: A002
    """Declare a field of a frozen dataclass that is an option; `settings` are the other fields of `Option`.

    >>> @dataclass(frozen=True)
    ... class Motion:
    ...     approach_mm: float = opt(50.0, "Along the wire, before the seam.", least=0.0)
    ...     lean_rad: float = opt_deg(10.0, "How far the torch leans.", "--lean-deg")
    >>> Motion().approach_mm
    50.0
    """
    metadata = {OPTION: Option(help=help, flags=flags, **settings)}
    if default_factory is not MISSING:
        return field(default_factory=default_factory, metadata=metadata)
    return field(default=default, metadata=metadata)


def opt_deg(default_deg: float | None, help: str, *flags: str, **settings: Any) -> Any:  # noqa: A002
    """Declare an angle: the field is in radians, the default and the bounds are stated in degrees."""
    return opt(None if default_deg is None else math.radians(default_deg), help, *flags, **settings)


@contextmanager
def named_option(flag: str) -> Iterator[None]:
    """Put the flag before the message of an `InputError` about the value of an option."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{flag}: {error}", code=error.code) from None
