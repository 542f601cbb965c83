"""Everything that `wpcal export` can write: open formats (entry points ``wpcal.exporters``), and all controllers."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from wpcal.controllers.program.weld_program import WeldProgram
from wpcal.controllers.registry import Controller, controller_names, find_controller, spoken_names, suggestion
from wpcal.core.errors import InputError
from wpcal.core.installed import installed
from wpcal.core.options import named_option

EXPORTERS = "wpcal.exporters"  #: The entry-point group of formats that do not belong to a controller.


@dataclass(frozen=True, slots=True)
class Exporter:
    """One open format."""

    name: str  #: The format's name in `wpcal export`.
    title: str  #: One line for people: the format, and the files that are written.
    #: From a `WeldProgram` to file names and contents (text is written as UTF-8). It checks every limit of the format
    #: and raises `InputError` before it returns.
    write: Callable[[WeldProgram], Mapping[str, str | bytes]]


def exporter_names() -> tuple[str, ...]:
    """Return the names of all installed formats and controllers, sorted."""
    return tuple(sorted({*controller_names(), *(entry.name for entry in installed(EXPORTERS))}))


def _each_by_itself(names: str) -> str:
    return " ".join(f"-f {name.strip()}" for name in names.split(",") if name.strip())


def exporter_named(name: str) -> Exporter | Controller:
    """Return one format or controller, by its name or its maker's; a controller goes before a format of the same name.

    Raises `InputError` when the name is unknown, with the nearest name and the known ones, or its entry point is not an
    `Exporter`.
    """
    if "," in name:
        raise InputError(f"{name!r} is more than one format; give each by itself: {_each_by_itself(name)}")
    controller = find_controller(name)
    if controller is not None:
        return controller
    entries = {entry.name: entry for entry in reversed(installed(EXPORTERS))}
    entry = entries.get(name) or entries.get(name.strip().lower())
    if entry is None:
        raise InputError(f"unknown format {name!r}{suggestion(name, sorted({*exporter_names(), *spoken_names()}))}")
    exporter = entry.load()
    if not isinstance(exporter, Exporter):
        raise InputError(f"format {name!r}: the entry point {entry.value} is not a wpcal.formats.Exporter")
    return exporter


def parse_configurations(given: Sequence[str]) -> Mapping[str, str]:
    """Return configurations of an arm by the format that they are for, "" for all, from texts ``[FORMAT=]CONFIG``.

    Raises `InputError` when a format is unknown, or given twice.
    """
    configurations: dict[str, str] = {}
    for each in given:
        name, _, value = each.rpartition("=")
        with named_option(f"--config {each}"):
            name = name and exporter_named(name).name
        if name in configurations:
            raise InputError(f"--config {each}: {f'{name} is' if name else 'a value for all formats is'} given twice")
        configurations[name] = value.strip()
    return configurations
