"""What the searches need to know of a cell: signal, speeds, times and names; one small TOML file per cell."""

from __future__ import annotations

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, fields, is_dataclass, replace
from difflib import get_close_matches
from functools import cache
from importlib.resources import files
from pathlib import Path
from typing import Any, TypeVar

from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes

SETUP_FILE = "touch-setup.toml"  #: The template, and the usual name of a cell's file.
FASTEST_SEARCH_MM_S = 100.0
"""`SearchL \\Stop` of RAPID is allowed below it, and a skip of FANUC that records its place slows down to it."""
FASTEST_AIR_MM_S = 2000.0  #: Robots that weld are not faster on lines.
LONGEST_S = 60.0  #: Waits above it are a mistake of the unit.
LARGEST_MM = 100.0  #: The same for standard deviations.
LARGEST_NUMBER = 65535  #: Of frames, inputs, registers and ports.
Section = TypeVar("Section")


@dataclass(frozen=True, slots=True)
class RapidSetup:
    """ABB: the folder on the controller into which the results are saved."""

    results_folder: str = "HOME:"


@dataclass(frozen=True, slots=True)
class KrlSetup:
    """KUKA: the number of the interrupt that a search uses, and the sensor of the package."""

    interrupt: int = 20
    sensor: int = 1


@dataclass(frozen=True, slots=True)
class FanucSetup:
    """FANUC: which registers hold the results, and the touch schedule of the package."""

    first_position_register: int = 51
    last_position_register: int = 100
    first_register: int = 151
    last_register: int = 200
    schedule: int = 1


@dataclass(frozen=True, slots=True)
class InformSetup:
    """Yaskawa: which variables hold the results."""

    first_position_variable: int = 50
    last_position_variable: int = 127
    first_byte_variable: int = 50
    last_byte_variable: int = 99
    first_double_variable: int = 50
    last_double_variable: int = 99


@dataclass(frozen=True, slots=True)
class UrSetup:
    """Universal Robots: the computer that the results are also sent to; an empty host: only to the log."""

    results_host: str = ""
    results_port: int = 50001


@dataclass(frozen=True, slots=True)
class TouchSetup:
    """How a cell senses a touch. Every value has a default. Raises `InputError` when a value is out of its range."""

    #: The digital input that turns on at contact: a name (ABB) or a number. Empty: the default of the language.
    signal: str = ""
    is_on_high: bool = True  #: Whether contact turns the input on.
    enable: str = ""  #: The digital output that switches the sensing voltage on; empty: none.
    #: `search_speed_mm_s`, `approach_speed_mm_s`, `air_speed_mm_s`: During a search, on the sensed way to its start
    #: (from 30 mm/s robots stop within about 1 mm, by which the wire bends), and between searches.
    search_speed_mm_s: float = 10.0
    approach_speed_mm_s: float = 30.0
    air_speed_mm_s: float = 100.0
    hold_s: float = 0.1  #: Wait after contact, before the robot leaves.
    #: After this many searches without a touch the program ends: the part is elsewhere, or the wire has no voltage.
    most_misses: int = 2
    #: `latency_s`, `latency_sigma_s`: From contact to the place that the controller stores: a systematic error of
    #: latency × speed along the direction, and its uncertainty.
    latency_s: float = 0.0
    latency_sigma_s: float = 0.001
    repeatability_mm: float = 0.1  #: Standard deviation of a stored place per axis.
    stick_out_sigma_mm: float = 0.5  #: Standard deviation of the wire's length, along the wire.
    with_package: bool = False  #: Use the touch-sensing package of the brand instead of plain instructions.
    #: The user frame (base) that touch programs set to the place of the part as planned; not that of weld programs,
    #: which would then weld at the planned place.
    frame_number: int = 8
    #: `rapid`, `krl`, `fanuc`, `inform`, `urscript`: What only one language knows.
    rapid: RapidSetup = RapidSetup()
    krl: KrlSetup = KrlSetup()
    fanuc: FanucSetup = FanucSetup()
    inform: InformSetup = InformSetup()
    urscript: UrSetup = UrSetup()

    def __post_init__(self) -> None:
        for name in ("search_speed_mm_s", "approach_speed_mm_s"):
            _in_range(self, name, more_than=0.0, below=FASTEST_SEARCH_MM_S)
        _in_range(self, "air_speed_mm_s", more_than=0.0, below=FASTEST_AIR_MM_S)
        for name in ("hold_s", "latency_s", "latency_sigma_s"):
            _in_range(self, name, below=LONGEST_S)
        for name in ("repeatability_mm", "stick_out_sigma_mm"):
            _in_range(self, name, below=LARGEST_MM)
        for section in (self, self.krl, self.fanuc, self.inform, self.urscript):
            for each in fields(section):
                value = getattr(section, each.name)
                if type(value) is int and not 0 <= value <= LARGEST_NUMBER:
                    raise InputError(f"{each.name}: expected a number from 0 to {LARGEST_NUMBER}, got {value}")
        for section in (self.fanuc, self.inform):
            _require_order(section)


def _require_order(section: FanucSetup | InformSetup) -> None:
    for each in fields(section):
        last = each.name.replace("first_", "last_", 1)
        if each.name != last and getattr(section, each.name) > getattr(section, last):
            first, end = getattr(section, each.name), getattr(section, last)
            raise InputError(f"{each.name} = {first} is after {last} = {end}")


def _in_range(setup: TouchSetup, name: str, *, below: float, more_than: float | None = None) -> None:
    value = getattr(setup, name)
    low = "0 or more" if more_than is None else f"more than {more_than:g}"
    if not (math.isfinite(value) and 0.0 <= value < below and (more_than is None or value > more_than)):
        raise InputError(f"{name}: expected a number of {low} and below {below:g}, got {value:g}")


@cache
def setup_template() -> str:
    """Return the text of a touch setup with every key, its default, and a sentence."""
    return files(__package__).joinpath(SETUP_FILE).read_text(encoding="utf-8")


def read_touch_setup(path: Path) -> TouchSetup:
    """Read the touch setup of a cell.

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when it is not TOML, a key is unknown, or a value is not what its key takes.
    """
    raw = read_bytes(path)
    try:
        record = tomllib.loads(raw.decode("utf-8-sig"))
    except UnicodeDecodeError:
        raise FormatError("is not a UTF-8 text file", path=str(path)) from None
    except (ValueError, RecursionError) as error:
        raise FormatError(f"is not TOML: {error}", path=str(path)) from None
    try:
        return _filled(TouchSetup(), record, where="")
    except InputError as error:
        raise FormatError(str(error), path=str(path)) from None


def _filled(section: Section, record: Mapping[str, Any], *, where: str) -> Section:
    """Return a section with the values of a record."""
    known = {each.name: getattr(section, each.name) for each in fields(section)}  # type: ignore[arg-type]
    values = {}
    for key, value in record.items():
        place = f"[{where}] {key}" if where else key
        if key not in known:
            raise InputError(f"unknown key {place!r}{_hint(key, known, where)}")
        if is_dataclass(known[key]):
            if not isinstance(value, dict):
                raise InputError(f"{place}: expected a section [{key}], got {value!r}")
            values[key] = _filled(known[key], value, where=key)
        else:
            values[key] = _value(value, known[key], place)
    return replace(section, **values)  # type: ignore[type-var]


def _hint(key: str, known: Mapping[str, Any], where: str) -> str:
    inner = {name: value for name, value in known.items() if is_dataclass(value) and not isinstance(value, type)}
    home = next((name for name, section in inner.items() if key in {each.name for each in fields(section)}), "")
    if home:
        return f": it belongs into the section [{home}]"
    if where and key in {each.name for each in fields(TouchSetup)}:
        return f": it belongs before the first section, not into [{where}]"
    near = get_close_matches(key, known, n=1)
    return f"; did you mean {near[0]}?" if near else f"; known: {', '.join(known)}"


def _value(value: Any, default: Any, place: str) -> Any:
    """Return a value of the type of its default; a signal may be typed as a number."""
    if isinstance(default, bool):
        expected, fits = "true or false", isinstance(value, bool)
    elif isinstance(default, int):
        expected, fits = "a whole number", type(value) is int
    elif isinstance(default, float):
        expected, fits = "a number", isinstance(value, int | float) and not isinstance(value, bool)
        value = float(value) if fits else value
    else:
        expected, fits = "a text in quotes", isinstance(value, str) or type(value) is int
        value = str(value) if fits else value
    if not fits:
        raise InputError(f"{place}: expected {expected}, got {value!r}")
    return value
