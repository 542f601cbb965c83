"""The formats that wpcal can write, found by entry point `wpcal.exporters`; others add theirs in the same way."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import entry_points

from wpcal.controllers.program import WeldProgram
from wpcal.core.errors import InputError

ENTRY_POINT_GROUP = "wpcal.exporters"


@dataclass(frozen=True, slots=True)
class Exporter:
    """One format.

    Parameters
    ----------
    name : str
        As given to ``--format``.
    title : str
        One line for people: the controller and the files.
    write : callable
        From a `WeldProgram` to file names and their contents (text is written as UTF-8). It checks every limit of its
        format and raises `InputError` before it returns anything.
    """

    name: str
    title: str
    write: Callable[[WeldProgram], Mapping[str, str | bytes]]


def exporter_names() -> tuple[str, ...]:
    """Return the names of the formats that are installed, sorted."""
    return tuple(sorted(entry_points(group=ENTRY_POINT_GROUP).names))


def exporter_named(name: str) -> Exporter:
    """Load one format.

    Raises
    ------
    InputError
        When there is none of that name (with the known ones), or what is registered is no `Exporter`.
    """
    found = entry_points(group=ENTRY_POINT_GROUP, name=name)
    if not found:
        raise InputError(f"unknown format {name!r}; known: {', '.join(exporter_names())}")
    exporter = next(iter(found)).load()
    if not isinstance(exporter, Exporter):
        raise InputError(f"format {name!r}: the entry point {next(iter(found)).value} is no wpcal.controllers.Exporter")
    return exporter
