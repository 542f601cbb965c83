"""Instructions of RAPID that touch programs use."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

from tests.touch_robots.rapid_data import Record, matrix, printable, printed, typed, values_of
from tests.touch_robots.rapid_text import Data
from tests.touch_robots.robot import Array, Robot
from wpcal.controllers.run.machine import inverted
from wpcal.controllers.run.program import ProgramError, Run, StoppedError

STOP_LIMIT_MM_S = 100.0
"""`SearchL\\Stop` is only allowed below this speed."""
LINE_LENGTH, EVENT_LENGTH = 80, 46  #: Characters that TPWrite and ErrWrite take.


class RapidError(Exception):
    """An error that a handler may take."""


class TryNextError(Exception):
    """TRYNEXT in a handler."""


class RetryError(Exception):
    """RETRY in a handler."""


class ReturnError(Exception):
    """RETURN."""


class Instructions:
    """What the instructions do; the controller knows names and values."""

    robot: Robot
    run: Run
    signal: str
    level: int
    on_stop: Callable[[str], bool]
    is_fine: bool
    errors: list[str]
    data: dict[str, Data]
    texts: dict[str, str]

    def value(self, tokens: Any) -> Any:
        raise NotImplementedError

    def assign(self, tokens: list[str], value: Any) -> None:
        raise NotImplementedError

    def input(self) -> int:
        return self.level if self.robot.is_on() else 1 - self.level

    def tool(self, tool: Record) -> Array:
        if tool.kind != "tooldata" or tool.values[0] is not True or tool.values[2].values[0] <= 0:
            raise ProgramError("the tool is not held by the robot, or weighs nothing")
        return matrix(tool.values[1])

    def frame(self, wobj: Record) -> Array:
        if wobj.kind != "wobjdata" or wobj.values[0] is not False or wobj.values[1] is not True:
            raise ProgramError("the work object is held by the robot, or its user frame moves")
        return matrix(wobj.values[3]) @ matrix(wobj.values[4])

    def _only(self, options: dict[str, Any], allowed: set[str], name: str) -> None:
        if extra := set(options) - allowed:
            raise ProgramError(f"{name} with \\{extra.pop()} is unknown")

    def _move(self, arguments: list[list[str]], options: dict[str, Any], name: str) -> None:
        self._only(options, {"WOBJ"}, name)
        target, speed, zone, tool = (self.value(tokens) for tokens in arguments)
        if (target.kind, speed.kind, zone.kind) != ("robtarget", "speeddata", "zonedata"):
            raise ProgramError(f"{name}: {target.kind}, {speed.kind}, {zone.kind}")
        wobj = self.value(options["WOBJ"]) if "WOBJ" in options else self.data["WOBJ0"].value
        self.is_fine = zone.values[0]
        self.robot.move(self.frame(wobj) @ matrix(target), self.tool(tool), is_line=name == "MoveL")

    def _do_movel(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._move(arguments, options, "MoveL")

    def _do_movej(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._move(arguments, options, "MoveJ")

    def _do_moveabsj(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"WOBJ", "NOEOFFS"}, "MoveAbsJ")
        joints, speed, zone, tool = (self.value(tokens) for tokens in arguments)
        if (typed("jointtarget", joints).kind, speed.kind, zone.kind, tool.kind)[1:] != (
            "speeddata",
            "zonedata",
            "tooldata",
        ):
            raise ProgramError("MoveAbsJ with wrong arguments")
        self.is_fine = zone.values[0]
        self.robot.joint_move()

    def _do_searchl(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"STOP", "PSTOP", "SSTOP", "FLANKS", "POSFLANK", "NEGFLANK", "WOBJ"}, "SearchL")
        if not {"STOP", "PSTOP", "SSTOP"} & set(options):
            raise ProgramError("SearchL without a stop drives on through the part")
        signal, found, goal, speed, tool = arguments
        if len(signal) != 1 or signal[0].upper() != self.signal:
            raise ProgramError(f"SearchL: the signal {' '.join(signal)} is not configured")
        speed_mm_s = self.value(speed).values[0]
        if "STOP" in options and speed_mm_s > STOP_LIMIT_MM_S:
            raise ProgramError("SearchL\\Stop above 100 mm/s")
        if not self.is_fine:
            raise ProgramError("the move before a search does not end in a fine point")
        if "FLANKS" not in options:
            wanted = 0 if "NEGFLANK" in options else 1
            if self.input() == wanted:
                raise RapidError("ERR_SIGSUPSEARCH")
            if wanted != self.level:
                raise ProgramError("the search waits for the wrong edge of the signal")
        wobj = self.value(options["WOBJ"]) if "WOBJ" in options else self.data["WOBJ0"].value
        target = self.value(goal)
        frame, T_tool = self.frame(wobj), self.tool(self.value(tool))
        hit = self.robot.search(frame @ matrix(target), T_tool, speed_mm_s)
        if hit is None:
            raise RapidError("ERR_WHLSEARCH")
        place = typed("robtarget", [*values_of(inverted(frame) @ hit), *([printable(v) for v in target.values[2:]])])
        self.assign(found, place)

    def _do_search_1d(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        """SmarTac: to the start, then through the search point up to twice its distance; 3HAC024845."""
        self._only(options, {"NOTOFF", "WIRE", "SEARCHSTOP", "WOBJ", "SEARCHNAME"}, "Search_1D")
        result, begin, through, speed, tool = arguments
        del speed  # of the move to the start; searches have that of the configuration
        wobj = self.value(options["WOBJ"]) if "WOBJ" in options else self.data["WOBJ0"].value
        frame, T_tool = self.frame(wobj), self.tool(self.value(tool))
        start, point = matrix(self.value(begin)), matrix(self.value(through))
        self.robot.move(frame @ start, T_tool)
        if self.robot.is_on():
            self._smartac("touch at start")
            return
        goal = point.copy()
        goal[:3, 3] += point[:3, 3] - start[:3, 3]
        hit = self.robot.search(frame @ goal, T_tool, 20.0)
        if hit is None:
            self._smartac("no touch")
            return
        seen = inverted(frame) @ hit
        if (stop := options.get("SEARCHSTOP")) is not None:
            rest = [printable(v) for v in self.value(through).values[2:]]
            self.assign(stop, typed("robtarget", [*values_of(seen), *rest]))
        moved = [[float(v) for v in seen[:3, 3] - point[:3, 3]], [1, 0, 0, 0]]
        self.assign(result, typed("pose", moved))

    def _smartac(self, fault: str) -> None:
        """The package shows a menu of its own: here the operator chooses RETURN, which leaves the default result."""
        self.run.stop(f"SmarTac: {fault}", self.on_stop)

    def _do_setdo(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"SYNC"}, "SetDO")
        self.run.outputs[arguments[0][0].upper()] = bool(self.value(arguments[1]))

    def _do_set(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self.run.outputs[arguments[0][0].upper()] = True

    def _do_reset(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self.run.outputs[arguments[0][0].upper()] = False

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

    def _do_tperase(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        pass

    def _do_errwrite(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"W", "I", "RL2", "RL3", "RL4"}, "ErrWrite")
        texts = [self.value(tokens) for tokens in [*arguments, *(t for t in options.values() if t)]]
        if any(len(text) > EVENT_LENGTH for text in texts):
            raise ProgramError(f"ErrWrite takes {EVENT_LENGTH} characters: {texts}")
        self.run.messages.append(" ".join(texts))

    def _do_stop(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"NOREGAIN", "ALLMOVETASKS"}, "Stop")
        self.run.stop(self.run.messages[-1] if self.run.messages else "", self.on_stop)

    def _do_exit(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        raise StoppedError("EXIT")

    def _do_stopmove(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, set(), "StopMove, ClearPath, StartMove")

    _do_clearpath = _do_startmove = _do_stopmove

    def _do_raise(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        raise RapidError(self.errors[-1])

    def _do_trynext(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        raise TryNextError

    def _do_retry(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        raise RetryError

    def _do_return(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        raise ReturnError

    def _do_confl(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"ON", "OFF"}, "ConfL")

    _do_confj = _do_confl

    def _do_singarea(self, arguments: list[list[str]], options: dict[str, Any]) -> None:
        self._only(options, {"WRIST", "OFF"}, "SingArea")

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
            data = self.data[match["name"].upper()]
            return f"{match['head']}:={printed(data.value)};"

        declaration = r'(?P<head>\bPERS\s+\w+\s+(?P<name>\w+)(?:\{\d+\})?)\s*:=(?:"[^"]*"|[^;"])*;'
        return re.sub(declaration, with_value, text, flags=re.IGNORECASE)
