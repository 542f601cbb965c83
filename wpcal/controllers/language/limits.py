"""Limits of the templates of a user: how many lines one may run, and how much it may write and hold.

A template is a small program. Loops within loops, a text times a large number or a macro that calls itself would
otherwise hold the command for ever or take all memory.
"""

from __future__ import annotations

import math
import re
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from functools import wraps
from types import FrameType
from typing import Any

from jinja2 import nodes
from jinja2.compiler import CodeGenerator
from jinja2.exceptions import SecurityError
from jinja2.sandbox import ImmutableSandboxedEnvironment

MOST_STEPS = 100_000  #: Lines that a template runs for one block: a header of 200 lines needs less than 1000.
MOST_CHARACTERS = 10_000_000  #: That a block, or a text or list within it, has.
MOST_PRODUCT = 20_000_000
"""Of the lengths and numbers that a function gets: what it makes is not larger, whatever it repeats."""
_WIDE = re.compile(r"\d{4}|%[^a-zA-Z]{0,9}\*|\{[^{}]{0,99}\{")


class _Generator(CodeGenerator):
    """Joins with ``~`` through the environment, which counts."""

    def visit_Concat(self, node: nodes.Concat, frame: Any) -> None:
        self.write("environment.concat((")
        for each in node.nodes:
            self.visit(each, frame)
            self.write(", ")
        self.write("))")


def _joined(parts: Iterable[Any]) -> str:
    found, length = list[str](), 0
    for part in parts:
        found.append(str(part))
        length += len(found[-1])
        if length > MOST_CHARACTERS:
            raise SecurityError(f"writes more than {MOST_CHARACTERS} characters")
    return "".join(found)


class LimitedEnvironment(ImmutableSandboxedEnvironment):
    """A sandbox in which no operation makes more than `MOST_PRODUCT` before it is refused."""

    code_generator_class = _Generator
    concat = staticmethod(_joined)
    intercepted_binops = frozenset(["*", "**", "+", "%"])

    def __init__(self, **options: Any) -> None:
        super().__init__(**options)
        filled = self.filters["format"]
        self.filters = {name: _limited(what) for name, what in self.filters.items()}
        self.filters["format"] = lambda text, *args, **kwargs: filled(_narrow(text), *args, **kwargs)

    def call_binop(self, context: Any, operator: str, left: Any, right: Any) -> Any:
        """Refuse what would be too large before it is computed."""
        if operator == "%" and isinstance(left, str):
            _narrow(left)
        is_number = isinstance(left, (int, float)) and isinstance(right, (int, float))
        if operator == "**" or (operator == "*" and not is_number):
            _refuse_large((left, right))
        return _refuse_long(super().call_binop(context, operator, left, right))

    def wrap_str_format(self, value: Any) -> Callable[..., str] | None:
        """Refuse wide fields in the format methods of texts."""
        formatted = super().wrap_str_format(value)
        if formatted is not None:
            _narrow(value.__self__)
        return formatted

    def call(self, context: Any, called: Any, /, *args: Any, **kwargs: Any) -> Any:
        """Call a function or a method of a text within the limits."""
        owner = getattr(called, "__self__", None)
        if isinstance(owner, str):
            _refuse_large((owner, *args, *kwargs.values()))
        return _refuse_long(super().call(context, called, *args, **kwargs))


@contextmanager
def limited_steps() -> Iterator[None]:
    """Count the lines that templates run meanwhile; `SecurityError` after `MOST_STEPS`.

    A debugger sees its own frames again afterwards.
    """
    steps = 0

    def count(frame: FrameType, event: str, _: Any) -> Any:
        nonlocal steps
        if "environment" not in frame.f_globals:
            return None
        steps += event == "line"
        if steps > MOST_STEPS:
            raise SecurityError(f"runs more than {MOST_STEPS} lines: a loop is too long")
        return count

    before = sys.gettrace()
    sys.settrace(count)
    try:
        yield
    finally:
        sys.settrace(before)


def _limited(made_by: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a filter, with the marks by which Jinja passes it a context."""

    @wraps(made_by)
    def within(*args: Any, **kwargs: Any) -> Any:
        _refuse_large((*args, *kwargs.values()))
        return _refuse_long(made_by(*args, **kwargs))

    return within


def _narrow(text: Any) -> Any:
    """Return the pattern of a format; `SecurityError` when a field of it is wide, or a value gives its width."""
    if _WIDE.search(str(text)):
        raise SecurityError("a field of more than 999 characters, or one whose width is a value")
    return text


def _refuse_large(values: Iterable[Any]) -> None:
    sizes = [len(each) if isinstance(each, (str, list, tuple, dict, range)) else each for each in values]
    product = math.prod(max(abs(each), 1) for each in sizes if isinstance(each, (int, float)))
    if product > MOST_PRODUCT:
        raise SecurityError(f"makes more than {MOST_CHARACTERS} characters")


def _refuse_long(value: Any) -> Any:
    if isinstance(value, (str, list, tuple)) and len(value) > MOST_CHARACTERS:
        raise SecurityError(f"makes more than {MOST_CHARACTERS} characters")
    return value
