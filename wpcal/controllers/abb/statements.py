"""RAPID modules as text: their statements, and from them declarations and routines.

One parser for all who read RAPID: `statements_of` takes any text, and `ModuleReader` makes of its statements what a
controller would load.
"""

from __future__ import annotations

import re
from collections import deque
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import groupby
from typing import Any, NamedTuple

from wpcal.controllers.abb.values import SYNTAX
from wpcal.controllers.language.grammar import mark_of
from wpcal.controllers.run.blocks import Node, Row, Steps, tree
from wpcal.controllers.run.expressions import outside, tokens_of, without_comment
from wpcal.controllers.run.machine import ProgramError

STORAGE = {"CONST", "VAR", "PERS"}
SCOPES = {"LOCAL", "TASK"}  #: Before a declaration.
ENDS = "ENDIF ENDFOR ENDWHILE ENDTEST"
HANDLERS = {"ERROR", "UNDO", "BACKWARD"}  #: What begins the parts of a routine that errors and steps back run.
SKIPPED = {"FUNC": "ENDFUNC", "TRAP": "ENDTRAP", "RECORD": "ENDRECORD"}
"""Declarations that are not executed: a call of one is unknown."""
ALONE = {"ELSE", *ENDS.split(), *HANDLERS, *SKIPPED.values(), "ENDPROC", "ENDMODULE"}  #: Statements of one word.
NAMED = {"MODULE", "TRAP", "RECORD"}  #: What begins a statement of two words: the second is a name.
LAST = {"IF": "THEN", "ELSEIF": "THEN", "FOR": "DO", "WHILE": "DO", "CASE": ":", "PROC": ")", "FUNC": ")", "(": ")"}
"""The last token of a statement that begins so; the short form of IF has none."""
CASES = {"CASE", "DEFAULT", "ENDTEST"}  #: What ends the head of a TEST.
MOST_NAME = 32  #: Characters of a name.
OPERATORS = {"AND", "OR", "XOR", "NOT", "DIV", "MOD"}
MARK = "!"  #: Begins the token of a comment that marks a seam.


@dataclass
class Data:
    """One data object."""

    storage: str
    kind: str
    value: Any
    is_array: bool = False


class Declaration(NamedTuple):
    """A data object as it is declared."""

    line: int
    storage: str
    kind: str
    name: str
    size: list[str]  #: The tokens of the size of an array, in braces.
    tokens: list[str]  #: Of its value.
    is_local: bool = False  #: Whether only its module knows it.


@dataclass(frozen=True, slots=True)
class Procedure(Steps):
    """A procedure: its parameters are names, in capitals."""

    kinds: tuple[tuple[str, str], ...] = ()  #: How each parameter is given (IN, VAR, PERS, INOUT), and its type.
    handler: Sequence[Node] | None = None


class Statement(NamedTuple):
    """What is between semicolons, or the head or the end of a block or a routine; without the semicolon."""

    line: int  #: Of its first token.
    tokens: list[str]

    @property
    def word(self) -> str:
        """Its first token that is not a scope, in capitals; empty without one."""
        return _head(self.tokens)[0]


def statements_of(text: str, file: str = "", *, is_strict: bool = False) -> Iterator[Statement]:
    """Yield the statements of a text, whatever it says; data begin one wherever they are.

    `is_strict`: As a controller takes the text, and with comments that mark seams. `ProgramError` at what is no token.
    """
    line, tokens = 0, list[str]()
    for number, token in _numbered(text, file, is_strict=is_strict):
        if tokens and (token == ";" or _begins(token.upper(), _head(tokens)[0], is_strict=is_strict)):
            yield Statement(line, tokens)
            tokens = []
        line = line if tokens else number
        tokens += [] if token == ";" else [token]
        if _ends(token.upper(), *_head(tokens)):
            yield Statement(line, tokens)
            tokens = []
    if tokens:
        yield Statement(line, tokens)


def _numbered(text: str, file: str, *, is_strict: bool) -> Iterator[tuple[int, str]]:
    """Yield lines and tokens; a comment that marks a seam is one token."""
    for number, bare, comment in _rows(text):
        try:
            found = tokens_of(bare, SYNTAX, is_strict=is_strict)
        except ProgramError as error:
            raise error.at(file, number) from None
        if is_strict and not found and mark_of(comment) is not None:
            found = [f"{MARK}{comment}"]
        yield from ((number, token) for token in found)


def _head(tokens: Sequence[str]) -> tuple[str, int]:
    """Return the first token that is not a scope, in capitals, and how many there are from there on."""
    scopes = sum(token.upper() in SCOPES for token in tokens[:2])
    return "".join(tokens[scopes : scopes + 1]).upper(), len(tokens) - scopes


def _begins(word: str, head: str, *, is_strict: bool) -> bool:
    """Tell whether a token begins a statement although nothing ended the one with this first token."""
    is_data = word in STORAGE and not is_strict and head not in {"", "PROC", "FUNC"}
    return is_data or (head == "TEST" and word in CASES)


def _ends(word: str, head: str, count: int) -> bool:
    """Tell whether a token ends its statement, of which it is the one of this number, without scopes."""
    if count == 1:
        return head in ALONE or head.startswith(MARK)
    return word == LAST.get(head) or (count == 2 and (word == ":" or head in NAMED))


def declared(statement: Statement) -> Declaration | None:
    """Return what a statement declares; None if it is not ``CONST type name{n} := value``."""
    tokens = statement.tokens
    begin = len(tokens) - _head(tokens)[1]
    equals = tokens.index(":=") if ":=" in tokens else len(tokens)
    head = tokens[begin:equals]
    if len(head) < 3 or head[0].upper() not in STORAGE or (head[3:] and (head[3], head[-1]) != ("{", "}")):
        return None
    (storage, kind, name), size = head[:3], head[3:]
    is_local = "LOCAL" in map(str.upper, tokens[:begin])
    return Declaration(statement.line, storage.upper(), kind.lower(), name, size, tokens[equals + 1 :], is_local)


def declarations(statements: Iterable[Statement], *kinds: str) -> Iterator[Declaration]:
    """Yield the data of these types that get a value."""
    for each in map(declared, statements):
        if each is not None and each.kind in kinds and each.tokens:
            yield each


class ModuleReader:
    """Reads the modules of a file: `names`, `declarations` and `routines`."""

    def __init__(self, text: str, file: str) -> None:
        self.file, self.text = file, text
        self.left, self.last = deque(statements_of(text, file, is_strict=True)), Statement(1, [])
        self.names: list[str] = []
        self.declarations: list[Declaration] = []
        self.routines: dict[str, Procedure] = {}
        while self.left:
            self._module()

    def fault(self, what: str) -> ProgramError:
        """Return an error at the last statement."""
        return ProgramError(what, path=self.file, line=self.last.line)

    def peek(self) -> str:
        """Return the word of the next statement; empty at the end."""
        return self.left[0].word if self.left else ""

    def take(self, expected: str = "") -> Statement:
        """Return the next statement and go on."""
        if self.left:
            self.last = self.left.popleft()
            if not expected or self.last.word == expected:
                return self.last
        raise self.fault(f"expected {expected or 'more'} at {' '.join(self.last.tokens)[:80]!r}")

    def _module(self) -> None:
        if self.peek().startswith(MARK):
            self.take()
            return
        self.names.append(self.take("MODULE").tokens[-1].upper())
        if self.peek() == "(":  # its attributes
            self.take()
        while self.peek() != "ENDMODULE":
            self._declared()
        self.take()

    def _declared(self) -> None:
        """Take what a module declares: a routine, data, or what is not executed."""
        word = self.take().word
        if word == "PROC":
            self._routine(self.last)
        elif word in STORAGE:
            self.declarations.append(self._declaration(self.last))
        elif word in SKIPPED:
            while self.take().word != SKIPPED[word]:
                pass
        elif not word.startswith(MARK):
            raise self.fault(f"{word!r} is no declaration")

    def _declaration(self, statement: Statement) -> Declaration:
        found = declared(statement)
        if found is None:
            raise self.fault(f"{' '.join(statement.tokens)[:40]!r} is not a declaration")
        if len(found.name) > MOST_NAME:
            raise self.fault(f"{found.name} has more than {MOST_NAME} characters")
        if not found.tokens and found.storage != "VAR":
            raise self.fault(f"{found.storage} {found.name} has no value")
        return found

    def _routine(self, head: Statement) -> None:
        _, name, *inside = [token for token in head.tokens if token.upper() not in SCOPES] + [""]
        if inside[:1] != ["("]:
            raise self.fault(f"expected ( at {' '.join(head.tokens)[:80]!r}")
        kinds, parameters = list[tuple[str, str]](), list[str]()
        for is_between, each in groupby(inside[1:-2], {",", "\\"}.__contains__):
            if not is_between:
                *mode, kind, parameter = ["", *each]
                kinds.append((mode[1].upper() if mode[1:] else "IN", kind.lower()))
                parameters.append(parameter.upper())
        body, handler = self._body(), None
        while (word := self.take().word) != "ENDPROC":
            part = self._body()
            handler = part if word == "ERROR" else handler
        if name.upper() in self.routines:
            raise ProgramError(f"{name} is declared twice", path=self.file)
        self.routines[name.upper()] = Procedure(self.file, parameters, body, head.line, tuple(kinds), handler)

    def _body(self) -> list[Node]:
        """Take statements up to a handler or the end of the routine; blocks are trees of them."""
        rows = list[Row]()
        while self.peek() not in {"ENDPROC", *HANDLERS}:
            rows += self._rows(self.take())
        return tree(rows, self.file, begins=r"(?:IF|FOR|WHILE|TEST)(?!\S)", turns="ELSEIF ELSE CASE DEFAULT", ends=ENDS)

    def _rows(self, statement: Statement) -> list[Row]:
        """Return a statement as the text of lines."""
        line, tokens = statement
        if tokens[1:] == [":"] and statement.word != "DEFAULT":  # a label
            return []
        if statement.word != "IF" or tokens[-1].upper() == "THEN":
            return [(line, " ".join(tokens))]
        end = _end_of_condition(tokens)  # the short form holds one instruction
        if end == len(tokens):
            raise self.fault(f"expected more at {' '.join(tokens)[:80]!r}")
        return [(line, text) for text in (f"{' '.join(tokens[:end])} THEN", " ".join(tokens[end:]), "ENDIF")]


def _end_of_condition(tokens: Sequence[str]) -> int:
    """Return where the instruction of a short IF begins: where a word follows a value."""
    depth, was_value = 0, False
    for at, token in enumerate(map(str.upper, tokens[1:]), 1):
        is_word = re.match(r'[\w"]', token) is not None and token not in OPERATORS
        if depth == 0 and was_value and is_word:
            return at
        depth += (token in {"(", "[", "{"}) - (token in {")", "]", "}"})
        was_value = is_word or token in {")", "]", "}"}
    return len(tokens)


def instruction(tokens: Sequence[str]) -> tuple[list[list[str]], dict[str, list[str]]]:
    """Return the arguments of an instruction, and those with a backslash."""
    arguments, options, at = list[list[str]](), dict[str, list[str]](), 0

    while at < len(tokens):
        at += tokens[at] == ","
        if tokens[at : at + 1] == ["\\"]:
            option, at = "".join(tokens[at + 1 : at + 2]).upper(), at + 2
            end = outside(tokens, {",", "\\"}, at + 1) if tokens[at : at + 1] == [":="] else at
            options[option], at = list(tokens[at + 1 : end]), end
        else:
            end = outside(tokens, {",", "\\"}, at)
            arguments.append(list(tokens[at:end]))
            at = end
    return arguments, options


def _rows(text: str) -> Iterator[tuple[int, str, str]]:
    """Yield the number of each line, the line, and its comment; a header between ``%%%`` is empty."""
    text = re.sub(r"^\s*%%%.*?%%%", lambda match: "\n" * match[0].count("\n"), text, flags=re.DOTALL)
    for number, line in enumerate(text.splitlines(), 1):
        yield number, *without_comment(line, "!")
