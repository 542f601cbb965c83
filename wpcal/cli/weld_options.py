"""Options about weld data: the table of rules, the file of weld data, and whether the arc burns."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import option

if TYPE_CHECKING:
    from collections.abc import Mapping

    from wpcal.controllers.arc_settings import ArcSettings
    from wpcal.results.folder import FinishedCalibration
    from wpcal.seam.seam import Seam
    from wpcal.weld.rules import RuleTable
    from wpcal.weld.seam_weld import SeamWeld


@dataclass(frozen=True, slots=True, kw_only=True)
class WeldRuleFlags:
    """Which table of rules gives weld data."""

    weld_rules: Path | None = option(
        "--weld-rules",
        metavar="RULES.toml",
        type=click.Path(path_type=Path),
        help="Your table of weld data by joint, thickness and position.  [default: that of wpcal]",
    )

    def read(self) -> RuleTable:
        """Return the table.

        Raises
        ------
        InputError
            When the file cannot be used.
        """
        from wpcal.weld.rules import read_rules, shipped_rules

        return shipped_rules() if self.weld_rules is None else read_rules(self.weld_rules)


@dataclass(frozen=True, slots=True, kw_only=True)
class ArcFlags:
    """The weld data of a program, and whether it switches the arc."""

    welds: Path | None = option(
        "--welds",
        metavar="WELDS.json",
        type=click.Path(path_type=Path),
        help="Weld data of `wpcal welds`: speeds, angles, passes, stitches, and what --arc on writes.",
    )
    rules: WeldRuleFlags
    arc: str = option(
        "--arc",
        type=click.Choice(["off", "on"]),
        default="off",
        show_default=True,
        help="Write arc instructions; off is a dry run without them. On needs --welds.",
    )
    arc_output: int | None = option(
        "--arc-output",
        metavar="N",
        type=click.IntRange(min=0),
        help="Digital output that switches the arc, for KUKA without ArcTech, Universal Robots, Staubli.  "
        "[default: functions of yours, arc_start and arc_end]",
    )

    def read(
        self, finished: FinishedCalibration, chosen: FinishedCalibration
    ) -> tuple[Mapping[str, SeamWeld] | None, ArcSettings | None]:
        """Return the weld data of the chosen seams, and how the arc is switched; None for what is not asked for.

        Parameters
        ----------
        finished, chosen : FinishedCalibration
            With all seams, and with those of the program.

        Raises
        ------
        InputError
            When the file cannot be used, names an unknown seam, or is missing with ``--arc on``.
        """
        from wpcal.weld.find import find_welds
        from wpcal.weld.record import read_stated_welds

        arc = self._settings()
        if self.welds is None:
            return None, None
        table = self.rules.read()
        found = find_welds(
            finished.seams,
            finished.T_base_part,
            table,
            part_glb=finished.part_glb,
            stated=read_stated_welds(self.welds, table),
            names={seam.name for seam in chosen.seams},
            stated_in=str(self.welds),
        )
        for note in found.notes:
            click.echo(f"wpcal: {self.welds}: {note}", err=True)
        return found.by_seam(), arc

    def read_held(
        self, seams: Mapping[str, Seam], name: str, part_glb: Path, position: str
    ) -> tuple[SeamWeld | None, ArcSettings | None]:
        """Return the weld data of one seam of a part that a robot holds, and how the arc is switched.

        Parameters
        ----------
        seams : mapping of str to Seam
            All seams, in `part`.
        name : str
            Of the seam.
        part_glb : Path
            The triangles of the part, if there is such a file.
        position : str
            The weld position that the plan gives the seam; ``-`` for none.

        Raises
        ------
        InputError
            As `read` does.
        """
        from wpcal.core.input_file import read_bytes
        from wpcal.core.transform import RigidTransform
        from wpcal.weld.find import find_welds
        from wpcal.weld.record import read_stated_welds

        arc = self._settings()
        if self.welds is None:
            return None, None
        table = self.rules.read()
        found = find_welds(
            list(seams.values()),
            RigidTransform.identity(target="base", source="part"),
            table,
            part_glb=read_bytes(part_glb) if part_glb.is_file() else None,
            stated=read_stated_welds(self.welds, table),
            names={name},
            stated_in=str(self.welds),
            positions={} if position == "-" else {name: (position, "plan.json")},
        )
        for note in found.notes:
            click.echo(f"wpcal: {self.welds}: {note}", err=True)
        return found.by_seam()[name], arc

    def _settings(self) -> ArcSettings | None:
        """Return how the arc is switched; None for a dry run.

        Raises
        ------
        InputError
            When it is asked for without weld data.
        """
        from wpcal.controllers.arc_settings import ArcSettings
        from wpcal.core.errors import ErrorCode, InputError

        if self.arc != "on":
            return None
        if self.welds is None:
            what = "arc instructions need weld data; write them with wpcal welds, check them, and give the file"
            raise InputError(what, code=ErrorCode.WELDS_MISSING)
        return ArcSettings(self.arc_output)
