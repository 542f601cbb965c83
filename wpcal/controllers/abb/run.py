"""Execution of ABB RAPID (Technical reference manual RAPID, 3HAC050917).

Rules that matter here: an ERROR handler belongs to its routine: TRYNEXT goes on after the instruction that failed,
RETRY repeats it, RAISE gives the error to the caller, and its end returns to the caller. `Save` writes a module with
the present values of its PERS data. What instructions do is in `wpcal.controllers.abb.instructions`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

import numpy as np

from wpcal.controllers.abb.instructions import Instructions, RapidError, RetryError, TryNextError
from wpcal.controllers.abb.statements import Data, ModuleReader, Routine, Statement
from wpcal.controllers.abb.values import PARTS, SYNTAX, RapidParser, Record, empty, matrix, pose_values, printed, typed
from wpcal.controllers.language.grammar import Does, mark_of
from wpcal.controllers.run.blocks import LeaveError
from wpcal.controllers.run.machine import Machine, Matrix, Place, about, rigid
from wpcal.controllers.run.program import ProgramError, Run, StoppedError, entries_of
from wpcal.core.same_bits import inverse_pose

ERRORS = {"ERR_WHLSEARCH": 1, "ERR_SIGSUPSEARCH": 2, "ERR_WAIT_MAXTIME": 3, "ERR_FILEACC": 4}
LEVELS = {"HIGH": 1, "LOW": 0}
SPEEDS = (5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800)
FAST = (1000, 1500, 2000, 2500, 3000, 4000, 5000, 6000, 7000)
ZONES = (0, 1, 5, 10, 15, 20, 30, 40, 50, 60, 80, 100, 150, 200)
ZERO = [[0, 0, 0], [1, 0, 0, 0]]


SEARCH = re.compile(r"\bSearchL((?:\\\w+)*),[ \t]*+(\w++)", re.IGNORECASE)


def _signals_of(texts: Iterable[str]) -> dict[str, bool]:
    """Return the inputs for which searches wait, and their levels."""
    found = (match for text in texts for match in SEARCH.finditer(text))
    return {match[2]: "NEGFLANK" not in match[1].upper() for match in found}


class Interpreter(Instructions):
    """One motion task with its modules.

    Parameters are those of `wpcal.controllers.run.interpreter.Interpreter`. Tools and work objects of the empty name
    are all that no module declares.
    """

    def __init__(
        self,
        files: Mapping[str, str],
        machine: Machine,
        *,
        tools: Mapping[Any, Matrix] | None = None,
        bases: Mapping[Any, Matrix] | None = None,
        signals: Mapping[Any, bool] | None = None,
        on_stop: Callable[[str], bool] = lambda _: False,
    ) -> None:
        self.machine, self.on_stop, self.run = machine, on_stop, Run()
        given = _signals_of(files.values()) if signals is None else signals
        self.signals = {str(name).upper(): int(level) for name, level in given.items()}
        self.data: dict[str, Data] = {}
        self.local: dict[tuple[str, str], Data] = {}  #: By file and name.
        self.routines: dict[str, Routine] = {}
        self.calls: dict[str, set[str]] = {}
        self.texts: dict[str, str] = {}
        self.scopes: list[dict[str, Data]] = []
        self.files: list[str] = []
        self.errors: list[str] = []
        self.is_fine, self.is_in_step = True, False
        self.shift = np.eye(4)
        self.undeclared: dict[str, Any] = {}
        self._predefine(tools or {}, bases or {})
        for file, text in files.items():
            self._load(ModuleReader(text, file))

    def _predefine(self, tools: Mapping[Any, Matrix], bases: Mapping[Any, Matrix]) -> None:
        given: dict[str, tuple[str, list[Any]]] = {}
        for name, T in {"TOOL0": np.eye(4), **tools}.items():
            given[str(name) or " tool"] = "tooldata", [True, pose_values(T), [1, [0, 0, 1], [1, 0, 0, 0], 0, 0, 0]]
        for name, T in {"WOBJ0": np.eye(4), **bases}.items():
            given[str(name) or " wobj"] = "wobjdata", [False, True, "", pose_values(T), ZERO]
        for speed in SPEEDS + FAST:
            given[f"V{speed}"] = "speeddata", [speed, 500, 5000, 1000]
        for zone in ("FINE", *(f"Z{mm}" for mm in ZONES)):
            mm = 0 if zone == "FINE" else int(zone[1:])
            given[zone] = "zonedata", [zone == "FINE", mm, 0, 0, 0, 0, 0]
        for name, (kind, values) in given.items():
            if name.startswith(" "):
                self.undeclared[kind] = typed(kind, values)
            else:
                self.data[name.upper()] = Data("PERS", kind, typed(kind, values))
        self.given = set(self.data)

    def _load(self, reader: ModuleReader) -> None:
        self.calls |= reader.calls
        self.texts |= dict.fromkeys(reader.names, reader.text)
        self.files.append(reader.file)
        for line, storage, kind, name, is_array, tokens, is_local in reader.declarations:
            key = (reader.file, name.upper())
            if key in self.local or (not is_local and name.upper() in self.data and name.upper() not in self.given):
                raise ProgramError(f"{name} is declared twice", path=reader.file, line=line)
            try:
                value = self.value(tokens) if tokens else [] if is_array else empty(kind)
                value = [typed(kind, one) for one in value] if is_array else typed(kind, value)
            except ProgramError as error:
                raise error.at(reader.file, line) from None
            made = Data(storage, kind, value, is_array)
            if is_local:
                self.local[key] = made
            else:
                self.data[name.upper()] = made
        self.files.pop()
        for routine in reader.routines:
            if routine.name.upper() in self.routines:
                raise ProgramError(f"{routine.name} is declared twice", path=reader.file)
            self.routines[routine.name.upper()] = routine

    # -- names -----------------------------------------------------------------------------------------------------

    def find(self, name: str) -> Data | None:
        """Return data by its name in this routine or of a module."""
        name = name.upper()
        if self.scopes and name in self.scopes[-1]:
            return self.scopes[-1][name]
        own = self.local.get((self.files[-1], name)) if self.files else None
        return own or self.data.get(name)

    def name(self, name: str) -> Any:
        """Return the value of a name."""
        for known in (ERRORS, LEVELS):
            if name in known:
                return known[name]
        if name == "ERRNO":
            return ERRORS[self.errors[-1]] if self.errors else 0
        if name in self.signals:
            return self.input(name)
        data = self.find(name)
        if data is None:
            raise ProgramError(f"{name} is not declared")
        return data.value

    def part(self, value: Any, name: str) -> Any:
        """Return a part of a record."""
        if not isinstance(value, Record):
            raise ProgramError(f"{value!r} has no part {name}")
        return value.values[value.index(name)]

    def item(self, value: Any, indices: list[Any]) -> Any:
        """Return an element of an array."""
        for index in indices:
            if not isinstance(value, list) or not isinstance(index, int | float) or not 1 <= index <= len(value):
                raise ProgramError(f"no element {index}")
            value = value[int(index) - 1]
        return value

    def call(self, name: str, arguments: list[Any]) -> Any:
        """Return the value of a function."""
        options = arguments.pop() if arguments and isinstance(arguments[-1], dict) else {}
        if name in {"OFFS", "RELTOOL"}:
            target, *by = arguments
            turns = [options.get(axis, 0.0) for axis in ("RX", "RY", "RZ")]
            shift = rigid(about("XYZ", turns), by)
            moved = shift @ matrix(target) if name == "OFFS" else matrix(target) @ shift
            return Record("robtarget", [*typed("pose", pose_values(moved)).values, *target.copy().values[2:]])
        if name == "CROBT":
            tool, wobj = options.get("TOOL"), options.get("WOBJ", self.data["WOBJ0"].value)
            if tool is None:
                raise ProgramError("CRobT without \\Tool")
            seen = inverse_pose(self.frame(wobj) @ self.shift) @ self.machine.reading(self.tool(tool))
            return typed("robtarget", [*pose_values(seen), [0, 0, 0, 0], [9e9] * 6])
        functions: dict[str, Callable[..., Any]] = {
            "POSEMULT": lambda a, b: typed("pose", pose_values(matrix(a) @ matrix(b))),
            "POSEVECT": lambda a, v: Record(
                "pos", (matrix(a)[:3, :3] @ np.array(v.values, float) + matrix(a)[:3, 3]).tolist()
            ),
            "POSEINV": lambda a: typed("pose", pose_values(inverse_pose(matrix(a)))),
            "ORIENTZYX": lambda z, y, x: typed("orient", pose_values(rigid(about("ZYX", [z, y, x]), [0, 0, 0]))[1]),
            "DINPUT": lambda value: value,
            "DOUTPUT": lambda value: value,
            "NUMTOSTR": lambda value, digits: f"{value:.{int(digits)}f}",
            "VALTOSTR": printed,
            "DOTPROD": lambda a, b: float(np.dot(a.values, b.values)),
            "VECTMAGN": lambda a: float(np.linalg.norm(a.values)),
            "NORIENT": lambda q: typed("orient", (np.array(q, float) / np.linalg.norm(q)).tolist()),
            "DISTANCE": lambda a, b: float(np.linalg.norm(np.subtract(a.values, b.values))),
            "ABS": abs,
        }
        if name not in functions:
            raise ProgramError(f"the function {name} is unknown")
        return functions[name](*arguments)

    def value(self, tokens: list[str]) -> Any:
        """Return the value of an expression."""
        return RapidParser(tokens, SYNTAX, self).whole()

    def assign(self, tokens: list[str], value: Any) -> None:
        """Give data, or a part of it, a value."""
        data = self.find(tokens[0])
        if data is None:
            raise ProgramError(f"{tokens[0]} is not declared")
        if data.storage == "CONST":
            raise ProgramError(f"{tokens[0]} is a constant")
        if len(tokens) == 1:
            data.value = value if data.is_array else typed(data.kind, value)
            return
        *steps, last = self._steps(tokens)
        kind, holder = data.kind, data.value
        for step in steps:
            kind, holder = self._into(kind, holder, step)
        kind, _ = self._into(kind, holder, last)
        if isinstance(last, int):
            holder[last] = typed(kind, value)
        else:
            holder.values[holder.index(last)] = typed(kind, value)

    def _steps(self, tokens: list[str]) -> list[str | int]:
        """Return the parts and elements behind a name."""
        steps: list[str | int] = []
        at = 1
        while at < len(tokens):
            if tokens[at] == "." and at + 1 < len(tokens):
                steps.append(tokens[at + 1].lower())
                at += 2
            elif tokens[at] == "{" and "}" in tokens[at:]:
                close = tokens.index("}", at)
                steps.append(int(self.value(tokens[at + 1 : close])) - 1)
                at = close + 1
            else:
                raise ProgramError(f"cannot be assigned: {' '.join(tokens)}")
        return steps

    def _into(self, kind: str, holder: Any, step: Any) -> tuple[str, Any]:
        if isinstance(step, int):
            if not isinstance(holder, list) or not 0 <= step < len(holder):
                raise ProgramError(f"no element {step + 1}")
            return kind, holder[step]
        if not isinstance(holder, Record):
            raise ProgramError(f"no part {step}")
        position = holder.index(step)
        return PARTS[holder.kind][position][1], holder.values[position]

    # -- running ---------------------------------------------------------------------------------------------------

    def entries(self) -> list[str]:
        """Return the procedures that no other one calls."""
        return [name for name in entries_of(self.calls) if not self.routines[name].parameters]

    def start(self, routine: str = "main") -> Run:
        """Run a routine to its end, or until the operator ends it at a stop."""
        try:
            self.call_routine(routine.upper(), [])
        except StoppedError:
            return self.run
        except RapidError as error:
            raise ProgramError(f"no handler takes {error}") from error
        self.run.is_finished = True
        return self.run

    def call_routine(self, name: str, arguments: list[list[str]]) -> None:
        """Execute a procedure."""
        routine = self.routines.get(name)
        if routine is None:
            raise ProgramError(f"the instruction or routine {name} is unknown")
        if len(arguments) != len(routine.parameters):
            raise ProgramError(f"{name} is called with {len(arguments)} arguments, not {len(routine.parameters)}")
        scope: dict[str, Data] = {}
        for tokens, (mode, kind, parameter) in zip(arguments, routine.parameters, strict=True):
            if mode == "IN":
                scope[parameter.upper()] = Data("VAR", kind, typed(kind, self.value(tokens)))
                continue
            given = self.find(tokens[0]) if len(tokens) == 1 else None
            if given is None or given.kind != kind or (mode == "PERS" and given.storage != "PERS"):
                raise ProgramError(f"{name}: {' '.join(tokens)} is no {mode} {kind}")
            scope[parameter.upper()] = given
        self.scopes.append(scope)
        self.files.append(routine.file)
        try:
            for _, storage, kind, variable, is_array, tokens, _ in routine.declarations:
                value = self.value(tokens) if tokens else empty(kind)
                scope[variable.upper()] = Data(storage, kind, value if is_array else typed(kind, value), is_array)
            self.block(routine.body, routine)
        except LeaveError:
            pass
        finally:
            self.scopes.pop()
            self.files.pop()
        self.machine.switch(Does.STOP)

    def block(self, statements: list[Statement], routine: Routine, *, in_handler: bool = False) -> None:
        """Execute statements in order, and the handler of their routine where one fails."""
        for statement in statements:
            while True:
                try:
                    self.execute(statement, routine, in_handler=in_handler)
                except RapidError as error:
                    if routine.handler is None or in_handler:
                        raise
                    self.errors.append(str(error))
                    try:
                        self.block(routine.handler, routine, in_handler=True)
                    except TryNextError:
                        break
                    except RetryError:
                        continue
                    finally:
                        self.errors.pop()
                    raise LeaveError from None
                break

    def execute(self, statement: Statement, routine: Routine, *, in_handler: bool) -> None:
        """Execute one statement; the machine takes what is refused."""
        kind, line, parts = statement
        file = self.files[-1]
        self.run.step(len(self.scopes), file, line)
        self.machine.at = Place(file, line)

        def block(body: list[Statement]) -> None:
            self.run.step(len(self.scopes), file, line)
            self.block(body, routine, in_handler=in_handler)

        try:
            if kind in {"if", "for", "while", "test"}:
                getattr(self, f"_{kind}")(block, *parts)
            elif kind == "assign":
                self.assign(parts[0], self.value(parts[1]))
            elif kind == "mark":
                self.machine.switch(mark_of(parts[0]) or Does.DRY)
            elif kind == "call":
                self.instruction(*parts)
        except ProgramError as error:
            self.machine.at = Place(file, line)
            self.machine.refuse(error.at(file, line))

    def _if(self, block: Callable[[list[Statement]], None], branches: list[Any]) -> None:
        for condition, body in branches:
            if condition is None or self.value(condition) is True:
                block(body)
                return

    def _for(
        self, block: Callable[[list[Statement]], None], name: str, first: list[str], last: list[str], *rest: Any
    ) -> None:
        step, body = rest
        begin, end = int(self.value(first)), int(self.value(last))
        by = int(self.value(step)) if step else 1 if end >= begin else -1
        if by == 0:
            raise ProgramError("FOR with a step of 0")
        for number in range(begin, end + (1 if by > 0 else -1), by):
            self.scopes[-1][name.upper()] = Data("VAR", "num", number)
            block(body)

    def _while(self, block: Callable[[list[Statement]], None], condition: list[str], body: list[Statement]) -> None:
        while self.value(condition):
            block(body)

    def _test(self, block: Callable[[list[Statement]], None], tokens: list[str], cases: list[Any]) -> None:
        found = self.value(tokens)
        for values, body in cases:
            if values is None or any(self.value(one) == found for one in values):
                block(body)
                return

    def instruction(self, name: str, arguments: list[list[str]], options: dict[str, list[str]]) -> None:
        """Execute an instruction, or call a procedure."""
        if self.is_known(name, arguments, options):
            return
        if options:
            raise ProgramError(f"{name} is unknown")
        self.call_routine(name.upper(), arguments)
