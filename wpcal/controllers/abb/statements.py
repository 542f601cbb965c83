"""RAPID modules as text: declarations and routines."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from wpcal.controllers.abb.values import SYNTAX
from wpcal.controllers.language.grammar import mark_of
from wpcal.controllers.run.blocks import Node, Row, Steps, tree
from wpcal.controllers.run.expressions import outside, tokens_of, without_comment
from wpcal.controllers.run.machine import ProgramError

STORAGE = {"CONST", "VAR", "PERS"}
ENDS = "ENDIF ENDFOR ENDWHILE ENDTEST"
MOST_NAME = 32  #: Characters of a name.
OPERATORS = {"AND", "OR", "XOR", "NOT", "DIV", "MOD"}
MARK = "!"  #: Begins the token of a comment that marks a seam.
SKIPPED = {"FUNC": "ENDFUNC", "TRAP": "ENDTRAP", "RECORD": "ENDRECORD"}
"""Declarations that are not executed: a call of one is unknown."""


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


Tokens = tuple[list[str], list[int]]  #: Of a statement, and their lines.


def statements_of(text: str) -> Iterator[Tokens]:
    """Yield what is between semicolons, or before data, whatever it says and wherever it is."""
    tokens, lines = list[str](), list[int]()
    for number, bare, _ in _rows(text):
        for token in tokens_of(bare, SYNTAX, is_strict=False):
            if token == ";" or token.upper() in STORAGE:
                yield tokens, lines
                tokens, lines = [], []
            if token != ";":
                tokens.append(token)
                lines.append(number)
    yield tokens, lines


def declared(tokens: Sequence[str], lines: Sequence[int]) -> Declaration | None:
    """Return what a statement declares; None if it is not ``CONST type name{n} := value``."""
    equals = tokens.index(":=") if ":=" in tokens else len(tokens)
    head = tokens[:equals]
    if len(head) < 3 or head[0].upper() not in STORAGE or (head[3:] and (head[3], head[-1]) != ("{", "}")):
        return None
    storage, kind, name, *size = head
    return Declaration(lines[0], storage.upper(), kind.lower(), name, size, [*tokens[equals + 1 :]])


def declarations(statements: Iterable[Tokens], *kinds: str) -> Iterator[Declaration]:
    """Yield the data of these types that get a value."""
    for each in (declared(*statement) for statement in statements):
        if each is not None and each.kind in kinds and each.tokens:
            yield each


class ModuleReader:
    """Reads the modules of a file: `texts`, `declarations` and `routines`."""

    def __init__(self, text: str, file: str) -> None:
        self.file, self.text, self.at = file, text, 0
        self.names: list[str] = []
        self.declarations: list[Declaration] = []
        self.routines: dict[str, Procedure] = {}
        self.tokens: list[str] = []
        self.lines: list[int] = []
        for number, bare, comment in _rows(text):
            try:
                found = tokens_of(bare, SYNTAX)
            except ProgramError as error:
                raise error.at(file, number) from None
            if not found and mark_of(comment) is not None:
                found = [f"{MARK}{comment}"]
            self.tokens += found
            self.lines += [number] * len(found)
        while self.peek():
            self._module()

    # -- tokens ----------------------------------------------------------------------------------------------------

    @property
    def line(self) -> int:
        """The line of the next token."""
        return self.lines[min(self.at, len(self.lines) - 1)] if self.lines else 1

    def fault(self, what: str) -> ProgramError:
        """Return an error at the next token."""
        return ProgramError(what, path=self.file, line=self.line)

    def peek(self, ahead: int = 0) -> str:
        """Return a token in capitals; empty at the end."""
        return self.tokens[self.at + ahead].upper() if self.at + ahead < len(self.tokens) else ""

    def take(self, expected: str | None = None) -> str:
        """Return the next token and go on."""
        token = self.tokens[self.at] if self.at < len(self.tokens) else ""
        if not token or (expected is not None and token.upper() != expected):
            near = " ".join(self.tokens[max(0, self.at - 5) : self.at + 5])
            raise self.fault(f"expected {expected or 'more'} at {near[:80]!r}")
        self.at += 1
        return token

    def until(self, *ends: str) -> list[str]:
        """Take the tokens before one of these, outside brackets."""
        begin, self.at = self.at, outside(self.tokens, ends, self.at)
        if self.at == len(self.tokens):
            self.take()  # refused: there is no more
        return self.tokens[begin : self.at]

    # -- declarations ----------------------------------------------------------------------------------------------

    def _module(self) -> None:
        if self.peek().startswith(MARK):
            self.take()
            return
        self.take("MODULE")
        self.names.append(self.take().upper())
        if self.peek() == "(":
            self.take()
            self.until(")")
            self.take()
        while self.peek() != "ENDMODULE":
            self._declared()
        self.take("ENDMODULE")

    def _declared(self) -> None:
        """Take what a module declares: a routine, data, or what is not executed."""
        is_local = False
        while self.peek() in {"LOCAL", "TASK"}:
            is_local = self.take().upper() == "LOCAL" or is_local
        word = self.peek()
        if word == "PROC":
            self._routine()
        elif word in STORAGE:
            self.declarations.append(self._declaration()._replace(is_local=is_local))
        elif word in SKIPPED:
            while self.take().upper() != SKIPPED[word]:
                pass
        elif word.startswith(MARK):
            self.take()
        else:
            raise self.fault(f"{word!r} is no declaration")

    def _declaration(self) -> Declaration:
        begin, lines = self.at, self.lines
        while self.take() != ";":
            pass
        tokens = self.tokens[begin : self.at - 1]
        found = declared(tokens, lines[begin : self.at])
        if found is None:
            what = f"{' '.join(tokens)[:40]!r} is not a declaration"
        elif len(found.name) > MOST_NAME:
            what = f"{found.name} has more than {MOST_NAME} characters"
        elif not found.tokens and found.storage != "VAR":
            what = f"{found.storage} {found.name} has no value"
        else:
            return found
        raise ProgramError(what, path=self.file, line=lines[begin])

    def _routine(self) -> None:
        line = self.line
        self.take("PROC")
        name, kinds, parameters = self.take(), list[tuple[str, str]](), list[str]()
        self.take("(")
        while self.peek() != ")":
            if self.peek() in {",", "\\"}:
                self.take()
            mode = self.take().upper() if self.peek() in {"VAR", "PERS", "INOUT"} else "IN"
            kinds.append((mode, self.take().lower()))
            parameters.append(self.take().upper())
        self.take(")")
        body, handler = self._body("ERROR", "UNDO", "BACKWARD", "ENDPROC"), None
        if self.peek() == "ERROR":
            self.take()
            handler = self._body("UNDO", "BACKWARD", "ENDPROC")
        while self.peek() in {"UNDO", "BACKWARD"}:
            self.take()
            self._body("UNDO", "BACKWARD", "ENDPROC")
        self.take("ENDPROC")
        if name.upper() in self.routines:
            raise ProgramError(f"{name} is declared twice", path=self.file)
        self.routines[name.upper()] = Procedure(self.file, parameters, body, line, tuple(kinds), handler)

    # -- statements ------------------------------------------------------------------------------------------------

    def _body(self, *ends: str) -> list[Node]:
        """Take statements up to one of the words, and leave this; blocks are trees of them."""
        rows = list[Row]()
        while self.peek() not in ends:
            rows += self._statement()
        return tree(rows, self.file, begins=r"(?:IF|FOR|WHILE|TEST)(?!\S)", turns="ELSEIF ELSE CASE DEFAULT", ends=ENDS)

    def _statement(self) -> list[Row]:
        """Take one statement, or what begins, divides or ends a block."""
        word, line, begin = self.peek(), self.line, self.at
        if word.startswith(MARK) or word in {"ELSE", *ENDS.split()}:
            return [(line, self.take())]
        if self.peek(1) == ":" and word != "DEFAULT":  # a label
            self.at += 2
            return []
        if word == "IF":
            self.take()
            condition = self._condition()
            if self.peek() != "THEN":  # the short form holds one instruction
                begin = self.at
                self.until(";")
                self.take()
                return [(line, text) for text in (f"IF {' '.join(condition)} THEN", self._text(begin, 1), "ENDIF")]
        last = {"IF": "THEN", "ELSEIF": "THEN", "FOR": "DO", "WHILE": "DO", "CASE": ":", "DEFAULT": ":"}.get(word, ";")
        if word == "TEST":
            self.until("CASE", "DEFAULT", "ENDTEST")
        else:
            self.until(last)
            self.take()
        return [(line, self._text(begin, int(last == ";" and word != "TEST")))]

    def _text(self, begin: int, but: int) -> str:
        """Return the tokens that were taken, without the last ones."""
        return " ".join(self.tokens[begin : self.at - but])

    def _condition(self) -> list[str]:
        """Take an expression: it ends at THEN, or where a word follows a value."""
        begin, depth, was_value = self.at, 0, False
        while depth or self.peek() != "THEN":
            token = self.peek()
            is_word = re.match(r'[\w"]', token) is not None and token not in OPERATORS
            if depth == 0 and was_value and is_word:
                break
            depth += (token in {"(", "[", "{"}) - (token in {")", "]", "}"})
            was_value = is_word or token in {")", "]", "}"}
            self.take()
        return self.tokens[begin : self.at]


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
