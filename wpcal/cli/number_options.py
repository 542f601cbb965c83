"""Numbers in options follow the rule of all input: digits 0 to 9, finite, at most 1e9 (`wpcal.core.numbers`).

Python alone would take ``nan``, ``81_2`` and digits of other scripts for numbers, and so does click.
"""

from __future__ import annotations

import copy
from typing import Any

import click

MOST_WHOLE = 2**64  #: Seeds have up to 64 bits.


def with_strict_numbers(command: click.Command) -> click.Command:
    """Let every option and argument of a command that takes a number take nothing else."""
    for parameter in command.params:
        strict_number(parameter)
    return command


def strict_number(parameter: click.Parameter) -> click.Parameter:
    """Let a parameter that takes a number take nothing else."""
    kind = parameter.type
    is_number = isinstance(kind, click.types.FloatParamType | click.types.IntParamType)
    if is_number and not isinstance(kind, _StrictNumber):
        parameter.type = copy.copy(kind)
        parameter.type.__class__ = type(type(kind).__name__, (_StrictNumber, type(kind)), {})
    return parameter


class _StrictNumber(click.ParamType):  # type: ignore[type-arg]  # click 8.2 has no parameters of types
    """Comes before click's own type of a number in the order of methods."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Refuse a text that is no number of this kind; otherwise do what click's type does."""
        if isinstance(value, str):
            from wpcal.core.errors import InputError
            from wpcal.core.numbers import parse_number, parse_whole_number

            try:
                if isinstance(self, click.types.IntParamType):
                    parse_whole_number(value, most=MOST_WHOLE)
                else:
                    parse_number(value)
            except InputError as error:
                self.fail(str(error), param, ctx)
        return super().convert(value, param, ctx)
