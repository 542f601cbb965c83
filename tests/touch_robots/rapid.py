"""ABB RAPID, as far as touch programs use it (Technical reference manual RAPID, 3HAC050917).

Rules that matter here: `SearchL` gives the place at the signal in the named work object. Without `\\Flanks` only a
rising edge counts; a signal that is on at the start raises ERR_SIGSUPSEARCH without motion, and a search that ends
without the signal raises ERR_WHLSEARCH at its end. The move before a search ends in a fine point. An ERROR handler
belongs to its routine: TRYNEXT goes on after the instruction that failed, RETRY repeats it, RAISE gives the error to
the caller, and its end returns to the caller. `Save` writes a module with the present values of its PERS data.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from tests.touch_robots.rapid_data import (
    GRAMMAR,
    PARTS,
    RapidParser,
    Record,
    empty,
    matrix,
    printed,
    typed,
    values_of,
)
from tests.touch_robots.rapid_instructions import Instructions, RapidError, RetryError, ReturnError, TryNextError
from tests.touch_robots.rapid_text import Data, ModuleReader, Routine
from tests.touch_robots.robot import Array, Robot
from wpcal.controllers.run.machine import inverted, rigid
from wpcal.controllers.run.program import ProgramError, Run, StoppedError

ERRORS = {"ERR_WHLSEARCH": 1, "ERR_SIGSUPSEARCH": 2, "ERR_WAIT_MAXTIME": 3, "ERR_FILEACC": 4}
LEVELS = {"HIGH": 1, "LOW": 0}


class Controller(Instructions):
    """One motion task with its modules.

    Parameters
    ----------
    files : Modules by file name.
    signal : Name of the input that the touch switches, as in the configuration of the controller.
    tools : Tools that the controller already has, T_flange_tool.
    on_stop : What the operator does at a stop: True goes on.
    level : Of the input at contact.
    """

    def __init__(
        self,
        files: dict[str, str],
        robot: Robot,
        *,
        signal: str = "diTouch",
        tools: dict[str, Array] | None = None,
        on_stop: Callable[[str], bool] = lambda _: False,
        level: int = 1,
    ) -> None:
        self.robot, self.signal, self.on_stop, self.level, self.run = robot, signal.upper(), on_stop, level, Run()
        self.data: dict[str, Data] = {}
        self.routines: dict[str, Routine] = {}
        self.texts: dict[str, str] = {}
        self.scopes: list[dict[str, Data]] = []
        self.errors: list[str] = []
        self.is_fine = True
        self.handling = 0
        self._predefine(tools or {})
        for text in files.values():
            ModuleReader(self, text).read()

    def _predefine(self, tools: dict[str, Array]) -> None:
        one = [[0, 0, 0], [1, 0, 0, 0]]
        for name, T in {"TOOL0": np.eye(4), **{k.upper(): T for k, T in tools.items()}}.items():
            value = typed("tooldata", [True, values_of(T), [1, [0, 0, 1], [1, 0, 0, 0], 0, 0, 0]])
            self.data[name] = Data("PERS", "tooldata", value, "")
        self.data["WOBJ0"] = Data("PERS", "wobjdata", typed("wobjdata", [False, True, "", one, one]), "")
        for speed in (5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800, 1000, 1500, 2000):
            self.data[f"V{speed}"] = Data("CONST", "speeddata", typed("speeddata", [speed, 500, 5000, 1000]), "")
        for zone in ("FINE", *(f"Z{mm}" for mm in (0, 1, 5, 10, 15, 20, 30, 40, 50, 60, 80, 100, 150, 200))):
            mm = 0 if zone == "FINE" else int(zone[1:])
            self.data[zone] = Data("CONST", "zonedata", typed("zonedata", [zone == "FINE", mm, 0, 0, 0, 0, 0]), "")

    # -- names -----------------------------------------------------------------------------------------------------

    def find(self, name: str) -> Data | None:
        name = name.upper()
        for scope in self.scopes[-1:]:
            if name in scope:
                return scope[name]
        return self.data.get(name)

    def name(self, name: str) -> Any:
        if name in ERRORS:
            return ERRORS[name]
        if name in LEVELS:
            return LEVELS[name]
        if name == "ERRNO":
            return ERRORS[self.errors[-1]] if self.errors else 0
        if name == self.signal:
            return self.input()
        data = self.find(name)
        if data is None:
            raise ProgramError(f"{name} is not declared")
        return data.value

    def part(self, value: Any, name: str) -> Any:
        if not isinstance(value, Record):
            raise ProgramError(f"{value!r} has no part {name}")
        return value.values[value.index(name)]

    def item(self, value: Any, indices: list[Any]) -> Any:
        for index in indices:
            if not isinstance(value, list) or not 1 <= index <= len(value):
                raise ProgramError(f"no element {index} in {value!r}")
            value = value[int(index) - 1]
        return value

    def call(self, name: str, arguments: list[Any]) -> Any:
        options = arguments.pop() if arguments and isinstance(arguments[-1], dict) else {}
        if name in {"OFFS", "RELTOOL"}:
            target, *by = arguments
            shift = rigid(Rotation.identity(), by)
            moved = shift @ matrix(target) if name == "OFFS" else matrix(target) @ shift
            return Record("robtarget", [*typed("pose", values_of(moved)).values, *target.copy().values[2:]])
        if name == "CROBT":
            tool, wobj = options.get("TOOL"), options.get("WOBJ", self.data["WOBJ0"].value)
            if tool is None:
                raise ProgramError("CRobT without \\Tool")
            seen = inverted(self.frame(wobj)) @ self.robot.reading(self.tool(tool))
            return typed("robtarget", [*values_of(seen), [0, 0, 0, 0], [9e9] * 6])
        if name == "POSEMULT":
            return typed("pose", values_of(matrix(arguments[0]) @ matrix(arguments[1])))
        if name == "POSEINV":
            return typed("pose", values_of(inverted(matrix(arguments[0]))))
        if name in {"DINPUT", "DOUTPUT"}:
            return arguments[0]
        if name == "NUMTOSTR":
            return f"{arguments[0]:.{int(arguments[1])}f}"
        if name == "VALTOSTR":
            return printed(arguments[0])
        if name == "DISTANCE":
            return float(np.linalg.norm(np.subtract(arguments[0].values, arguments[1].values)))
        if name == "ABS":
            return abs(arguments[0])
        raise ProgramError(f"the function {name} is unknown")

    # -- instructions ----------------------------------------------------------------------------------------------

    def value(self, tokens: list[str]) -> Any:
        parser = RapidParser(tokens, GRAMMAR, self)
        value = parser.value()
        parser.end()
        return value

    def assign(self, tokens: list[str], value: Any) -> None:
        data = self.find(tokens[0])
        if data is None:
            raise ProgramError(f"{tokens[0]} is not declared")
        if data.storage == "CONST":
            raise ProgramError(f"{tokens[0]} is a constant")
        if len(tokens) == 1:
            data.value = value if data.is_array else typed(data.kind, value)
            return
        holder: Any = data.value
        steps: list[Any] = []
        at = 1
        while at < len(tokens):
            if tokens[at] == ".":
                steps.append(tokens[at + 1].lower())
                at += 2
            elif tokens[at] == "{":
                close = tokens.index("}", at)
                steps.append(int(self.value(tokens[at + 1 : close])) - 1)
                at = close + 1
            else:
                raise ProgramError(f"cannot be assigned: {' '.join(tokens)}")
        kind = data.kind
        for step in steps[:-1]:
            kind, holder = self._into(kind, holder, step)
        last = steps[-1]
        if isinstance(last, int):
            if not 0 <= last < len(holder):
                raise ProgramError(f"no element {last + 1}")
            holder[last] = typed(kind, value)
        else:
            position = holder.index(last)
            holder.values[position] = typed(PARTS[holder.kind][position][1], value)

    def _into(self, kind: str, holder: Any, step: Any) -> tuple[str, Any]:
        if isinstance(step, int):
            return kind, holder[step]
        position = holder.index(step)
        return PARTS[holder.kind][position][1], holder.values[position]

    def start(self, routine: str = "main") -> Run:
        """Run a routine to its end, or until the operator ends it at a stop."""
        try:
            self._routine(routine.upper(), [])
        except StoppedError:
            return self.run
        except RapidError as error:
            raise ProgramError(f"no handler takes {error}") from error
        self.run.is_finished = True
        return self.run

    def _routine(self, name: str, arguments: list[list[str]]) -> None:
        routine = self.routines.get(name)
        if routine is None:
            raise ProgramError(f"the instruction or routine {name} is unknown")
        if len(arguments) != len(routine.parameters):
            raise ProgramError(f"{name} is called with {len(arguments)} arguments, not {len(routine.parameters)}")
        scope: dict[str, Data] = {}
        for tokens, (mode, kind, parameter, _) in zip(arguments, routine.parameters, strict=True):
            if mode == "IN":
                scope[parameter.upper()] = Data("VAR", kind, typed(kind, self.value(tokens)), "")
                continue
            given = self.find(tokens[0]) if len(tokens) == 1 else None
            if given is None or given.kind != kind or (mode == "PERS" and given.storage != "PERS"):
                raise ProgramError(f"{name}: {' '.join(tokens)} is no {mode} {kind}")
            scope[parameter.upper()] = given
        self.scopes.append(scope)
        try:
            for storage, kind, variable, size, tokens in routine.declarations:
                value = self.value(tokens) if tokens else empty(kind)
                scope[variable.upper()] = Data(storage, kind, typed(kind, value) if size is None else value, "")
            self.block(routine.body, routine)
        except ReturnError:
            pass
        finally:
            self.scopes.pop()

    def block(self, statements: list[Any], routine: Routine, *, in_handler: bool = False) -> None:
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
                    raise ReturnError from None
                break

    def execute(self, statement: Any, routine: Routine, *, in_handler: bool) -> None:
        kind = statement[0]
        if kind == "if":
            for condition, body in statement[1]:
                if condition is None or self.value(condition) is True:
                    self.block(body, routine, in_handler=in_handler)
                    return
        elif kind == "for":
            _, name, first, last, body = statement
            for number in range(int(self.value(first)), int(self.value(last)) + 1):
                self.scopes[-1][name.upper()] = Data("VAR", "num", number, "")
                self.block(body, routine, in_handler=in_handler)
        elif kind == "while":
            while self.value(statement[1]):
                self.block(statement[2], routine, in_handler=in_handler)
        elif kind == "test":
            found = self.value(statement[1])
            for values, body in statement[2]:
                if values is None or any(self.value(v) == found for v in values):
                    self.block(body, routine, in_handler=in_handler)
                    return
        elif kind == "assign":
            self.assign(statement[1], self.value(statement[2]))
        else:
            self.instruction(statement[1], statement[2], statement[3])

    def instruction(self, name: str, arguments: list[list[str]], options: dict[str, list[str] | None]) -> None:
        function = getattr(self, f"_do_{name.lower()}", None)
        if function is None:
            if options:
                raise ProgramError(f"{name} is unknown")
            self._routine(name.upper(), arguments)
            return
        function(arguments, options)
