"""Option groups: the options of one subject reach a command as one typed value.

A group is a frozen dataclass, of the library where it has one. Its fields are declared with `wpcal.core.options.opt`;
a field without one that is such a dataclass is an inner group. A group named as ``"module:Class"`` is imported when its
command is called or its help is asked for: `wpcal --help` needs no NumPy.
"""

from __future__ import annotations

import functools
import inspect
import math
import sys
import types
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import MISSING, Field, dataclass, fields, is_dataclass, replace
from enum import Enum
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar, Union, get_args, get_origin

import click

from wpcal.cli.help_sections import SectionedCommand, help_all
from wpcal.cli.number_options import strict_number
from wpcal.core.options import GROUP, ONLY, OPTION, Option

Callback = TypeVar("Callback", bound=Callable[..., Any])
Group = type[Any] | str
"""A dataclass, or where it is."""
DEGREES = 9  #: Decimals of a default in degrees: radians and back are off by round-off.


def takes(
    argument: str, group: Group, *, without: Sequence[str] = (), only: Sequence[str] = (), later: bool = False
) -> Callable[[Callback], Callable[..., Any]]:
    """Add the options of a group to a command (made by `command`), which receives the group as one argument.

    `without`, `only`: Fields that are left at their defaults, or all that are options. Groups may share an option: each
    gets its value.
    """
    asked = _Asked(group, tuple(without), tuple(only))

    def decorate(callback: Callback) -> Callable[..., Any]:
        @functools.wraps(callback)
        def call(*arguments: Any, **values: Any) -> Any:
            given = dict(click.get_current_context().params)
            others = {name: value for name, value in values.items() if name not in asked.names}
            group = functools.partial(asked.build, given)
            return callback(*arguments, **others, **{argument: group if later else group()})

        call.__dict__.setdefault("__click_params__", []).append(asked)
        return call

    return decorate


class GroupedCommand(SectionedCommand):
    """A command whose options are those of its groups, found when they are first asked for."""

    _declared: list[Any]
    _params: list[click.Parameter] | None

    @property
    def params(self) -> list[click.Parameter]:
        """Return the parameters in the order of the help, with strict numbers; an option of two groups once."""
        if self._params is None:
            found: dict[str | None, click.Parameter] = {}
            for each in self._declared:
                for new in each.options() if isinstance(each, _Asked | _OfParameter) else [each]:
                    found.setdefault(new.name, strict_number(new))
            self._params = [*found.values(), *help_all(len(found))]
        return self._params

    @params.setter
    def params(self, declared: list[Any]) -> None:
        self._declared, self._params = declared, None


command = functools.partial(click.command, cls=GroupedCommand)
"""`click.command` for callbacks with `takes`."""


def option_of(parameter: str, *names: str, **settings: Any) -> Callable[[Callback], Callback]:
    """Add an option whose default is that of a function's parameter; the rest is as of `click.option`.

    `parameter`: As ``"module:function.parameter"``. If its default is a member of an enumeration, its values may be
    chosen.
    """

    def decorate(callback: Callback) -> Callback:
        callback.__dict__.setdefault("__click_params__", []).append(_OfParameter(parameter, names, settings))
        return callback

    return decorate


def option_names(group: Group) -> Sequence[str]:
    """Return the names of the click parameters that a group adds."""
    return _Asked(group).names


def group_of(group: Group, values: Mapping[str, Any]) -> Any:
    """Return a group from the values of a command's parameters, by name, as click parsed them."""
    return _Asked(group).build(values)


@dataclass(frozen=True)
class _Asked:
    """A group as a command asks for it."""

    group: Group
    without: tuple[str, ...] = ()
    only: tuple[str, ...] = ()

    @functools.cached_property
    def kind(self) -> type[Any]:
        if not isinstance(self.group, str):
            return self.group
        module, _, name = self.group.partition(":")
        found: type[Any] = getattr(import_module(module), name)
        return found

    @functools.cached_property
    def names(self) -> list[str]:
        return [name for each in self._stated(self.kind) for name in each.names]

    def options(self) -> list[click.Parameter]:
        """Return the options for click; the default of each is that of its field now."""
        return [option for each in self._stated(self.kind) for option in each.to_click()]

    def build(self, values: Mapping[str, Any]) -> Any:
        """Return the group with what was typed; what was not has the default of its field."""
        return self._build(self.kind, values)

    def _build(self, group: type[Any], values: Mapping[str, Any]) -> Any:
        given = {each.field.name: each.value(values) for each in self._own(group) if each.is_given(values)}
        inner = {name: asked._build(kind, values) for name, (asked, kind) in self._inner(group).items()}
        return group(**given, **{name: value for name, value in inner.items() if name not in self.without})

    def _own(self, group: type[Any]) -> Iterator[_Stated]:
        for each in fields(group):
            if OPTION in each.metadata and each.name not in self.without and (not self.only or each.name in self.only):
                yield _Stated(each, _annotation(group, each))

    def _stated(self, group: type[Any]) -> Iterator[_Stated]:
        """Yield all options, those of inner groups at their place."""
        own, inner = {each.field.name: each for each in self._own(group)}, self._inner(group)
        for each in fields(group):
            if each.name in own:
                yield own[each.name]
            elif each.name in inner and each.name not in self.without:
                asked, kind = inner[each.name]
                yield from asked._stated(kind)

    def _inner(self, group: type[Any]) -> dict[str, tuple[_Asked, type[Any]]]:
        """Return the inner groups of a group, each with what asks for it."""
        only = {each.name: each.metadata.get(ONLY) or self.only for each in fields(group)}
        return {name: (replace(self, only=only[name]), kind) for name, kind in _inner_groups(group).items()}


@dataclass(frozen=True)
class _OfParameter:
    """An option whose default a function's signature says."""

    parameter: str
    flags: tuple[str, ...]
    settings: Mapping[str, Any]

    def options(self) -> list[click.Parameter]:
        module, _, rest = self.parameter.partition(":")
        function, _, name = rest.partition(".")
        default = inspect.signature(getattr(import_module(module), function)).parameters[name].default
        settings = {"show_default": True, **self.settings}
        if isinstance(default, Enum):
            settings.setdefault("type", click.Choice([each.value for each in type(default)]))
            default = default.value
        return [click.Option(self.flags, default=default, **{"type": type(default), **settings})]


@dataclass(frozen=True)
class _Stated:
    """A field that is an option, and how it is typed."""

    field: Field[Any]
    kind: Any

    @property
    def option(self) -> Option:
        """What the field says."""
        found: Option = self.field.metadata[OPTION]
        return found

    @property
    def flags(self) -> tuple[str, ...]:
        """As they are typed."""
        own = self.field.name.replace("_", "-")
        return self.option.flags or (f"--{own.removesuffix('-rad')}-deg" if self.is_angle else f"--{own}",)

    @property
    def is_angle(self) -> bool:
        """Whether the field is in radians, and the option in degrees."""
        return self.field.name.endswith("_rad") and self.option.read is None

    @property
    def names(self) -> list[str]:
        """The names of its parameters."""
        return [_name_of((flag,)) for flag in self.option.switches] if self.option.switches else [_name_of(self.flags)]

    @property
    def default(self) -> Any:
        """The default of the field now; None if it has none."""
        if self.field.default_factory is not MISSING:
            return self.field.default_factory()
        return None if self.field.default is MISSING else self.field.default

    def is_given(self, values: Mapping[str, Any]) -> bool:
        """Whether a value is there: typed, or the default of the option."""
        if self.option.switches or self.field.default is self.field.default_factory is MISSING:
            return True
        if self.option.many and not self.default:
            return True
        return values.get(self.names[0]) not in (None, ())

    def value(self, values: Mapping[str, Any]) -> Any:
        """Return the field's value of what was typed. Raises `InputError` when it cannot be read."""
        if self.option.switches:
            return self._switched(values)
        typed = values.get(self.names[0])
        if self.option.many:
            return tuple(map(self._read, typed or ())) if self.option.read is None else self._read(typed or ())
        return None if typed is None else self._read(typed)

    def _read(self, typed: Any) -> Any:
        read = self.option.read
        if isinstance(read, str):
            module, _, name = read.partition(":")
            read = getattr(import_module(module), name)
        if callable(read):
            return read(typed)
        if self.is_angle:
            return math.radians(typed)
        if isinstance(self.kind, type) and issubclass(self.kind, Enum):
            return self.kind(typed)
        return self._numbers(typed) if get_origin(self.kind) is tuple and isinstance(typed, str) else typed

    def _numbers(self, typed: str) -> tuple[float, ...]:
        from wpcal.core.errors import InputError
        from wpcal.core.numbers import parse_numbers

        wanted = len(get_args(self.kind))
        unit = " in degrees" if self.flags[0].endswith("-deg") else " in mm" if self.flags[0].endswith("-mm") else ""
        try:
            numbers = tuple(parse_numbers(typed))
        except ValueError:
            numbers = ()
        if len(numbers) != wanted:
            raise InputError(f"{self.flags[0]}: expected {self.option.metavar}{unit}, got {typed!r}") from None
        return numbers

    def _switched(self, values: Mapping[str, Any]) -> Any:
        from wpcal.core.errors import InputError

        switches = self.option.switches or {}
        given = [flag for flag in switches if values.get(_name_of((flag,)))]
        if len(given) > 1:
            raise InputError(f"{' and '.join(given)} exclude each other")
        return switches[given[0]][0] if given else self.default

    def to_click(self) -> list[click.Option]:
        """Return the option for click; for a choice by switches one flag each."""
        said = self.option
        if said.switches:
            return [click.Option([flag], is_flag=True, help=text) for flag, (_, text) in said.switches.items()]
        names = [*self.flags, _name_of(self.flags)]
        if self.kind is bool:
            return [click.Option(names, is_flag=True, help=said.help)]
        default = None if said.many else self._shown_default()
        settings: dict[str, Any] = {"metavar": said.metavar, "multiple": said.many, "help": said.help}
        if said.if_alone is not None and callable(said.read):  # it may have taken the argument that would be missed
            settings["callback"] = lambda _context, _parameter, typed: self.value({self.names[0]: typed})
        if default is not None and said.is_shown:
            settings |= {"default": default, "show_default": True}
        if said.if_alone is not None:
            settings |= {"is_flag": False, "flag_value": said.if_alone}
        return [click.Option(names, type=self._type(), **settings)]

    def _shown_default(self) -> Any:
        default = self.default
        if default is None:
            return None
        if self.option.show is not None:
            return self.option.show(default)
        if self.is_angle:
            return round(math.degrees(default), DEGREES)
        if isinstance(default, Enum):
            return default.value
        return ",".join(f"{each:g}" for each in default) or None if isinstance(default, tuple) else default

    def _type(self) -> Any:
        said, kind = self.option, self.option.type or self.kind
        members = said.choices or (tuple(kind) if isinstance(kind, type) and issubclass(kind, Enum) else ())
        if members:
            return click.Choice([each.value if isinstance(each, Enum) else each for each in members])
        if kind is Path:
            return click.Path(path_type=Path)
        if kind not in {int, float}:
            return str
        least = said.least if said.above is None else said.above
        if least is None and said.most is None:
            return kind
        ranges: Any = click.IntRange if kind is int else click.FloatRange
        return ranges(min=least, max=said.most, min_open=said.above is not None)


def _name_of(flags: Sequence[str]) -> str:
    return next(flag for flag in flags if flag.startswith("--")).removeprefix("--").replace("-", "_")


def _annotation(group: type[Any], each: Field[Any]) -> Any:
    """Return the type of a field without None; None for one that only type checkers know."""
    home = next(kind for kind in group.__mro__ if each.name in inspect.get_annotations(kind))
    try:
        kind = each.type if not isinstance(each.type, str) else eval(each.type, vars(sys.modules[home.__module__]))
    except NameError:
        return None
    if get_origin(kind) in {Union, types.UnionType}:
        kind = next(one for one in get_args(kind) if one is not type(None))
    is_many = OPTION in each.metadata and each.metadata[OPTION].many
    return get_args(kind)[0] if get_origin(kind) is tuple and is_many else kind


def _inner_groups(group: type[Any]) -> dict[str, type[Any]]:
    """Return the fields that are groups: dataclasses with an option in them."""
    kinds = {
        each.name: _Asked(each.metadata[GROUP]).kind if GROUP in each.metadata else _annotation(group, each)
        for each in fields(group)
        if OPTION not in each.metadata
    }
    return {
        name: kind
        for name, kind in kinds.items()
        if is_dataclass(kind) and isinstance(kind, type)
        if any(OPTION in each.metadata for each in fields(kind)) or _inner_groups(kind)
    }
