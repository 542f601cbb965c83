"""The robot controllers that wpcal knows: one record each, found by the entry points ``wpcal.controllers``.

To add a controller, make one folder and one entry-point line. The folder holds `write.py` and, where wpcal can do more,
`read.py` (taught points), `sync.py` (two robots in step) and `touch.py` (searches). Its `__init__.py` holds the
`Controller`:

.. code-block:: toml

    [project.entry-points."wpcal.controllers"]
    acme = "acme_robots:ACME"
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from importlib.metadata import EntryPoint
from pathlib import Path
from pkgutil import resolve_name
from typing import TYPE_CHECKING, Any

from wpcal.controllers.program.weld_program import WeldProgram
from wpcal.core.errors import InputError
from wpcal.core.installed import installed
from wpcal.core.options import named_option
from wpcal.taught.programs import ProgramReader

if TYPE_CHECKING:
    from wpcal.controllers.language.grammar import Grammar
    from wpcal.controllers.program import WeldProgram
    from wpcal.controllers.program.coordinated_program import CoordinatedProgram, SyncProgram
    from wpcal.controllers.program.touch_program import TouchProgram
    from wpcal.touch.searches import ResultsFile, SearchResults, TouchPlan, TouchResultsReader, TouchSetup

CONTROLLERS = "wpcal.controllers"  #: The entry-point group.


@dataclass(frozen=True, slots=True)
class Controller:
    """What wpcal can do in the language of one controller.

    Functions are given as ``package.module:name`` and imported when they are first used: the record of a controller
    costs nothing until a program is written or read.

    Raises `InputError` when there are suffixes without a reader, a reader without suffixes, or a suffix is not
    ``.lowercase``.
    """

    name: str  #: The format's name in `wpcal export`; the same as the name of the entry point.
    title: str  #: One line for people: the controller, and the files that are written.
    #: A function from `WeldProgram` to file names and contents (text is written as UTF-8). It checks every limit of the
    #: language and raises `InputError` before it returns.
    writer: str
    suffixes: tuple[str, ...] = ()  #: Suffixes of the files that `reader` reads: lower case, with the dot.
    reader: str | None = None  #: A `wpcal.taught.programs.ProgramReader`.
    #: Names of files that `reader` reads although their suffix is of another controller, lower case.
    variables: tuple[str, ...] = ()
    sync_writer: str | None = None  #: A function from `SyncProgram` to file names and contents.
    coordinated_writer: str | None = None  #: A function from `CoordinatedProgram` to file names and contents.
    touch_writer: str | None = None  #: A function from `TouchProgram` to file names and contents.
    touch_results_reader: str | None = None  #: A `wpcal.touch.searches.TouchResultsReader`.
    #: Names of the files that it reads together, as patterns, lower case.
    touch_results: tuple[str, ...] = ()
    #: How `coordinated_writer` moves the robot that holds the part: on lines, otherwise by joints.
    holder_on_line: bool = False
    coordinates_arcs: bool = True  #: Whether the torch may move on arcs in `coordinated_writer`.
    brands: tuple[str, ...] = ()  #: What people also call it, lower case: the maker. Taken wherever `name` is.
    #: A `wpcal.controllers.language.grammar.Grammar`. Without one, what `writer` writes is never called checked.
    grammar: str | None = None
    #: The class of a `wpcal.controllers.run` interpreter, which executes its programs.
    run: str | None = None
    program_suffixes: tuple[str, ...] = ()  #: Suffixes of the files that both understand.
    #: Whether `writer` writes the lines and arcs of `WeldPath.weld_moves`. Otherwise it gets a pose for every frame.
    takes_arcs: bool = False
    takes_plans: bool = False  #: Whether `writer` writes plans: joint moves between seams, and external axes.

    #: Whether `writer` writes the zones of `JointMoves`, and they bound how far the tool leaves a corner.
    takes_zones: bool = False
    welds_alone: bool = False  #: Whether its programs of plans have a routine for each seam alone, from and to home.

    def __post_init__(self) -> None:
        if (self.reader is None) != (not self.suffixes):
            raise InputError(f"controller {self.name!r}: a reader needs suffixes, and suffixes need a reader")
        for suffix in self.suffixes:
            if not suffix.startswith(".") or suffix != suffix.lower():
                raise InputError(f"controller {self.name!r}: expected a suffix as .abc, lower case, got {suffix!r}")

    def write(self, program: WeldProgram) -> Mapping[str, str | bytes]:
        """Return the files of a weld program: names and contents.

        Raises `InputError` when the language cannot hold the program.
        """
        planned = program.planned
        if planned is not None and planned.follows and planned.is_carried != self.coordinates_arcs:
            where = "the part that the positioner carries" if self.coordinates_arcs else "the base of the robot"
            raise InputError(f"{self.name}: the positioner turns along a seam: positions are expected in {where}")
        files: Mapping[str, str | bytes] = self._load(self.writer)(program)
        return files

    def write_sync(self, program: SyncProgram) -> Mapping[str, str]:
        """Return the files of a program of two robots; `InputError` when the controller cannot hold it."""
        return self._texts(self.sync_writer, "two robots", program)

    def write_coordinated(self, program: CoordinatedProgram) -> Mapping[str, str]:
        """Return the files of two robots in coordinated motion; `InputError` when the controller cannot hold it."""
        return self._texts(self.coordinated_writer, "two robots in coordinated motion", program)

    def write_touches(self, program: TouchProgram) -> Mapping[str, str]:
        """Return the files of a program of touches; `InputError` when the controller cannot hold it."""
        return self._texts(self.touch_writer, "touches", program)

    def _texts(self, writer: str | None, kind: str, program: object) -> Mapping[str, str]:
        if writer is None:
            raise InputError(f"{self.name} has no programs of {kind}")
        files: Mapping[str, str] = self._load(writer)(program)
        return files

    def read_touches(self, files: Sequence[ResultsFile], plan: TouchPlan, setup: TouchSetup) -> SearchResults:
        """Return the results of a touch program, from the files of this controller.

        Raises `InputError` when the controller has no reader of them, or the files cannot be used.
        """
        if self.touch_results_reader is None:
            raise InputError(f"{self.name}: results of touch programs cannot be read from files of this controller")
        read: TouchResultsReader = self._load(self.touch_results_reader)
        return read(files, plan, setup)

    def load_reader(self) -> ProgramReader:
        """Return what reads the taught points of this controller's files.

        Raises `InputError` when the controller has no reader.
        """
        if self.reader is None:
            raise InputError(f"{self.name}: taught points cannot be read from files of this controller")
        reader = self._load(self.reader)
        if not isinstance(reader, ProgramReader):
            raise InputError(f"controller {self.name!r}: {self.reader} is not a wpcal.taught.ProgramReader")
        return reader

    def load_grammar(self) -> Grammar | None:
        """Return what understands the programs of this controller; None if nothing does."""
        return None if self.grammar is None else self._load(self.grammar)

    def load_interpreter(self) -> Any:
        """Return the class that executes the programs of this controller; None if nothing does."""
        return None if self.run is None else self._load(self.run)

    def _load(self, reference: str) -> Any:
        try:
            return resolve_name(reference)
        except (ImportError, AttributeError, ValueError) as error:
            raise InputError(f"controller {self.name!r}: {reference} cannot be loaded: {error}") from None


def controller_names() -> tuple[str, ...]:
    """Return the names of the installed controllers, sorted."""
    return tuple(sorted({entry.name for entry in installed(CONTROLLERS)}))


def controllers() -> tuple[Controller, ...]:
    """Return the installed controllers, sorted by name.

    Raises `InputError` when an entry point is not a `Controller` of that name.
    """
    return tuple(_record(entry) for entry in sorted(installed(CONTROLLERS), key=lambda entry: entry.name))


def controller_named(name: str) -> Controller:
    """Return one controller, by its name or its maker's.

    Raises `InputError` when no controller has this name, with the known names.
    """
    found = find_controller(name)
    if found is None:
        raise InputError(f"unknown controller {name!r}{suggestion(name, spoken_names())}")
    return found


def find_controller(name: str) -> Controller | None:
    """Return the controller with this name, or of this maker, whatever the case; None when there is none."""
    wanted = name.strip().lower()
    entries = {entry.name: entry for entry in reversed(installed(CONTROLLERS))}
    found = entries.get(wanted) or entries.get(name)
    if found is not None:
        return _record(found)
    return next((controller for controller in controllers() if wanted in controller.brands), None)


def spoken_names() -> tuple[str, ...]:
    """Return the names of the controllers and of their makers, sorted."""
    return tuple(sorted({*controller_names(), *(brand for each in controllers() for brand in each.brands)}))


def suggestion(name: str, known: Sequence[str]) -> str:
    """Return the end of a message about an unknown name: the nearest known one, and all of them."""
    near = get_close_matches(name.strip().lower(), known, n=1)
    return f"{f': did you mean {near[0]}?' if near else ';'} known: {', '.join(known)}"


def controller_of_file(path: Path) -> Controller | None:
    """Return the controller whose taught points a file holds, by its name or suffix; None when none claims it.

    Raises `InputError` when two controllers claim the suffix.
    """
    named = [each for each in controllers() if path.name.lower() in each.variables]
    return named[0] if named else _claiming(path, lambda controller: controller.suffixes)


def grammar_of_file(path: Path) -> Grammar | None:
    """Return what understands a file, by its suffix; None when no controller claims it.

    Raises `InputError` when two controllers claim the suffix.
    """
    claimed = controller_of_program(path)
    return None if claimed is None else claimed.load_grammar()


def controller_of_program(path: Path) -> Controller | None:
    """Return the controller whose programs have the suffix of a file; None when no controller claims it.

    Raises `InputError` when two controllers claim the suffix.
    """
    return _claiming(path, lambda controller: controller.program_suffixes)


def grammars() -> tuple[Grammar, ...]:
    """Return the grammars of all controllers that have one."""
    return tuple(grammar for each in controllers() if (grammar := each.load_grammar()) is not None)


def _claiming(path: Path, suffixes: Callable[[Controller], tuple[str, ...]]) -> Controller | None:
    suffix = path.suffix.lower()
    claims = [controller for controller in controllers() if suffix in suffixes(controller)]
    if len(claims) > 1:
        raise InputError(f"{path}: {suffix} files are claimed by {' and '.join(claim.name for claim in claims)}")
    return claims[0] if claims else None


def _record(entry: EntryPoint) -> Controller:
    try:
        record = entry.load()
    except (ImportError, AttributeError) as error:
        raise InputError(f"controller {entry.name!r}: {entry.value} cannot be loaded: {error}") from None
    if not isinstance(record, Controller) or record.name != entry.name:
        raise InputError(f"controller {entry.name!r}: {entry.value} is not a wpcal.controllers.Controller of this name")
    return record


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


def exporter_named(name: str) -> Exporter | Controller:
    """Return one format or controller, by its name or its maker's; a controller goes before a format of the same name.

    Raises `InputError` when the name is unknown, with the nearest name and the known ones, or its entry point is not an
    `Exporter`.
    """
    if "," in name:
        each = " ".join(f"-f {one.strip()}" for one in name.split(",") if one.strip())
        raise InputError(f"{name!r} is more than one format; give each by itself: {each}")
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
