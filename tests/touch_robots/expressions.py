"""Expressions of robot languages: text to tokens, and tokens to a value by precedence climbing.

A language gives its words for operators, and an environment that knows names, calls, parts and indices.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, Protocol

from tests.touch_robots.robot import ProgramError


class Environment(Protocol):
    """What a language knows about names."""

    def name(self, name: str) -> Any: ...
    def call(self, name: str, arguments: list[Any]) -> Any: ...
    def part(self, value: Any, name: str) -> Any: ...
    def item(self, value: Any, indices: list[Any]) -> Any: ...


@dataclass(frozen=True)
class Grammar:
    """Tokens and operators of a language; `levels` bind the less the earlier they come."""

    token: re.Pattern[str]
    levels: tuple[dict[str, Callable[[Any, Any], Any]], ...]
    prefixes: dict[str, Callable[[Any], Any]]
    literals: dict[str, Any] = field(default_factory=dict)
    aggregate: tuple[str, str] | None = None
    """Brackets of a list, as in RAPID."""
    index: tuple[str, str] | None = None
    quote: str = '"'
    is_upper: bool = True
    """Upper and lower case are the same."""


def as_number(text: str) -> float | int:
    return int(text) if re.fullmatch(r"\d+", text) else float(text)


def tokens_of(text: str, grammar: Grammar) -> list[str]:
    found, at = [], 0
    while at < len(text):
        if text[at].isspace():
            at += 1
            continue
        match = grammar.token.match(text, at)
        if match is None:
            raise ProgramError(f"cannot be read: {text[at:]!r} in {text!r}")
        found.append(match[0])
        at = match.end()
    return found


class Parser:
    """Reads one expression from tokens, and evaluates it at once."""

    def __init__(self, tokens: list[str], grammar: Grammar, environment: Environment) -> None:
        self.tokens, self.grammar, self.environment, self.at = tokens, grammar, environment, 0

    def peek(self) -> str:
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def word(self) -> str:
        return self.peek().upper() if self.grammar.is_upper else self.peek()

    def take(self, expected: str | None = None) -> str:
        token = self.peek()
        if token == "" or (expected is not None and token.upper() != expected.upper()):
            raise ProgramError(f"expected {expected or 'more'} at {token!r} in {' '.join(self.tokens)!r}")
        self.at += 1
        return token

    def end(self) -> None:
        if self.peek():
            raise ProgramError(f"{self.peek()!r} is too much in {' '.join(self.tokens)!r}")

    def value(self, level: int = 0) -> Any:
        if level == len(self.grammar.levels):
            return self.prefixed()
        left = self.value(level + 1)
        while self.word() in self.grammar.levels[level]:
            function = self.grammar.levels[level][self.word()]
            self.at += 1
            left = function(left, self.value(level + 1))
        return left

    def prefixed(self) -> Any:
        if self.word() in self.grammar.prefixes:
            function = self.grammar.prefixes[self.word()]
            self.at += 1
            return function(self.prefixed())
        return self.with_parts(self.primary())

    def values(self, closing: str) -> list[Any]:
        found: list[Any] = []
        while self.peek() != closing:
            if found:
                self.take(",")
            found.append(self.value())
        self.take(closing)
        return found

    def primary(self) -> Any:
        token = self.take()
        if token == "(":
            inside = self.value()
            self.take(")")
            return inside
        if self.grammar.aggregate and token == self.grammar.aggregate[0]:
            return self.values(self.grammar.aggregate[1])
        if token.startswith(self.grammar.quote):
            return token[1:-1]
        if token[0].isdigit() or (token[0] == "." and token[1:2].isdigit()):
            return as_number(token)
        word = token.upper() if self.grammar.is_upper else token
        if word in self.grammar.literals:
            return self.grammar.literals[word]
        if not re.match(r"[\w$#^]", token):
            raise ProgramError(f"{token!r} is no value in {' '.join(self.tokens)!r}")
        if self.peek() == "(":
            self.take("(")
            return self.environment.call(word, self.values(")"))
        return self.environment.name(word)

    def with_parts(self, value: Any) -> Any:
        while True:
            if self.peek() == ".":
                self.take(".")
                value = self.environment.part(value, self.take().lower())
            elif self.grammar.index and self.peek() == self.grammar.index[0]:
                self.take()
                value = self.environment.item(value, self.values(self.grammar.index[1]))
            else:
                return value


COMPARE: dict[str, Callable[[Any, Any], Any]] = {
    "<>": operator.ne,
    ">=": operator.ge,
    "<=": operator.le,
    ">": operator.gt,
    "<": operator.lt,
}
SUM: dict[str, Callable[[Any, Any], Any]] = {"+": operator.add, "-": operator.sub}
PRODUCT: dict[str, Callable[[Any, Any], Any]] = {"*": operator.mul, "/": operator.truediv}
OR: dict[str, Callable[[Any, Any], Any]] = {"OR": lambda a, b: a or b}
AND: dict[str, Callable[[Any, Any], Any]] = {"AND": lambda a, b: a and b}
SIGNS: dict[str, Callable[[Any], Any]] = {"-": operator.neg, "+": operator.pos}
