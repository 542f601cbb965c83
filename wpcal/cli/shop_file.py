"""What a shop says once: options in ``wpcal.toml``, found upwards from the part, or in variables ``WPCAL_…``.

The first of these that has a value counts: the option as typed, the variable, the table of the command in the file, the
top of the file, the default of wpcal.
"""

from __future__ import annotations

import os
import re
from collections.abc import Collection, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import click

from wpcal.cli.help_sections import key_of

SHOP_FILE = "wpcal.toml"
VARIABLE = "WPCAL_"
_SAID_ONCE = """
    torch work_range_deg travel_range_deg turn_deg neck_range_deg standoff_mm nozzle_radius_mm wire_mm torch_length_mm
    wire_diameter_mm tool tool_name tool_number tool_axis robot cell config format frame_number arc arc_output template
    weld_rules setup post tacks weave clearance_mm air_clearance_mm seam_clearance_mm approach_mm retract_mm speed_mm_s
    air_speed_mm_s joint_margin_deg path_tol_mm position_tol_deg work_angle_deg travel_angle_deg tolerance_mm sigma_mm
    tcp_bias_mm tool_mm robot_mm tack_mm tack_mrad criterion ball_mm uncertainty_mm uncertainty_deg up gap_mm join_mm
    min_length_mm wrap concave not weld lean_deg_per_mm chord_mm max_step_mm min_step_mm paper jobs job_gb job_seconds
"""
SAID_ONCE = frozenset(_SAID_ONCE.split())
"""Options that are the same on every part of a shop. What belongs to one part, writes a file or opens a port is not."""
NAME_OR_FILE = frozenset({"robot", "tool", "torch", "robot_mm", "tool_mm"})
"""Options that take a file or something else; a value with a separator of folders or an ending is a file."""
OTHER_VARIABLES = frozenset({"CACHE", "CACHE_MB", "KERNEL_TIME_S", "KERNEL_MEMORY_GB", "MOST_MB", "DEBUG"})
"""Variables ``WPCAL_…`` that say no option."""
FILE_NAME = re.compile(r"[/\\]|\.[A-Za-z]\w*$")
"""A separator of folders, or an ending with a letter: ``arms/kr``, ``kr.json``; not ``0.3,500``."""
ADDRESS = re.compile(r"[a-z][a-z-]+:")  #: Of a robot, as ``ur:robot.local``.


@dataclass(frozen=True, slots=True)
class Shop:
    """A file ``wpcal.toml``."""

    path: Path | None = None  #: None where there is none.
    common: Mapping[str, Any] = field(default_factory=dict)  #: By the name of the option, with underscores.
    tables: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)  #: By command.


@dataclass(frozen=True, slots=True)
class Said:
    """One option that a shop says."""

    option: click.Option
    value: Any
    origin: str  #: The file, with its table if there is one, or the variable.

    @property
    def flag(self) -> str:
        """As it is typed."""
        return max(self.option.opts, key=len)

    def __str__(self) -> str:
        values = self.value if isinstance(self.value, list) else [self.value]
        return self.flag if self.value is True else " ".join(f"{self.flag} {value}" for value in values)


@dataclass(frozen=True, slots=True)
class Typed:
    """What is among the words of a command."""

    arguments: tuple[str, ...] = ()  #: In their order; no value of an option.
    options: frozenset[str] = frozenset()  #: Names of parameters.


def typed(command: click.Command, words: Sequence[str]) -> Typed:
    """Return what was typed; nothing when the command does not take the words, which it then says itself."""
    with suppress(click.UsageError):
        values, _, order = command.make_parser(click.Context(command)).parse_args(list(words))
        given = [values[each.name] for each in order if isinstance(each, click.Argument) and each.name]
        flat = [word for each in given for word in (each if isinstance(each, list | tuple) else [each])]
        names = frozenset(each.name or "" for each in order if isinstance(each, click.Option))
        return Typed(tuple(word for word in flat if isinstance(word, str)), names)
    return Typed()


def find_shop(arguments: Sequence[str]) -> Shop:
    """Return the shop of the first argument of a command that is a file or folder: the nearest file upwards from it.

    Without one, it is looked for from the current folder.
    """
    start = next((Path(word) for word in arguments if os.path.exists(word)), Path()).resolve()
    for folder in (start, *start.parents):
        if (folder / SHOP_FILE).is_file():
            return read_shop(folder / SHOP_FILE)
    return Shop()


def read_shop(path: Path) -> Shop:
    """Read a file of a shop.

    Raises `InputError` when the file cannot be opened, `FormatError` when it is not TOML or a key is unknown.
    """
    from wpcal.core.errors import FormatError
    from wpcal.core.input_file import read_bytes

    try:
        return shop_of(read_bytes(path).decode("utf-8-sig"), path)
    except UnicodeDecodeError:
        raise FormatError("is not a UTF-8 text file", path=str(path)) from None


def shop_of(text: str, path: Path) -> Shop:
    """Return what the text of a file says. Raises `FormatError` when it is not TOML or a key is unknown."""
    import tomllib

    from wpcal.core.errors import FormatError

    try:
        record = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise FormatError(f"is not TOML: {error}", path=str(path)) from None
    tables = {key: value for key, value in record.items() if isinstance(value, dict)}
    common = {key: value for key, value in record.items() if key not in tables}
    for table, values in {"": common, **tables}.items():
        for key in values:
            if key not in SAID_ONCE:
                where = f"[{table}] {key}" if table else key
                hint = _near(key.lower().replace("-", "_"), SAID_ONCE) or "`wpcal shop` lists what a shop can say"
                raise FormatError(f"unknown key {where!r}; {hint}", path=str(path))
    return Shop(path, common, tables)


def require_tables(shop: Shop, commands: Collection[str]) -> None:
    """Refuse a table that is of no command. Raises `FormatError`."""
    from wpcal.core.errors import FormatError

    for table in shop.tables:
        if table not in commands:
            hint = _near(table, commands) or "a table is for one command, as [export]"
            raise FormatError(f"unknown table [{table}]; {hint}", path=str(shop.path))


def require_variables() -> None:
    """Refuse a variable that is nearly one that says an option: it would be left out silently.

    Raises `click.UsageError`.
    """
    known = {key.upper() for key in SAID_ONCE}
    for variable in sorted(os.environ):
        name = variable.removeprefix(VARIABLE)
        if name == variable or name in known | OTHER_VARIABLES:
            continue
        if near := get_close_matches(name.upper(), known, n=1, cutoff=0.8):
            raise click.UsageError(f"unknown variable {variable}; did you mean {VARIABLE}{near[0]}?")


def _near(word: str, words: Collection[str]) -> str:
    near = get_close_matches(word, words, n=1)
    return f"did you mean {near[0]}?" if near else ""


def said_of(command: click.Command, name: str, shop: Shop) -> dict[str, Said]:
    """Return what a shop says of a command, by the names of its parameters.

    Raises `FormatError` when a value is not what its option takes, `click.UsageError` when that of a variable is not.
    """
    return {option.name or "": said for option, said in _stated(command, name, shop)}


def _stated(command: click.Command, name: str, shop: Shop) -> Iterator[tuple[click.Option, Said]]:
    from wpcal.core.errors import FormatError

    own = shop.tables.get(name, {})
    keys = {key_of(option) for option in command.params if isinstance(option, click.Option)}
    if foreign := sorted(own.keys() - keys):
        raise FormatError(f"[{name}] {foreign[0]}: `wpcal {name}` has no such option", path=str(shop.path))
    for option in command.params:
        if not isinstance(option, click.Option) or (key := key_of(option)) not in SAID_ONCE:
            continue
        variable = f"{VARIABLE}{key.upper()}"
        if variable in os.environ:
            value: Any = os.environ[variable]
            value = value.split(",") if option.multiple else value
            yield option, Said(option, _taken(option, value, click.UsageError, variable), variable)
        elif key in own or key in shop.common:
            found = own.get(key, shop.common.get(key))
            table = f"[{name}] " if key in own else ""
            where = f"{shop.path}: {table}{key}"
            is_file = isinstance(option.type, click.Path)
            value = _beside(found, shop.path, is_file) if shop.path and (is_file or key in NAME_OR_FILE) else found
            yield option, Said(option, _taken(option, value, FormatError, where), f"{SHOP_FILE} {table}".strip())


def _taken(option: click.Option, value: Any, error: type[Exception], where: str) -> Any:
    """Return a value if the option takes it."""
    if option.multiple and not isinstance(value, list):
        value = [value]
    try:
        for each in value if option.multiple else [value]:
            _require_kind(option, each)
    except click.ClickException as wrong:
        raise error(f"{where}: {wrong.message}") from None
    return value


def _require_kind(option: click.Option, value: Any) -> None:
    """Refuse one value that the option does not take."""
    if isinstance(value, list):
        raise click.BadParameter("expected one value, got a list")
    is_switch = option.is_flag and isinstance(option.flag_value, bool)
    if is_switch and not isinstance(value, bool | str):
        raise click.BadParameter("expected true or false")
    if isinstance(value, bool) and not is_switch:
        raise click.BadParameter(f"expected a value, got {value}")
    option.type.convert(value if is_switch else str(value), option, None)


def _beside(value: Any, shop: Path, is_file: bool) -> Any:
    """Return a value; the name of a file is taken from the folder of the shop's file."""
    if isinstance(value, list):
        return [_beside(each, shop, is_file) for each in value]
    is_named = isinstance(value, str) and FILE_NAME.search(value) and not ADDRESS.match(value)
    names_file = isinstance(value, str) and value and (is_file or is_named)
    return str(shop.parent / value) if names_file else value
