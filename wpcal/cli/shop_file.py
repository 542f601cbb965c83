"""What a shop says once: options in ``wpcal.toml``, found upwards from the part, or in variables ``WPCAL_…``.

The first of these that has a value counts: the option as typed, the variable, the table of the command in the file, the
top of the file, the default of wpcal.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
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
    tcp_bias_mm robot_mm tack_mm tack_mrad criterion ball_mm uncertainty_mm uncertainty_deg up gap_mm join_mm
    min_length_mm wrap concave not chord_mm max_step_mm min_step_mm paper jobs job_gb job_seconds
"""
SAID_ONCE = frozenset(_SAID_ONCE.split())
"""Options that are the same on every part of a shop. What belongs to one part, writes a file or opens a port is not."""


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


def find_shop(words: Sequence[str]) -> Shop:
    """Return the shop of the first file among the words of a command: the nearest file upwards from its folder.

    Without a file, it is looked for from the current folder.
    """
    start = next((Path(word) for word in words if not word.startswith("-") and os.path.exists(word)), Path()).resolve()
    for folder in (start, *start.parents):
        if (folder / SHOP_FILE).is_file():
            return read_shop(folder / SHOP_FILE)
    return Shop()


def read_shop(path: Path) -> Shop:
    """Read a file of a shop.

    Raises `InputError` when the file cannot be opened, `FormatError` when it is not TOML or a key is unknown.
    """
    import tomllib

    from wpcal.core.errors import FormatError
    from wpcal.core.input_file import read_bytes

    try:
        record = tomllib.loads(read_bytes(path).decode("utf-8-sig"))
    except UnicodeDecodeError:
        raise FormatError("is not a UTF-8 text file", path=str(path)) from None
    except (ValueError, RecursionError) as error:
        raise FormatError(f"is not TOML: {error}", path=str(path)) from None
    tables = {key: value for key, value in record.items() if isinstance(value, dict)}
    common = {key: value for key, value in record.items() if key not in tables}
    for table, values in {"": common, **tables}.items():
        for key in values:
            if key not in SAID_ONCE:
                where = f"[{table}] {key}" if table else key
                near = get_close_matches(key.lower().replace("-", "_"), SAID_ONCE, n=1)
                hint = f"did you mean {near[0]}?" if near else "`wpcal shop` lists what a shop can say"
                raise FormatError(f"unknown key {where!r}; {hint}", path=str(path))
    return Shop(path, common, tables)


def said_of(command: click.Command, name: str, shop: Shop) -> dict[str, Said]:
    """Return what a shop says of a command, by the names of its parameters.

    Raises `FormatError` when a value is not what its option takes, `click.UsageError` when that of a variable is not.
    """
    return {option.name or "": said for option, said in _stated(command, name, shop)}


def _stated(command: click.Command, name: str, shop: Shop) -> Iterator[tuple[click.Option, Said]]:
    from wpcal.core.errors import FormatError

    own = shop.tables.get(name, {})
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
            value = _beside(found, shop.path.parent if shop.path else Path())
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


def _beside(value: Any, folder: Path) -> Any:
    """Return a value; the name of a file is taken from the folder of the shop's file."""
    if isinstance(value, list):
        return [_beside(each, folder) for each in value]
    is_file = isinstance(value, str) and value and (folder / value).exists() and not Path(value).is_absolute()
    return str(folder / value) if is_file else value


def is_typed(said: Said, words: Sequence[str]) -> bool:
    """Whether an option is among the words of a command."""
    flags = {*said.option.opts, *said.option.secondary_opts}
    return any(word.partition("=")[0] in flags or word[:2] in flags for word in words)
