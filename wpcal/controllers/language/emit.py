"""The order of a weld program, which all languages share; a language says how each part is written."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import ClassVar

from wpcal.controllers.language.naming import NameRules, comment_lines, safe_name, safe_names
from wpcal.controllers.language.post import AirMoves, Post
from wpcal.controllers.program import WeldPath, WeldProgram
from wpcal.controllers.program.arc import ArcSettings, end_time_s, has_weave, refuse
from wpcal.controllers.program.describe import describe, describe_path
from wpcal.core.errors import InputError
from wpcal.robot.moves import Arc

Instructions = Callable[[], Sequence[str]]


@dataclass(frozen=True, slots=True)
class Around:
    """What is before and after the moves along a seam."""

    on: Instructions = list  #: That switch the arc on.
    off: Instructions = list
    start: Mapping[str, object] = field(default_factory=dict)  #: More names of the template `weld_start`.
    end: Mapping[str, object] = field(default_factory=dict)  #: The same of `weld_end`.
    before: Sequence[str] = ()  #: Lines before the first template.
    after: Sequence[str] = ()  #: Lines after the second.


NOTHING = Around()


class WeldWriter(AirMoves):
    """Writes one weld program."""

    format: ClassVar[str]  #: The name of the format.
    names: ClassVar[NameRules]
    longest_comment: ClassVar[int]
    zone_mm: ClassVar[float]  #: Distance from a corner at which the tool may leave the path.
    #: Whether an air move leads to the first point of a seam; otherwise the template `weld_start` has this move.
    starts_in_air: ClassVar[bool] = True
    #: Whether a seam is a routine of its own, to which the last joint move of a plan before it belongs: the seam can
    #: then be run alone.
    calls_seams: ClassVar[bool] = True
    sets_tool: ClassVar[bool] = False  #: Whether programs can set the tool data.
    stems: dict[str, str]  #: The names of the seams here.
    post: Post

    def __init__(self, program: WeldProgram) -> None:
        self.program, self.planned, self.air_mm_s = program, program.planned, program.motion.air_speed_mm_s
        if program.tool_data is not None and not self.sets_tool:
            raise InputError(f"{self.names.language}: programs do not set the tool data (--set-tool): type them in")
        self.post = Post(self.format, program)

    def own_names(self, room: int) -> tuple[str, dict[str, str]]:
        """Return the name of the program, and those of its seams, which leave room for this many characters."""
        main = safe_name(self.program.controller.program_name, self.names)
        rules = replace(self.names, keywords=f"{self.names.keywords} {main.lower()}")
        return main, safe_names([path.seam.name for path in self.program.paths], rules, room=room)

    def labels(self, path: WeldPath) -> list[str]:
        """Return the names of the points of a path."""
        return path.labels(self.stems[path.seam.name], width=self.program.label_width)

    def zone(self, number: int) -> tuple[float, float]:
        """Return the zone of the joint move of this number, mm and as a share of it; zeros where it stops."""
        return (0.0, 0.0) if self.planned is None else self.planned.zone(number)

    def joint_move(self, number: int) -> list[str]:
        """Return the move to the joints of this number, from 1 on, of a plan."""
        raise NotImplementedError

    def weld_move(self, path: WeldPath, via: str, to: str, *, stops: bool, is_last: bool) -> list[str]:
        """Return a move along a seam: an arc if it has a point `via`."""
        raise NotImplementedError

    def comments(self, lines: Sequence[str], mark: str = "") -> list[str]:
        """Return lines wrapped for this language."""
        return comment_lines(lines, mark=mark, longest=self.longest_comment)

    def about(self, text: Sequence[str]) -> list[str]:
        """Return the comments of the header: what all languages say, `text`, and the names of the seams here."""
        seams = [
            f"  {(name := path.seam.name)} -> {self.stems[name]}: {describe_path(path)}" for path in self.program.paths
        ]
        return self.comments([*describe(self.program), *text, "seam -> name here", *seams])

    def between(self) -> list[tuple[list[str], list[str]]]:
        """Return the joint moves before each seam and after the last; those that belong to the seam's routine apart."""
        if self.planned is None:
            return [([], [])] * (len(self.program.paths) + 1)
        found = []
        for row, (_, (_, numbers)) in enumerate(zip(self.planned.air, self.planned.numbered(), strict=False)):
            moves = [self.joint_move(number) for number in numbers]
            cut = -1 if self.calls_seams and row < len(self.program.paths) else len(moves)
            before, last = ([line for move in part for line in move] for part in (moves[:cut], moves[cut:]))
            found.append((before, last))
        return found

    def alone(self, row: int, seam: Sequence[str]) -> list[str]:
        """Return the lines of a routine that welds the seam of this row from home and goes home; none without ways.

        `seam`: The lines that call the routine of the seam, which goes to its approach.
        """
        planned = self.planned
        if planned is None or not planned.ways or not len(planned.ways[row][0]):
            return []
        first = len(planned.air) + 2 * row
        to, back = ([self.joint_move(one) for one in numbers] for _, numbers in list(planned.numbered())[first:][:2])
        return [*(line for move in to for line in move), *seam, *(line for move in back for line in move)]

    def way_to(self, path: WeldPath, points: Sequence[str]) -> list[str]:
        """Return the moves to a seam; a plan has gone to its approach in the joints."""
        lines = list[str]()
        if self.planned is None:
            is_joint = self.program.safe_point is None
            lines += self.post.air_move(points[0], speed=self.first if is_joint else self.air, joint=is_joint)
        return lines + self.air_moves(points[1 : path.weld_rows.start + self.starts_in_air])

    def seam(self, path: WeldPath, points: Sequence[str], around: Around = NOTHING) -> list[str]:
        """Return the moves to a seam, along it and from it; `points` as moves name the poses of the path."""
        along = points[path.weld_rows]
        point = {} if self.starts_in_air else {"point": along[0]}
        return [
            *self.post.hook("before_weld", path),
            *self.way_to(path, points),
            *around.before,
            *self.post.weld_start(path, around.on, **point, **around.start),
            *self.weld_moves(path, along),
            *self.post.weld_end(path, around.off, **around.end),
            *around.after,
            *self.air_moves(points[path.weld_rows.stop :]),
            *self.post.hook("after_weld", path),
        ]

    def run(self, lines: Sequence[str]) -> list[str]:
        """Return the lines of a run with what a shop does around it."""
        return [*self.post.hook("before_run"), *lines, *self.post.hook("after_run")]

    def weld_moves(self, path: WeldPath, along: Sequence[str]) -> list[str]:
        """Return the moves along a seam, whose points are `along`."""
        lines, moves = list[str](), path.weld_moves
        for number, (move, stops) in enumerate(zip(moves, path.stops(self.zone_mm), strict=True), 1):
            via = along[move.via] if isinstance(move, Arc) else ""
            lines += self.weld_move(path, via, along[move.to], stops=stops, is_last=number == len(moves))
        return lines


NO_WEAVE = "the language has no weave; give --weave points, or state null"


@dataclass(frozen=True, slots=True)
class ArcSwitch:
    """How a language without arc instructions switches the arc: by an output, or two functions that the user has."""

    language: str  #: For messages.
    start: str  #: The call of a function; ``{job}`` is the job.
    end: str
    on: str  #: The instruction that sets the output ``{output}``.
    off: str
    wait: str  #: The instruction that waits for ``{seconds}`` or ``{milliseconds}``.
    by_output: str  #: How the header says that the output ``{output}`` switches the arc ...
    by_calls: str  #: ... or the functions.
    indent: str = "  "
    stand: Sequence[str] = ()  #: Instructions before the switch, which wait until the torch stands.
    no_weave: str = NO_WEAVE

    def in_words(self, arc: ArcSettings | None) -> str:
        """Say for the header what switches the arc."""
        if arc is None:
            return "the arc burns from ARC ON to ARC OFF"
        return self.by_calls if arc.output is None else self.by_output.format(output=arc.output)

    def around(self, path: WeldPath, arc: ArcSettings | None, before: Sequence[str] = ()) -> Around:
        """Return what is around a seam; a weave in the weld data is refused when it is written."""
        if arc is None:
            return Around(before=before)
        return Around(partial(self._start, path, arc), partial(self._end, path, arc), before=before)

    def _start(self, path: WeldPath, arc: ArcSettings) -> list[str]:
        if has_weave(path):
            raise refuse(path, "weave", language=self.language, why=self.no_weave)
        call = self.start if arc.output is None else self.on
        switch = call.format(job=path.values.job or 0, output=arc.output)
        return [*self.stand, f"{self.indent}{switch}", *self._wait(path.values.start_delay_s or 0.0)]

    def _end(self, path: WeldPath, arc: ArcSettings) -> list[str]:
        switch = (self.end if arc.output is None else self.off).format(output=arc.output)
        return [*self.stand, *self._wait(end_time_s(path)), f"{self.indent}{switch}"]

    def _wait(self, seconds: float) -> list[str]:
        times = {"seconds": f"{seconds:g}", "milliseconds": f"{1e3 * seconds:g}"}
        return [f"{self.indent}{self.wait.format(**times)}"] if seconds > 0.0 else []
