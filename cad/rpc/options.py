"""Options of a request: those of the command, by their names without dashes, with the values of JSON."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from difflib import get_close_matches
from functools import cache
from typing import Any

import click

from wpcal.cli.option_groups import command, takes
from wpcal.core.errors import InputError
from wpcal.core.wording import shown

_NUMBER, _WHOLE, _TRUTH, _TEXT = "number", "integer", "boolean", "string"
_TAKEN: Mapping[str, tuple[str, tuple[type[Any], ...]]] = {
    _TRUTH: ("true or false", ()),
    _TEXT: ("a text", (str,)),
    _NUMBER: ("a number", (int, float)),
    _WHOLE: ("a whole number", (int, float)),
}
"""What each type is called, and the values of JSON that it takes; true and false are told apart before."""


def name_of(option: click.Option) -> str:
    """Return the name of an option in a request: its long flag without dashes, with underscores."""
    return next(flag for flag in option.opts if flag.startswith("--")).removeprefix("--").replace("-", "_")


def describe_options(options: Iterable[click.Option]) -> list[dict[str, Any]]:
    """Return what a client needs to know of options: name, type, default, choices and help."""
    return [
        {
            "name": name_of(option),
            "type": _type_of(option),
            "repeated": option.multiple,
            "default": _default_of(option),
            "choices": list(option.type.choices) if isinstance(option.type, click.Choice) else None,
            "help": option.help or "",
        }
        for option in options
    ]


def words_of(options: Iterable[click.Option], values: Mapping[str, Any]) -> list[str]:
    """Return options as they are typed. Raises `InputError` if a name is unknown, or a value has another type."""
    known = {name_of(option): option for option in options}
    words = list[str]()
    for name, value in values.items():
        if name not in known:
            near = get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(known)}"
            raise InputError(f"options: {shown(name)} is unknown; {hint}")
        option = known[name]
        is_list = option.multiple and value is not None
        if is_list and not isinstance(value, list):
            raise InputError(f"options: {name}: expected a list, got {shown(value)}")
        for each in value if is_list else [value]:
            words += _words(option, name, each)
    return words


def _words(option: click.Option, name: str, value: Any) -> list[str]:
    flag, kind = f"--{name.replace('_', '-')}", _type_of(option)
    is_flag_alone = kind == _TRUTH or option._flag_needs_value
    if value is None:
        return []
    if is_flag_alone and isinstance(value, bool):
        return [flag] * value
    expected, types = _TAKEN[kind]
    if isinstance(value, bool) or not isinstance(value, types) or (kind == _WHOLE and value != int(value)):
        raise InputError(f"options: {name}: expected {expected}, got {shown(value)}")
    return [f"{flag}={int(value) if kind == _WHOLE else value}"]


def _type_of(option: click.Option) -> str:
    if option.is_flag:
        return _TRUTH
    if isinstance(option.type, click.types.IntParamType):
        return _WHOLE
    return _NUMBER if isinstance(option.type, click.types.FloatParamType) else _TEXT


def _default_of(option: click.Option) -> Any:
    default = option.to_info_dict()["default"]
    if option.multiple:
        return list(default or ())
    return default if isinstance(default, bool | int | float | str) else None


class OptionSet:
    """The options of a group (`wpcal.cli.option_groups`), for a method that has no command of its own."""

    def __init__(self, group: type[Any], *, without: Sequence[str] = ()) -> None:
        def found(*, value: Any) -> Any:
            return value

        self._without = without
        self._command = command(name="rpc")(takes("value", group)(found))

    @property
    def options(self) -> Sequence[click.Option]:
        """All options of the groups."""
        found = [each for each in self._command.params if isinstance(each, click.Option)]
        return [each for each in found if name_of(each) not in self._without]

    def read(self, values: Mapping[str, Any]) -> Any:
        """Return the group with the values of a request.

        Raises `InputError` if a name is unknown, or a value cannot be used.
        """
        words = words_of(self.options, values)
        with usage_told():
            return self._command.main(words, "wpcal rpc", standalone_mode=False)


@contextmanager
def usage_told() -> Iterator[None]:
    """Turn click's errors of use into an `InputError`."""
    try:
        yield
    except click.ClickException as error:
        raise InputError(error.format_message()) from None


@cache
def command_named(name: str) -> click.Command:
    """Return a command of `wpcal`, imported now."""
    from wpcal.cli.main import wpcal

    found = wpcal.get_command(click.Context(wpcal), name)
    if found is None:
        raise InputError(f"the command {name} is not installed")
    return found
