"""RAPID modules as text: declarations and routines."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from wpcal.controllers.abb.values import SYNTAX
from wpcal.controllers.language.grammar import mark_of
from wpcal.controllers.run.expressions import tokens_of, without_comment
from wpcal.controllers.run.program import ProgramError

STORAGE = {"CONST", "VAR", "PERS"}
MOST_NAME = 32  #: Characters of a name.
MOST_BLOCKS = 30  #: In one another.
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
    is_array: bool
    tokens: list[str]
    is_local: bool = False  #: Whether only its module knows it.


class Statement(NamedTuple):
    """One instruction, or a block of them; `parts` are those of its kind."""

    kind: str
    line: int
    parts: tuple[Any, ...]


@dataclass
class Routine:
    """A procedure."""

    name: str
    file: str
    parameters: list[tuple[str, str, str]] = field(default_factory=list)
    """How it is given (IN, VAR, PERS, INOUT), type, name."""
    body: list[Statement] = field(default_factory=list)
    handler: list[Statement] | None = None
    declarations: list[Declaration] = field(default_factory=list)


class ModuleReader:
    """Reads the modules of a file: `texts`, `declarations` and `routines`."""

    def __init__(self, text: str, file: str) -> None:
        self.file, self.text, self.at, self.depth = file, text, 0, 0
        self.names: list[str] = []
        self.declarations: list[Declaration] = []
        self.routines: list[Routine] = []
        self.calls: dict[str, set[str]] = {}
        self.called = set[str]()  #: By the routine that is read.
        self.tokens: list[str] = []
        self.lines: list[int] = []
        for number, line in enumerate(re.sub(r"^\s*%%%.*?%%%", _blank_lines, text, flags=re.DOTALL).splitlines(), 1):
            bare, comment = without_comment(line, "!")
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
        begin, depth = self.at, 0
        while depth or self.peek() not in ends:
            depth += (self.peek() in {"(", "[", "{"}) - (self.peek() in {")", "]", "}"})
            self.take()
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
            is_local = False
            while self.peek() in {"LOCAL", "TASK"}:
                is_local = self.take().upper() == "LOCAL" or is_local
            word = self.peek()
            if word == "PROC":
                self.routines.append(self._routine())
            elif word in STORAGE:
                self.declarations.append(self._declaration()._replace(is_local=is_local))
            elif word in SKIPPED:
                while self.take().upper() != SKIPPED[word]:
                    pass
            elif word.startswith(MARK):
                self.take()
            else:
                raise self.fault(f"{word!r} is no declaration")
        self.take("ENDMODULE")

    def _declaration(self) -> Declaration:
        line, storage, kind, name = self.line, self.take().upper(), self.take().lower(), self.take()
        if len(name) > MOST_NAME:
            raise self.fault(f"{name} has more than {MOST_NAME} characters")
        is_array, tokens = self.peek() == "{", list[str]()
        if is_array:
            self.take()
            self.until("}")
            self.take()
        if self.peek() == ":=":
            self.take()
            tokens = self.until(";")
        elif storage != "VAR":
            raise self.fault(f"{storage} {name} has no value")
        self.take(";")
        return Declaration(line, storage, kind, name, is_array, tokens)

    def _routine(self) -> Routine:
        self.take("PROC")
        routine = Routine(self.take(), self.file)
        self.called = self.calls.setdefault(routine.name.upper(), set())
        self.take("(")
        while self.peek() != ")":
            if self.peek() in {",", "\\"}:
                self.take()
            mode = self.take().upper() if self.peek() in {"VAR", "PERS", "INOUT"} else "IN"
            routine.parameters.append((mode, self.take().lower(), self.take()))
        self.take(")")
        while self.peek() in STORAGE:
            routine.declarations.append(self._declaration())
        routine.body = self.statements("ERROR", "UNDO", "BACKWARD", "ENDPROC")
        if self.peek() == "ERROR":
            self.take()
            routine.handler = self.statements("UNDO", "BACKWARD", "ENDPROC")
        while self.peek() in {"UNDO", "BACKWARD"}:
            self.take()
            self.statements("UNDO", "BACKWARD", "ENDPROC")
        self.take("ENDPROC")
        return routine

    # -- statements ------------------------------------------------------------------------------------------------

    def statements(self, *ends: str) -> list[Statement]:
        """Take statements up to one of the words, and leave this."""
        self.depth += 1
        if self.depth > MOST_BLOCKS:
            raise self.fault(f"more than {MOST_BLOCKS} blocks in one another")
        found = []
        while self.peek() not in ends:
            found.append(self._statement())
        self.depth -= 1
        return found

    def _statement(self) -> Statement:
        word, line = self.peek(), self.line
        if word.startswith(MARK):
            return Statement("mark", line, (self.take()[1:],))
        kinds = {"IF": self._if, "FOR": self._for, "WHILE": self._while, "TEST": self._test}
        if word in kinds:
            self.take()
            return Statement(word.lower(), line, kinds[word]())
        if self.peek(1) == ":":
            return Statement("label", line, (self.take(), self.take()))
        return self._simple()

    def _for(self) -> tuple[Any, ...]:
        name = self.take()
        self.take("FROM")
        first = self.until("TO")
        self.take("TO")
        last = self.until("DO", "STEP")
        step = self.until("DO")[1:]
        self.take("DO")
        body = self.statements("ENDFOR")
        self.take("ENDFOR")
        return name, first, last, step, body

    def _while(self) -> tuple[Any, ...]:
        condition = self.until("DO")
        self.take("DO")
        body = self.statements("ENDWHILE")
        self.take("ENDWHILE")
        return condition, body

    def _if(self) -> tuple[Any, ...]:
        branches: list[tuple[list[str] | None, list[Statement]]] = []
        condition = self._condition()
        if self.peek() != "THEN":  # the short form holds one instruction
            return ([(condition, [self._simple()])],)
        self.take("THEN")
        while True:
            branches.append((condition, self.statements("ELSEIF", "ELSE", "ENDIF")))
            if self.peek() == "ELSEIF":
                self.take()
                condition = self.until("THEN")
                self.take("THEN")
                continue
            if self.peek() == "ELSE":
                self.take()
                branches.append((None, self.statements("ENDIF")))
            self.take("ENDIF")
            return (branches,)

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

    def _test(self) -> tuple[Any, ...]:
        value = self.until("CASE", "DEFAULT")
        cases: list[tuple[list[list[str]] | None, list[Statement]]] = []
        while self.peek() != "ENDTEST":
            if self.take().upper() == "DEFAULT":
                self.take(":")
                cases.append((None, self.statements("ENDTEST")))
                continue
            values = [self.until(",", ":")]
            while self.take() == ",":
                values.append(self.until(",", ":"))
            cases.append((values, self.statements("CASE", "DEFAULT", "ENDTEST")))
        self.take("ENDTEST")
        return value, cases

    def _simple(self) -> Statement:
        begin, line = self.at, self.line
        left = self.until(":=", ";", ",", "\\") if self.peek(1) in {".", "{", ":="} else []
        if left and self.peek() == ":=":
            self.take()
            right = self.until(";")
            self.take(";")
            return Statement("assign", line, (left, right))
        self.at = begin
        name = self.take()
        self.called.add(name.upper())
        arguments: list[list[str]] = []
        options: dict[str, list[str]] = {}
        while self.peek() != ";":
            if self.peek() == ",":
                self.take()
            if self.peek() == "\\":
                self.take()
                option = self.take().upper()
                options[option] = []
                if self.peek() == ":=":
                    self.take()
                    options[option] = self.until(",", "\\", ";")
            else:
                arguments.append(self.until(",", "\\", ";"))
        self.take(";")
        return Statement("call", line, (name, arguments, options))


def _blank_lines(match: re.Match[str]) -> str:
    return "\n" * match[0].count("\n")
