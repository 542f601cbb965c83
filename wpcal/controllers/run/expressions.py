"""Expressions of robot languages: text to tokens, and tokens to a value by precedence climbing.

A language gives its words for operators, and an environment that knows names, calls, parts and indices.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, Protocol

from wpcal.controllers.run.machine import ProgramError, real

LONGEST_NUMBER = 40
MOST_LEVELS = 60  #: Of brackets and signs in an expression.


class Environment(Protocol):
    """What a language knows about names."""

    def name(self, name: str) -> Any:
        """Return the value of a name."""

    def call(self, name: str, arguments: list[Any]) -> Any:
        """Return the value of a function."""

    def part(self, value: Any, name: str) -> Any:
        """Return a part of a record."""

    def item(self, value: Any, indices: list[Any]) -> Any:
        """Return an element of an array."""


@dataclass(frozen=True)
class Syntax:
    """Tokens and operators of a language; `levels` bind the less the earlier they come."""

    token: re.Pattern[str]
    levels: tuple[dict[str, Callable[[Any, Any], Any]], ...]
    prefixes: dict[str, Callable[[Any], Any]]
    literals: dict[str, Any] = field(default_factory=dict)
    aggregate: tuple[str, str] | None = None  #: Brackets of a list.
    index: tuple[str, str] | None = None
    quote: str = '"'
    is_upper: bool = True  #: Upper and lower case are the same.

    @cached_property
    def scanner(self) -> re.Pattern[str]:
        """Finds tokens, as a first group, and as a second one characters of which there is none."""
        return re.compile(rf"({self.token.pattern})|(\S)", self.token.flags)

    @cached_property
    def operators(self) -> dict[str, tuple[int, Callable[[Any, Any], Any]]]:
        """The level of each operator, and what it does."""
        return {word: (level, one) for level, words in enumerate(self.levels) for word, one in words.items()}


def as_number(text: str) -> float | int:
    """Return a number without a sign."""
    if len(text) > LONGEST_NUMBER:
        raise ProgramError(f"a number of {len(text)} digits")
    try:
        return int(text.encode("ascii")) if text.isdigit() else real(float(text.encode("ascii")))
    except ValueError:
        raise ProgramError(f"expected a finite number, got {text!r}") from None


def without_comment(line: str, mark: str, quote: str = '"') -> tuple[str, str]:
    """Return a line without its comment, and the comment; a mark in a text begins none."""
    begin = 0
    for number, part in enumerate(line.split(quote)):
        if number % 2 == 0 and mark in part:
            at = begin + part.index(mark)
            return line[:at], line[at + len(mark) :]
        begin += len(part) + len(quote)
    return line, ""


def tokens_of(text: str, grammar: Syntax, *, is_strict: bool = True) -> list[str]:
    """Return the tokens of a text. What is none: `ProgramError`, or without `is_strict` a token of one character."""
    found = grammar.scanner.findall(text)
    if is_strict and any(strange for _, strange in found):
        at = next(match.start() for match in grammar.scanner.finditer(text) if match[2])
        raise ProgramError(f"cannot be read: {text[at : at + 40]!r}")
    return [token or strange for token, strange in found]


def outside(tokens: Sequence[str], ends: Collection[str], at: int = 0) -> int:
    """Return where the first of `ends` is that is in no brackets, from `at` on; the number of tokens without one."""
    depth = 0
    while at < len(tokens) and (depth or tokens[at].upper() not in ends):
        depth += (tokens[at] in {"(", "[", "{"}) - (tokens[at] in {")", "]", "}"})
        at += 1
    return at


class Parser:
    """Reads one expression from tokens, and evaluates it at once; without an environment there are only literals."""

    def __init__(self, tokens: list[str], grammar: Syntax, environment: Environment | None = None) -> None:
        self.tokens, self.grammar, self.environment, self.at = tokens, grammar, environment, 0
        self.depth = 0

    @property
    def text(self) -> str:
        """Where a message is from."""
        return repr(" ".join(self.tokens[max(0, self.at - 10) : self.at + 10]))

    def peek(self) -> str:
        """Return the next token; empty at the end."""
        return self.tokens[self.at] if self.at < len(self.tokens) else ""

    def word(self) -> str:
        """Return the next token, in capitals where the language does not tell them apart."""
        return self.peek().upper() if self.grammar.is_upper else self.peek()

    def take(self, expected: str | None = None) -> str:
        """Return the next token and go on."""
        token = self.peek()
        if token == "" or (expected is not None and token.upper() != expected.upper()):
            where = f"at {token!r} in {self.text}" if token else f"where the text ends, behind {self.text}"
            raise ProgramError(f"expected {expected or 'more'} {where}")
        self.at += 1
        return token

    def whole(self) -> Any:
        """Return the value of all tokens."""
        value = self.value()
        if self.peek():
            raise ProgramError(f"{self.peek()!r} is too much in {self.text}")
        return value

    def value(self, level: int = 0) -> Any:
        """Return the value of an expression; `ProgramError` if there is none."""
        left = self.prefixed()
        while (found := self.grammar.operators.get(self.word())) is not None and found[0] >= level:
            self.at += 1
            left = self._applied(found[1], left, self.value(found[0] + 1))
        return left

    def prefixed(self) -> Any:
        """Return the value behind signs."""
        self.depth += 1
        if self.depth > MOST_LEVELS:
            raise ProgramError(f"more than {MOST_LEVELS} brackets or signs in one another")
        if self.word() in self.grammar.prefixes:
            function = self.grammar.prefixes[self.word()]
            self.at += 1
            found = self._applied(function, self.prefixed())
        else:
            found = self.with_parts(self.primary())
        self.depth -= 1
        return found

    def _applied(self, function: Callable[..., Any], *values: Any) -> Any:
        try:
            return function(*values)
        except (TypeError, ValueError, AttributeError, ArithmeticError) as error:
            why = str(error).rpartition("() ")[2]  # without the name of the function here
            raise ProgramError(f"{self.text} has no value: {why}") from None

    def values(self, closing: str) -> list[Any]:
        """Return values between commas, and take what closes them; those with names are one dict at the end."""
        found, named = list[Any](), dict[str, Any]()
        while self.peek() != closing:
            if found or named:
                self.take(",")
            if (name := self.named()) is None:
                found.append(self.value())
            else:
                named[name] = self.value()
        self.take(closing)
        return [*found, named] if named else found

    def named(self) -> str | None:
        """Take the name of an argument, in a language that has them; None where the next has none."""
        return None

    def primary(self) -> Any:
        """Return a literal, a list, a name, a call, or what is in brackets."""
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
        return self._named(token)

    def _named(self, token: str) -> Any:
        word = token.upper() if self.grammar.is_upper else token
        if word in self.grammar.literals:
            return self.grammar.literals[word]
        known = self.environment
        if known is None:
            raise ProgramError(f"expected a number, got {token!r}")
        if not re.match(r"[\w$#^]", token):
            raise ProgramError(f"{token!r} is no value in {self.text}")
        if self.peek() == "(":
            self.take("(")
            given = self.values(")")
            return self._applied(lambda: known.call(word, given))
        return known.name(word)

    def with_parts(self, value: Any) -> Any:
        """Return the part or element that is asked for."""
        while self.environment is not None:
            if self.peek() == ".":
                self.take(".")
                value = self.environment.part(value, self.take().lower())
            elif self.grammar.index and self.peek() == self.grammar.index[0]:
                self.take()
                value = self.environment.item(value, self.values(self.grammar.index[1]))
            else:
                break
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
LIKE_C: tuple[dict[str, Callable[[Any, Any], Any]], ...] = (
    {"or": OR["OR"], "xor": operator.xor},
    {"and": AND["AND"]},
    {"==": operator.eq, "!=": operator.ne, **{word: function for word, function in COMPARE.items() if word != "<>"}},
    SUM,
    {**PRODUCT, "%": operator.mod},
)
"""Operators of languages that tell upper from lower case."""
