"""Option groups: the options of one subject reach a command as one typed value.

A group is a frozen dataclass. Each field is an `option` of the command line; a field without one holds another group.
The decorator `takes` adds the options to a command and passes the group to it as one argument.
"""

from __future__ import annotations

import functools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import field, fields
from typing import Any, TypeVar, get_type_hints

import click

_OPTION = "option"
"""Key in the metadata of a field."""

Command = TypeVar("Command", bound=Callable[..., Any])


def option(*flags: str, **settings: Any) -> Any:
    """Declare a field of a group; the arguments are those of `click.option`. The field's name is the parameter's."""
    return field(metadata={_OPTION: (flags, settings)})


def takes(argument: str, group: type[Any]) -> Callable[[Command], Callable[..., Any]]:
    """Add the options of a group to a command, which receives the group as one argument.

    Parameters
    ----------
    argument : str
        Name of the command's argument.
    group : type
        A frozen dataclass with keyword-only fields. Their order is the order in the help.
    """

    def decorate(command: Command) -> Callable[..., Any]:
        @functools.wraps(command)
        def call(*arguments: Any, **values: Any) -> Any:
            names = set(option_names(group))
            others = {name: value for name, value in values.items() if name not in names}
            return command(*arguments, **others, **{argument: group_of(group, values)})

        decorated: Callable[..., Any] = call
        for name, flags, settings in reversed(list(_options(group))):
            decorated = click.option(*flags, name, **settings)(decorated)
        return decorated

    return decorate


def option_names(group: type[Any]) -> Sequence[str]:
    """Return the names of the click parameters that a group adds."""
    return [name for name, _, _ in _options(group)]


def _options(group: type[Any]) -> Iterator[tuple[str, Sequence[str], Mapping[str, Any]]]:
    """Yield name, flags and settings of every option, those of inner groups at their place."""
    inner = _inner_groups(group)
    for each in fields(group):
        if each.name in inner:
            yield from _options(inner[each.name])
        else:
            flags, settings = each.metadata[_OPTION]
            yield each.name, flags, settings


def group_of(group: type[Any], values: Mapping[str, Any]) -> Any:
    """Return a group from the values of a command's parameters, by name, as click parsed them."""
    inner = _inner_groups(group)
    names = [each.name for each in fields(group)]
    return group(**{name: group_of(inner[name], values) if name in inner else values[name] for name in names})


def _inner_groups(group: type[Any]) -> dict[str, type[Any]]:
    names = [each.name for each in fields(group) if _OPTION not in each.metadata]
    hints = get_type_hints(group) if names else {}
    return {name: hints[name] for name in names}
