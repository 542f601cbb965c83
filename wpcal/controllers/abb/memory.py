"""Data and routines of ABB RAPID while they run (Technical reference manual RAPID, 3HAC050917).

Rules that matter here: an ERROR handler belongs to its routine: TRYNEXT goes on after the instruction that failed,
RETRY repeats it, RAISE gives the error to the caller, and its end returns to the caller. `Save` writes a module with
the present values of its PERS data. What instructions do is in `wpcal.controllers.abb.run`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np

from wpcal.controllers.abb.read import GRAMMAR
from wpcal.controllers.abb.statements import MARK, Data, Declaration, ModuleReader, Procedure
from wpcal.controllers.abb.values import PARTS, SYNTAX, RapidParser, Record, empty, matrix, pose_values, printed, typed
from wpcal.controllers.run.blocks import BlockInterpreter, LeaveError, Node, Steps, text_of
from wpcal.controllers.run.machine import Matrix, ProgramError, Run, about, entries_of, rigid
from wpcal.core.same_bits import inverse_pose

ERRORS = {"ERR_WHLSEARCH": 1, "ERR_SIGSUPSEARCH": 2, "ERR_WAIT_MAXTIME": 3, "ERR_FILEACC": 4}
LEVELS = {"HIGH": 1, "LOW": 0}
SPEEDS = (5, 10, 20, 30, 40, 50, 60, 80, 100, 150, 200, 300, 400, 500, 600, 800)
FAST = (1000, 1500, 2000, 2500, 3000, 4000, 5000, 6000, 7000)
ZONES = (0, 1, 5, 10, 15, 20, 30, 40, 50, 60, 80, 100, 150, 200)
ZERO = [[0, 0, 0], [1, 0, 0, 0]]


class RapidError(Exception):
    """An error that a handler may take."""


class TryNextError(Exception):
    """TRYNEXT in a handler."""


class RetryError(Exception):
    """RETRY in a handler."""


class Memory(BlockInterpreter):
    """Modules with their data, and how routines and their handlers run; `Interpreter` knows the instructions."""

    grammar, words, COMMENT, PARSER, RETURNS = GRAMMAR, SYNTAX, MARK, RapidParser, False
    FOR = ("FROM", "TO", "STEP", "DO")
    SIGNAL = r"(?i)\bSearchL(?:\\(?:(?P<off>NegFlank)|\w+))*,[ \t]*+(?P<name>\w++)"

    def __init__(self, files: Mapping[str, str], *args: Any, **given: Any) -> None:
        self.data: dict[str, Data] = {}
        self.local: dict[tuple[str, str], Data] = {}  #: By file and name.
        self.procedures: dict[str, Procedure] = {}
        self.running: list[Procedure] = []
        self.texts: dict[str, str] = {}
        self.errors: list[str] = []
        self.is_fine, self.is_in_step, self.in_handler = True, False, False
        self.shift = np.eye(4)
        self.undeclared: dict[str, Any] = {}
        self._predefine(*(given.pop(key, None) or {} for key in ("tools", "bases")))
        super().__init__(files, *args, **given)
        self.signals = {str(name).upper(): bool(level) for name, level in self.signals.items()}
        self.file = ""  # until a routine runs

    def _predefine(self, tools: Mapping[Any, Matrix], bases: Mapping[Any, Matrix]) -> None:
        load, sizes = [1, [0, 0, 1], [1, 0, 0, 0], 0, 0, 0], {"FINE": 0, **{f"Z{mm}": mm for mm in ZONES}}
        given: dict[str, dict[Any, list[Any]]] = {
            "tooldata": {name: [True, pose_values(T), load] for name, T in {"TOOL0": np.eye(4), **tools}.items()},
            "wobjdata": {
                name: [False, True, "", pose_values(T), ZERO] for name, T in {"WOBJ0": np.eye(4), **bases}.items()
            },
            "speeddata": {f"V{speed}": [speed, 500, 5000, 1000] for speed in SPEEDS + FAST},
            "zonedata": {name: [name == "FINE", mm, 0, 0, 0, 0, 0] for name, mm in sizes.items()},
        }
        for kind, values in given.items():
            if "" in values:
                self.undeclared[kind] = typed(kind, values.pop(""))
            self.data |= {str(name).upper(): Data("PERS", kind, typed(kind, each)) for name, each in values.items()}
        self.given = set(self.data)

    def load(self, file: str, text: str) -> None:
        reader, self.file = ModuleReader(text, file), file
        self.texts |= dict.fromkeys(reader.names, reader.text)
        for each in reader.declarations:
            name = each.name.upper()
            if (file, name) in self.local or (not each.is_local and name in self.data and name not in self.given):
                raise ProgramError(f"{each.name} is declared twice", path=file, line=each.line)
            try:
                made = self._made(each)
            except ProgramError as error:
                raise error.at(file, each.line) from None
            if each.is_local:
                self.local[file, name] = made
            else:
                self.data[name] = made
        for name, routine in reader.routines.items():
            self.routines[self.declare(name, file, self.routines)] = self.procedures[name] = routine

    def _made(self, each: Declaration) -> Data:
        kind, is_array = each.kind, bool(each.size)
        value = self.value(each.tokens) if each.tokens else [] if is_array else empty(kind)
        value = [typed(kind, one) for one in value] if is_array else typed(kind, value)
        return Data(each.storage, kind, value, is_array)

    # -- names -----------------------------------------------------------------------------------------------------

    def find(self, name: str) -> Data | None:
        """Return data by its name in this routine or of a module."""
        name = name.upper()
        if name in self.locals[-1]:
            return self.locals[-1][name]  # type: ignore[no-any-return]
        return self.local.get((self.file, name)) or self.data.get(name)

    def name(self, name: str) -> Any:
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
        if not isinstance(value, Record):
            raise ProgramError(f"{value!r} has no part {name}")
        return value.values[value.index(name)]

    def item(self, value: Any, indices: list[Any]) -> Any:
        for index in indices:
            if not isinstance(value, list) or not isinstance(index, int | float) or not 1 <= index <= len(value):
                raise ProgramError(f"no element {index}")
            value = value[int(index) - 1]
        return value

    def _displaced(self, target: Record, *by: float, in_tool: bool = False, **turns: float) -> Record:
        shift = rigid(about("XYZ", [turns.get(axis, 0.0) for axis in ("RX", "RY", "RZ")]), by)
        moved = matrix(target) @ shift if in_tool else shift @ matrix(target)
        return Record("robtarget", [*typed("pose", pose_values(moved)).values, *target.copy().values[2:]])

    def _crobt(self, **options: Any) -> Any:
        tool, wobj = options.get("TOOL"), options.get("WOBJ", self.data["WOBJ0"].value)
        if tool is None:
            raise ProgramError("CRobT without \\Tool")
        seen = inverse_pose(self.T_of_frame(wobj) @ self.shift) @ self.machine.reading(self.T_of_tool(tool))
        return typed("robtarget", [*pose_values(seen), [0, 0, 0, 0], [9e9] * 6])

    FUNCTIONS: Mapping[str, Callable[..., Any]] = {
        "offs": _displaced,
        "reltool": lambda self, *given, **turns: self._displaced(*given, in_tool=True, **turns),
        "crobt": _crobt,
        "posemult": lambda _, a, b: typed("pose", pose_values(matrix(a) @ matrix(b))),
        "posevect": lambda _, a, v: Record(
            "pos", (matrix(a)[:3, :3] @ np.array(v.values, float) + matrix(a)[:3, 3]).tolist()
        ),
        "poseinv": lambda _, a: typed("pose", pose_values(inverse_pose(matrix(a)))),
        "orientzyx": lambda _, z, y, x: typed("orient", pose_values(rigid(about("ZYX", [z, y, x]), [0, 0, 0]))[1]),
        "dinput": lambda _, value: value,
        "doutput": lambda _, value: value,
        "numtostr": lambda _, value, digits: f"{value:.{int(digits)}f}",
        "valtostr": lambda _, value: printed(value),
        "dotprod": lambda _, a, b: float(np.dot(a.values, b.values)),
        "vectmagn": lambda _, a: float(np.linalg.norm(a.values)),
        "norient": lambda _, q: typed("orient", (np.array(q, float) / np.linalg.norm(q)).tolist()),
        "distance": lambda _, a, b: float(np.linalg.norm(np.subtract(a.values, b.values))),
        "abs": lambda _, value: abs(value),
    }

    def input(self, name: str) -> int:
        """Return the level of an input that the touch switches."""
        return self.signals[name] if self.machine.is_on() else 1 - self.signals[name]

    def T_of_tool(self, tool: Any) -> Matrix:
        """Return T_flange_tool."""
        if not isinstance(tool, Record) or tool.kind != "tooldata":
            raise ProgramError("a tool is expected")
        if tool.values[0] is not True or tool.values[2].values[0] <= 0:
            raise ProgramError("the tool is not held by the robot, or weighs nothing")
        return matrix(tool.values[1])

    def T_of_frame(self, wobj: Any) -> Matrix:
        """Return the place of a work object: in `base`, or in the unit that carries it."""
        if not isinstance(wobj, Record) or wobj.kind != "wobjdata" or wobj.values[0] is not False:
            raise ProgramError("the work object is held by the robot")
        if wobj.values[1] is not True and not wobj.values[2]:
            raise ProgramError("the user frame moves with nothing")
        return matrix(wobj.values[3]) @ matrix(wobj.values[4])

    def give(self, name: str, value: Any) -> None:
        self.locals[-1][name] = Data("VAR", "num", value)

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
        if tokens[-2:-1] == ["."]:
            holder, part = self.value(tokens[:-2]), tokens[-1].lower()
            if not isinstance(holder, Record):
                raise ProgramError(f"no part {part}")
            at = holder.index(part)
            holder.values[at] = typed(PARTS[holder.kind][at][1], value)
        elif tokens[-1] == "}" and "{" in tokens:
            begin = len(tokens) - 1 - tokens[::-1].index("{")
            holder, index = self.value(tokens[:begin]), self.value(tokens[begin + 1 : -1])
            self.item(holder, [index])  # refused where there is none
            holder[int(index) - 1] = typed(data.kind, value)
        else:
            raise ProgramError(f"cannot be assigned: {' '.join(tokens)}")

    # -- running ---------------------------------------------------------------------------------------------------

    def steps_of(self) -> Iterable[Steps]:
        known = self.procedures.values()
        return [*known, *(Steps(one.file, (), one.handler) for one in known if one.handler)]

    def entries(self) -> list[str]:
        texts = {name: text_of([*one.body, *(one.handler or ())]) for name, one in self.procedures.items()}
        found = entries_of({name: self._words(text) for name, text in texts.items()})
        return [name for name in found if not self.procedures[name].parameters]

    def start(self, routine: str = "main") -> Run:
        """Run a routine to its end, or until the operator ends it at a stop."""
        try:
            return super().start(routine)
        except RapidError as error:
            raise ProgramError(f"no handler takes {error}") from error

    def routine(self, name: str, arguments: Sequence[list[str]] = ()) -> None:
        """Run a procedure with the texts of its arguments."""
        found = self.procedures.get(name.upper())
        if found is None:
            raise ProgramError(f"the instruction or routine {name} is unknown")
        if len(arguments) != len(found.parameters):
            raise ProgramError(f"{name} is called with {len(arguments)} arguments, not {len(found.parameters)}")
        given = [self._argument(name, tokens, *kind) for tokens, kind in zip(arguments, found.kinds, strict=True)]
        self.running.append(found)
        before, self.in_handler = self.in_handler, False
        try:
            super().routine(name, given)
        finally:
            self.running.pop()
            self.in_handler = before

    def _argument(self, name: str, tokens: list[str], mode: str, kind: str) -> Data:
        if mode == "IN":
            return Data("VAR", kind, typed(kind, self.value(tokens)))
        given = self.find(tokens[0]) if len(tokens) == 1 else None
        if given is None or given.kind != kind or (mode == "PERS" and given.storage != "PERS"):
            raise ProgramError(f"{name}: {' '.join(tokens)} is no {mode} {kind}")
        return given

    def block(self, nodes: Sequence[Node]) -> None:
        """Run statements in order, and the handler of their routine where one fails."""
        file = self.file
        for node in nodes:
            while True:
                try:
                    self.step(file, node.line, partial(self.execute, node))
                except RapidError as error:
                    handler = self.running[-1].handler
                    if handler is None or self.in_handler:
                        raise
                    self.errors.append(str(error))
                    self.in_handler, self.file = True, file
                    try:
                        self.block(handler)
                    except TryNextError:
                        break
                    except RetryError:
                        continue
                    finally:
                        self.errors.pop()
                        self.in_handler = False
                    raise LeaveError from None
                break

    def counted(self, node: Node, name: str, first: Any, last: Any, step: Any = None) -> None:
        """Run a block with a variable that counts, by default down where the last value is less."""
        super().counted(node, name, first, last, (1 if last >= first else -1) if step is None else step)
