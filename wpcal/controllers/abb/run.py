r"""What the instructions of RAPID do.

`SearchL` gives the place at the signal in the named work object. Without ``\Flanks`` only a rising edge counts; a
signal that is on at the start raises ERR_SIGSUPSEARCH without motion, and a search that ends without the signal raises
ERR_WHLSEARCH at its end. The move before a search ends in a fine point. A program displacement is between the work
object and the target of every linear and circular move, and of those by the joints to a robtarget.
"""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partialmethod
from typing import Any

import numpy as np

from wpcal.controllers.abb.memory import Memory, RapidError, RetryError, TryNextError
from wpcal.controllers.abb.statements import STORAGE, Statement, declared, instruction
from wpcal.controllers.abb.values import Record, matrix, nested, pose_values, printed, typed
from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.blocks import Node
from wpcal.controllers.run.machine import WHOLE_ZONE, Matrix, Place, ProgramError, StoppedError
from wpcal.core.same_bits import inverse_pose

STOP_LIMIT_MM_S = 100.0  #: `SearchL\\Stop` is only allowed below this speed.
NO_AXIS = 9e9  #: The value of an external axis that the robot does not have.
LINE_LENGTH, EVENT_LENGTH = 80, 46  #: Characters that TPWrite and ErrWrite take.


MOVES = {"WOBJ", "ID", "T", "V", "INPOS", "CONC"}
ARCS = {"WOBJ", "ID", "WEAVE", "SEAMNAME", "T"}
MOTION = re.compile(r"(MOVE)([LCJ])()|(ARC)([LC])(START|END|)")
COUNTS = {"MOVE": 4, "ARC": 6}  #: Arguments without the middle of an arc.
HARMLESS = {"WAITDI", "WAITDO", "WAITUNTIL", "WAITROB", "PULSEDO", "SETAO", "SETGO", "ACTUNIT", "DEACTUNIT"}
HARMLESS |= {"CIRPATHMODE", "SINGAREA", "ACCSET", "VELSET", "GRIPLOAD", "CLKSTART", "CLKSTOP", "CLKRESET"}
HARMLESS |= {"TPERASE", "EOFFSOFF", "CONFL", "CONFJ"}
"""Instructions without effect on where a motion ends."""
USUAL = {"CIRPATHMODE": {"PATHFRAME", "OBJECTFRAME"}, "SINGAREA": {"OFF"}}
"""The options with which an instruction leaves the tool the turns that are judged between two poses."""


class Interpreter(Memory):
    """One motion task with its modules; tools and work objects of the empty name are all that no module declares."""

    def statement(self, word: str, tokens: list[str], node: Node) -> None:
        if word in STORAGE and (found := declared(Statement(self.line, tokens))) is not None:
            self.locals[-1][found.name.upper()] = self._made(found)
        elif tokens[1:2] and tokens[1] in {".", "{", ":="} and ":=" in tokens:
            equals = tokens.index(":=")
            self.assign(tokens[:equals], self.value(tokens[equals + 1 :]))
        else:
            arguments, options = instruction(tokens[1:])
            if not self.is_known(tokens[0], arguments, options):
                if options:
                    raise ProgramError(f"{tokens[0]} is unknown")
                self.routine(tokens[0], arguments)

    def is_known(self, name: str, arguments: list[list[str]], options: dict[str, list[str]]) -> bool:
        """Execute an instruction, and tell whether there is one of this name."""
        name = name.upper()
        motion = MOTION.fullmatch(name)
        if motion is not None:
            self._move(arguments, options, motion)
            return True
        function = getattr(self, f"_do_{name.lower()}", None)
        if function is not None:
            function(arguments, options)
        self._only(options, USUAL.get(name, set(options)), name)
        return function is not None or name in HARMLESS

    def _only(self, options: dict[str, Any], allowed: set[str], name: str) -> None:
        if extra := set(options) - allowed:
            raise ProgramError(f"{name} with \\{extra.pop()} is unknown")

    def _known(self, tokens: list[str], kind: str) -> Any:
        """Return data of a kind; what no module declares is that of the controller."""
        if kind in self.undeclared and len(tokens) == 1 and self.find(tokens[0]) is None:
            return self.undeclared[kind]
        value = self.value(tokens)
        return typed(kind, value)

    def _placed(self, tool: list[str], options: dict[str, list[str]], speed: list[str] | None) -> tuple[Matrix, Matrix]:
        """Return the frame of targets and T_flange_tool, and say both to the machine."""
        wobj = options.get("WOBJ", ["wobj0"])
        at = self.machine.at
        mm_s = None if speed is None else self._known(speed, "speeddata").values[0]
        frame = self.T_of_frame(self._known(wobj, "wobjdata")) @ self.shift
        mark = "".join(options.get("ID", ()))
        if mark and not self.is_in_step:
            raise ProgramError("a move in step before SyncMoveOn")
        self.machine.at = Place(at.file, at.line, "".join(tool), "".join(wobj), mm_s, mark=mark)
        return frame, self.T_of_tool(self._known(tool, "tooldata"))

    def _move(self, arguments: list[list[str]], options: dict[str, Any], motion: re.Match[str]) -> None:
        name, (word, kind, part) = motion[0], [group for group in motion.groups() if group is not None]
        self._only(options, ARCS if word == "ARC" else MOVES, name)
        if len(arguments) != COUNTS[word] + (kind == "C"):
            raise ProgramError(f"{name} with {len(arguments)} arguments")
        *points, speed = arguments[: 3 if kind == "C" else 2]
        zone, tool = arguments[-2:]
        frame, T_tool = self._placed(tool, options, speed)
        self._zone(zone)
        *via, goal = (frame @ matrix(self._target(tokens, "robtarget")) for tokens in points)
        if via:
            self.machine.arc(via[0], goal, T_tool)
        else:
            self.machine.move(goal, T_tool, is_line=kind == "L")
        if part:
            self.machine.switch(Does.ON if part == "START" else Does.OFF)

    def _target(self, tokens: list[str], kind: str) -> Record:
        """Return a target, and say where it brings the external axes that the robot has."""
        target: Record = self._known(tokens, kind)
        external = tuple(v for v in target.values[-1].values if v != NO_AXIS)
        self.machine.at = replace(self.machine.at, external=external)
        return target

    def _zone(self, zone: list[str]) -> None:
        """Say where the tool leaves the path: the largest of the sizes in mm."""
        self.is_fine, *sizes = self._known(zone, "zonedata").values
        self.machine.at = replace(self.machine.at, blends=not self.is_fine, zone=(max(sizes[:3]), WHOLE_ZONE))

    def _do_moveabsj(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, MOVES | {"NOEOFFS"}, "MoveAbsJ")
        if len(arguments) != 4:
            raise ProgramError(f"MoveAbsJ with {len(arguments)} arguments")
        joints, speed, zone, tool = arguments
        self._placed(tool, options, speed)
        self._zone(zone)
        target = self._target(joints, "jointtarget")
        self.machine.joint_move(np.array(target.values[0].values, dtype=np.float64))

    _do_arcmoveabsj = _do_moveabsj

    def _step(self, arguments: list[list[str]], options: dict[str, Any], *, on: bool) -> None:
        self.is_in_step = on

    _do_syncmoveon, _do_syncmoveoff = partialmethod(_step, on=True), partialmethod(_step, on=False)

    def _do_pdispset(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, set(), "PDispSet")
        self.shift = matrix(self._known(arguments[0], "pose"))

    def _do_pdispoff(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self.shift = np.eye(4)

    def _do_pdispon(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"ROT", "EXEP", "WOBJ"}, "PDispOn")
        target, tool = arguments
        self.shift = np.eye(4)
        frame, T_tool = self._placed(tool, options, None)
        planned = matrix(self._known(target, "robtarget"))
        now = inverse_pose(frame) @ self.machine.reading(T_tool)
        if "EXEP" in options:
            now = matrix(self._known(options["EXEP"], "robtarget"))
        if "ROT" in options:
            self.shift = now @ inverse_pose(planned)
        else:
            self.shift[:3, 3] = now[:3, 3] - planned[:3, 3]

    def _do_searchl(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"STOP", "PSTOP", "SSTOP", "FLANKS", "POSFLANK", "NEGFLANK", "WOBJ"}, "SearchL")
        if not {"STOP", "PSTOP", "SSTOP"} & set(options):
            raise ProgramError("SearchL without a stop drives on through the part")
        signal, found, goal, speed, tool = arguments
        if len(signal) != 1 or signal[0].upper() not in self.signals:
            raise ProgramError(f"SearchL: the signal {' '.join(signal)} is not configured")
        speed_mm_s = self.value(speed).values[0]
        if "STOP" in options and speed_mm_s > STOP_LIMIT_MM_S:
            raise ProgramError("SearchL\\Stop above 100 mm/s")
        if not self.is_fine:
            raise ProgramError("the move before a search does not end in a fine point")
        if "FLANKS" not in options:
            self._require_edge(signal[0].upper(), 0 if "NEGFLANK" in options else 1)
        target = self._known(goal, "robtarget")
        frame, T_tool = self._placed(tool, options, speed)
        hit = self.machine.search(frame @ matrix(target), T_tool, speed_mm_s)
        if hit is None:
            raise RapidError("ERR_WHLSEARCH")
        self.assign(found, self._at(inverse_pose(frame) @ hit, target))

    def _require_edge(self, signal: str, wanted: int) -> None:
        if self.input(signal) == wanted:
            raise RapidError("ERR_SIGSUPSEARCH")
        if wanted != self.signals[signal]:
            raise ProgramError("the search waits for the wrong edge of the signal")

    def _do_search_1d(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        """SmarTac: to the start, then through the search point up to twice its distance; 3HAC024845."""
        self._only(options, {"NOTOFF", "WIRE", "SEARCHSTOP", "WOBJ", "SEARCHNAME"}, "Search_1D")
        result, begin, through, speed, tool = arguments
        del speed  # of the move to the start; searches have that of the configuration
        frame, T_tool = self._placed(tool, options, None)
        start, point = matrix(self.value(begin)), matrix(self.value(through))
        self.machine.move(frame @ start, T_tool)
        if self.machine.is_on():
            self._smartac("touch at start")
            return
        goal = point.copy()
        goal[:3, 3] += point[:3, 3] - start[:3, 3]
        hit = self.machine.search(frame @ goal, T_tool, 20.0)
        if hit is None:
            self._smartac("no touch")
            return
        seen = inverse_pose(frame) @ hit
        if (stop := options.get("SEARCHSTOP")) is not None:
            self.assign(stop, self._at(seen, self.value(through)))
        moved = [[float(v) for v in seen[:3, 3] - point[:3, 3]], [1, 0, 0, 0]]
        self.assign(result, typed("pose", moved))

    def _at(self, T: Matrix, like: Record) -> Any:
        """Return a target elsewhere, with the configuration and the axes of another."""
        return typed("robtarget", [*pose_values(T), *(nested(v) for v in like.values[2:])])

    def _smartac(self, fault: str) -> None:
        """The package shows a menu of its own: here the operator chooses RETURN, which leaves the default result."""
        self.run.stop(f"SmarTac: {fault}", self.on_stop)

    def _output(self, arguments: list[list[str]], *, value: Any) -> None:
        name = arguments[0][0].upper()
        self.run.outputs[name] = bool(value)
        self.machine.output(name, value)

    def _do_setdo(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"SYNC"}, "SetDO")
        self._output(arguments, value=self.value(arguments[1]))

    def _switch(self, arguments: list[list[str]], options: dict[str, Any], *, value: int) -> None:
        self._output(arguments, value=value)

    _do_set, _do_reset = partialmethod(_switch, value=1), partialmethod(_switch, value=0)

    def _do_waittime(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"INPOS"}, "WaitTime")
        if self.value(arguments[0]) < 0:
            raise ProgramError("WaitTime below 0")

    def _do_tpwrite(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"NUM", "BOOL", "POS", "ORIENT"}, "TPWrite")
        text = self.value(arguments[0])
        if not isinstance(text, str) or len(text) > LINE_LENGTH:
            raise ProgramError(f"TPWrite takes a text of {LINE_LENGTH} characters: {text!r}")
        self.run.messages.append(text + "".join(printed(self.value(tokens)) for tokens in options.values()))

    def _do_errwrite(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"W", "I", "RL2", "RL3", "RL4"}, "ErrWrite")
        texts = [self.value(tokens) for tokens in [*arguments, *(t for t in options.values() if t)]]
        if any(len(text) > EVENT_LENGTH for text in texts):
            raise ProgramError(f"ErrWrite takes {EVENT_LENGTH} characters: {texts}")
        self.run.messages.append(" ".join(texts))

    def _do_stop(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"NOREGAIN", "ALLMOVETASKS"}, "Stop")
        self.run.stop(self.run.messages[-1] if self.run.messages else "", self.on_stop)

    def _do_stopmove(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, set(), "StopMove, ClearPath, StartMove")

    _do_clearpath = _do_startmove = _do_stopmove

    def _do_raise(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        raise RapidError(self.errors[-1])

    def _leave(self, arguments: list[list[str]], options: dict[str, Any], *, how: type[Exception]) -> None:
        raise how

    _do_trynext, _do_retry = partialmethod(_leave, how=TryNextError), partialmethod(_leave, how=RetryError)

    def _do_exit(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        raise StoppedError("EXIT")

    def _do_save(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"FILEPATH", "FILE", "TASKREF", "TASKNAME"}, "Save")
        module = self.value(arguments[0])
        named = [options[key] for key in ("FILE", "FILEPATH") if key in options]
        path = self.value(named[0]) if named else f"{module}.mod"
        self.run.files[path.rsplit("/", 1)[-1]] = self.saved(module)

    def saved(self, module: str) -> str:
        """Return a module with the present values of its PERS data."""
        text = self.texts.get(module.upper())
        if text is None:
            raise ProgramError(f"Save: the module {module} is not loaded")

        def with_value(match: re.Match[str]) -> str:
            data = self.find(match["name"])
            assert data is not None
            return f"{match['head']}:={printed(data.value)};"

        declaration = r'(?P<head>\bPERS\s+\w+\s+(?P<name>\w+)(?:\{\d+\})?)\s*:=(?:"[^"]*"|[^;"])*;'
        return re.sub(declaration, with_value, text, flags=re.IGNORECASE)
