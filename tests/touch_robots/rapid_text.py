"""RAPID modules as text: declarations and routines."""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from typing import Any

from tests.touch_robots.rapid_data import GRAMMAR, empty, typed
from wpcal.controllers.run.expressions import tokens_of
from wpcal.controllers.run.program import ProgramError

STORAGE = {"CONST", "VAR", "PERS"}
MOST_NAME = 32  #: Characters of a name.
OPERATORS = {"AND", "OR", "XOR", "NOT", "DIV", "MOD"}


@dataclass
class Data:
    """One data object."""

    storage: str
    kind: str
    value: Any
    module: str
    is_array: bool = False


@dataclass
class Routine:
    name: str
    parameters: list[tuple[str, str, str, bool]]
    """How it is given (IN, VAR, PERS, INOUT), type, name, optional."""
    body: list[Any] = field(default_factory=list)
    handler: list[Any] | None = None
    declarations: list[Any] = field(default_factory=list)
    module: str = ""
    returns: str | None = None


class ModuleReader:
    """Reads a module into data and routines."""

    def __init__(self, controller: Any, text: str) -> None:
        self.controller, self.text = controller, text
        bare = "\n".join(re.sub(r'^((?:[^"!]|"[^"]*")*)!.*', r"\1", line) for line in text.splitlines())
        self.tokens, self.at = tokens_of(re.sub(r"^\s*%%%.*?%%%", "", bare, flags=re.DOTALL), GRAMMAR), 0

    def peek(self, ahead: int = 0) -> str:
        return self.tokens[self.at + ahead].upper() if self.at + ahead < len(self.tokens) else ""

    def take(self, expected: str | None = None) -> str:
        token = self.tokens[self.at] if self.at < len(self.tokens) else ""
        if not token or (expected is not None and token.upper() != expected):
            raise ProgramError(f"expected {expected} at {' '.join(self.tokens[max(0, self.at - 5) : self.at + 5])!r}")
        self.at += 1
        return token

    def until(self, *ends: str) -> list[str]:
        """Take the tokens before one of these, outside brackets."""
        begin, depth = self.at, 0
        while depth or self.peek() not in ends:
            depth += (self.peek() in {"(", "[", "{"}) - (self.peek() in {")", "]", "}"})
            self.take()
        return self.tokens[begin : self.at]

    def read(self) -> None:
        self.take("MODULE")
        self.module = self.take()
        self.controller.texts[self.module.upper()] = self.text
        if self.peek() == "(":
            self.until("MODULE", "PROC", "LOCAL", "TASK", "ENDMODULE", *STORAGE)
        while self.peek() != "ENDMODULE":
            while self.peek() in {"LOCAL", "TASK"}:
                self.take()
            if self.peek() == "PROC":
                self._routine()
            elif self.peek() in STORAGE:
                storage, kind, name, size, tokens = self._declaration()
                if name.upper() in self.controller.data:
                    raise ProgramError(f"{name} is declared twice")
                if len(name) > MOST_NAME:
                    raise ProgramError(f"{name} has more than {MOST_NAME} characters")
                value = self.controller.value(tokens) if tokens else empty(kind)
                if storage in {"PERS", "CONST"} and not tokens:
                    raise ProgramError(f"{storage} {name} has no value")
                value = typed(kind, value) if size is None else [typed(kind, v) for v in value]
                self.controller.data[name.upper()] = Data(storage, kind, value, self.module, size is not None)
            else:
                raise ProgramError(f"{self.peek()} is no declaration")
        self.take("ENDMODULE")

    def _declaration(self) -> tuple[str, str, str, int | None, list[str]]:
        storage, kind, name = self.take().upper(), self.take().lower(), self.take()
        size, tokens = None, []
        if self.peek() == "{":
            self.take()
            size = int(self.take())
            self.take("}")
        if self.peek() == ":=":
            self.take()
            tokens = self.until(";")
        self.take(";")
        return storage, kind, name, size, tokens

    def _routine(self) -> None:
        self.take("PROC")
        routine = Routine(self.take(), [], module=self.module)
        self.take("(")
        while self.peek() != ")":
            if self.peek() == ",":
                self.take()
            mode = self.take().upper() if self.peek() in {"VAR", "PERS", "INOUT"} else "IN"
            routine.parameters.append((mode, self.take().lower(), self.take(), False))
        self.take(")")
        while self.peek() in STORAGE:
            routine.declarations.append(self._declaration())
        routine.body = self.statements("ERROR", "ENDPROC")
        if self.peek() == "ERROR":
            self.take()
            routine.handler = self.statements("ENDPROC")
        self.take("ENDPROC")
        if routine.name.upper() in self.controller.routines:
            raise ProgramError(f"{routine.name} is declared twice")
        self.controller.routines[routine.name.upper()] = routine

    def statements(self, *ends: str) -> list[Any]:
        found = []
        while self.peek() not in ends:
            found.append(self._statement())
        return found

    def _statement(self) -> Any:
        word = self.peek()
        if word == "IF":
            return self._if()
        if word == "FOR":
            self.take()
            name = self.take()
            self.take("FROM")
            first = self.until("TO")
            self.take("TO")
            last = self.until("DO")
            self.take("DO")
            body = self.statements("ENDFOR")
            self.take("ENDFOR")
            return ("for", name, first, last, body)
        if word == "WHILE":
            self.take()
            condition = self.until("DO")
            self.take("DO")
            body = self.statements("ENDWHILE")
            self.take("ENDWHILE")
            return ("while", condition, body)
        if word == "TEST":
            return self._test()
        return self._simple()

    def _if(self) -> Any:
        self.take("IF")
        branches: list[tuple[list[str] | None, list[Any]]] = []
        condition = self._condition()
        if self.peek() != "THEN":  # the short form holds one instruction
            return ("if", [(condition, [self._simple()])])
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
            return ("if", branches)

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

    def _test(self) -> Any:
        self.take("TEST")
        value = self.until("CASE", "DEFAULT")
        cases: list[tuple[list[list[str]] | None, list[Any]]] = []
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
        return ("test", value, cases)

    def _simple(self) -> Any:
        begin = self.at
        left = self.until(":=", ";", ",", "\\") if self.peek(1) in {".", "{", ":="} else []
        if left and self.peek() == ":=":
            self.take()
            right = self.until(";")
            self.take(";")
            return ("assign", left, right)
        self.at = begin
        name = self.take()
        arguments: list[list[str]] = []
        options: dict[str, list[str] | None] = {}
        while self.peek() != ";":
            if self.peek() == ",":
                self.take()
            if self.peek() == "\\":
                self.take()
                option = self.take().upper()
                options[option] = None
                if self.peek() == ":=":
                    self.take()
                    options[option] = self.until(",", "\\", ";")
            else:
                arguments.append(self.until(",", "\\", ";"))
        self.take(";")
        return ("call", name, arguments, options)
