"""`wpcal teach`: one key reads the robot's position into a row, in a terminal."""

from __future__ import annotations

import sys
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import click

from cad.cli.pick_start import PickAsked, Started, pick_options, start
from wpcal.cli.option_groups import command

if TYPE_CHECKING:
    from collections.abc import Sequence

    from wpcal.robot.links.judge import Accepted
    from wpcal.robot.links.watch import Watch

WINDOW = "teach"  #: As which the table knows this command.
KEYS = "Enter: read, s: skip, u: undo, q: end"
FEWEST = 3  #: Points of a fit.
SHOWN_SEAMS = 6  #: As many errors are on one line, the largest first.


@command()
@pick_options
@click.pass_context
def teach(ctx: click.Context, /, **asked: Any) -> int:
    """Touch features of PART.step one after another; a key reads the position of the robot at --robot KIND:ADDRESS.

    Kinds are ur, fanuc, fanuc-ftp, kuka, abb, omnicore, opcua. Nothing is ever written to the robot. The features are
    those of TAUGHT that have no coordinates yet, and then those that lower the error of the seams most, until every
    seam is within the tolerance. Residuals and the error of the worst seam follow each key. A position is refused if
    the arm moves, the tool is not that of the row before, or the position is older than 0.5 s.

    The table is saved after each key, as by `wpcal pick`. Ends with code 1 unless the verdict is PASS.
    """
    from wpcal.core.errors import InputError
    from wpcal.robot.links.registry import installed_links

    found = start(ctx, PickAsked(**asked))
    if found.watch is None:
        raise InputError(f"teach needs --robot KIND:ADDRESS with KIND one of {', '.join(installed_links())}")
    click.echo(f"{found.robot}: read only. {KEYS}")
    teaching = Teaching(found)
    try:
        while teaching.step(found.watch):
            pass
    finally:
        found.watch.close()
        found.say_end()
    return 0 if teaching.verdict == "PASS" else 1


@dataclass(slots=True, eq=False)
class Teaching:
    """The rows while they are touched."""

    started: Started
    verdict: str = ""
    asked: tuple[str, ...] = ()  #: Features that the verdict asks for.
    again: tuple[int, ...] = ()  #: Rows that do not fit the others.
    skipped: set[str] = field(default_factory=set)
    done: list[int] = field(default_factory=list)  #: Rows in the order in which they were read here.

    def step(self, watch: Watch) -> bool:
        """Ask for one key and do what it says. Return whether to go on."""
        from wpcal.core.errors import WpcalError

        try:
            at = self._next()
        except WpcalError as error:
            click.echo(f"\n{error}")
            return False
        if at is None:
            return False
        name = self._cell(at, "name")
        click.echo(f"\ntouch {name}{self._where(self._cell(at, 'feature'))}  [{KEYS}]")
        key = _key()
        if key in ("q", ""):
            return False
        try:
            self._obey(key, at, watch)
        except WpcalError as error:
            click.echo(f"{name}: {error}")
        return True

    def _obey(self, key: str, at: int, watch: Watch) -> None:
        if key == "s":
            self.skipped.add(self._cell(at, "name"))
        elif key == "u" and self.done:
            self._write(self.done[-1], ("", "", ""), "")
            self.again = ()
            click.echo(f"{self._cell(self.done.pop(), 'name')}: taken back")
        elif key in ("\r", "\n", " "):
            self._take(at, watch.take())

    def _take(self, at: int, taken: Accepted) -> None:
        place = [f"{value:.3f}" for value in taken.T_base_tool.t_mm]
        self._write(at, place, taken.kept().to_text())
        self.done.append(at)
        click.echo(f"{self._cell(at, 'name')}: {'  '.join(place)}  ({taken.note})")
        self._show_fit()

    def _show_fit(self) -> None:
        """Say residuals, the error of the worst seam and the verdict, if there are points for a fit."""
        from wpcal.core.errors import WpcalError
        from wpcal.results.next_steps import AGAIN

        session, rows = self.started.session, self.started.table.rows
        self.verdict, self.asked, self.again = "", (), ()
        if len(rows.complete()) < FEWEST:
            return
        try:
            found = session.fit(rows)
        except WpcalError as error:
            click.echo(f"no fit yet: {error}")
            return
        self.verdict, self.again = found["verdict"], tuple(found["again"])
        self.asked = tuple(found["judgement"]["next_points"])
        residuals = ", ".join(f"{point['name']} {point['distance_mm']:.3f}" for point in found["points"])
        click.echo(f"residuals, mm: {residuals}")
        self._show_errors(found["u95_mm"])
        click.echo(f"{self.verdict} for a tolerance of {found['tolerance_mm']:g} mm")
        if self.again or not (self.asked or self._waiting()):
            for text in found["steps"]:
                if text != AGAIN:
                    click.echo(f"  {text}")

    def _show_errors(self, u95_mm: Sequence[Sequence[float]]) -> None:
        seams = zip(self.started.session.part.seams, u95_mm, strict=True)
        errors = [(max(u95), seam.name) for seam, u95 in seams if seam.accepted and u95]
        if errors:
            largest = ", ".join(f"{seam} {error:.3f}" for error, seam in sorted(errors, reverse=True)[:SHOWN_SEAMS])
            click.echo(f"95 % errors of the seams, mm: {largest}{' …' if len(errors) > SHOWN_SEAMS else ''}")

    def _next(self) -> int | None:
        """Return the row to touch next: one without coordinates, else a new one that helps; None if it is enough."""
        for row in (*self.again, *self._waiting()):
            if self._cell(row, "name") not in self.skipped:
                return row
        if self.verdict == "PASS":
            click.echo("\nenough: all seams are within the tolerance")
            return None
        cells = self.started.table.rows.cells
        names = [name for name in self.asked if name not in self.skipped][:1] or self._suggested()
        if not names:
            return None
        self._keep([*cells, *(self._new(name) for name in names)])
        return len(cells)

    def _suggested(self) -> list[str]:
        """Return the features that lower the error most, where no verdict asks for any."""
        found = self.started.session.suggest(self.started.table.rows)
        names = [name for name in found["features"] if name not in self.skipped]
        error = f"{found['error_95_mm']:.3f} mm"
        if names:
            click.echo(
                f"\nnext: {', '.join(names)}; then the largest 95 % error of a seam is {error} on {found['seam']}"
            )
        else:
            click.echo(f"\nno further point lowers the error of {found['seam']}: {error}")
        return names

    def _new(self, name: str) -> tuple[str, ...]:
        given = {"name": name, "feature": name, "use": "yes"}
        return tuple(given.get(column, "") for column in self.started.table.rows.columns)

    def _waiting(self) -> list[int]:
        complete = set(self.started.table.rows.complete())
        return [row for row in range(len(self.started.table.rows.cells)) if row not in complete]

    def _where(self, feature: str) -> str:
        from wpcal.touch.advice import where_it_is

        for item in self.started.session.part.touchables:
            if item.feature.name == feature:
                return f", {where_it_is(item.feature)}"
        return ""

    def _cell(self, row: int, column: str) -> str:
        rows = self.started.table.rows
        return rows.cells[row][rows.columns.index(column)] if column in rows.columns else ""

    def _write(self, row: int, place: Sequence[str], reading: str) -> None:
        """Put coordinates and what the robot told into a row, and save."""
        from wpcal.core.readings import READING
        from wpcal.taught.columns import TAUGHT_COLUMNS

        rows = self.started.table.rows
        columns = rows.columns if READING in rows.columns else (*rows.columns, READING)
        cells = [[*each, ""][: len(columns)] for each in rows.cells]
        for column, text in zip((*TAUGHT_COLUMNS, READING), (*place, reading), strict=True):
            cells[row][columns.index(column)] = text
        self._keep([tuple(each) for each in cells], columns)
        if self.started.table.rows.complete():
            self.started.table.save(revision=self._revision(), window=WINDOW)

    def _keep(self, cells: Sequence[tuple[str, ...]], columns: tuple[str, ...] = ()) -> None:
        from cad.pick.draft import Keyed
        from cad.session.rows import Rows
        from wpcal.core.errors import InputError

        table, revision = self.started.table, self._revision()
        keyed = Keyed.of_rows(Rows(columns or table.rows.columns, tuple(cells)))
        kept = table.keep(keyed, revision=revision, window=WINDOW, number=revision)
        if kept.get("is_stale"):
            raise InputError("another window changed the table just now; once more")

    def _revision(self) -> int:
        return int(self.started.table.changes_since(-1)["revision"])


def _key() -> str:
    """Return the key that was pressed; without a terminal, what a line begins with; empty at the end of input."""
    if sys.stdin.isatty():
        try:
            return click.getchar().lower()
        except (KeyboardInterrupt, EOFError):
            return "q"
    return sys.stdin.readline()[:1].lower()
