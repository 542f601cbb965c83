"""Options about weld data: the table of rules, the file of weld data, and whether the arc burns."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.core.options import group, opt

if TYPE_CHECKING:
    from collections.abc import Collection, Mapping, Sequence

    from wpcal.controllers.program.arc import ArcSettings
    from wpcal.core.transform import RigidTransform
    from wpcal.seam.seam import Seam
    from wpcal.weld.rules import RuleTable
    from wpcal.weld.runs import RunChoice
    from wpcal.weld.seam_weld import SeamWeld


@dataclass(frozen=True, slots=True, kw_only=True)
class WeldRulesAsked:
    """Which table of rules gives weld data."""

    weld_rules: Path | None = opt(
        None,
        "Your table of weld data by joint, thickness and position.  [default: that of wpcal]",
        metavar="RULES.toml",
    )

    def read(self) -> RuleTable:
        """Return the table. Raises `InputError` when the file cannot be used."""
        from wpcal.weld.rules import read_rules, shipped_rules

        return shipped_rules() if self.weld_rules is None else read_rules(self.weld_rules)

    def words(self) -> list[str]:
        """Return the options as they are typed."""
        return [] if self.weld_rules is None else ["--weld-rules", str(self.weld_rules)]


@dataclass(frozen=True, slots=True, kw_only=True)
class ArcAsked:
    """The weld data of a program, and whether it switches the arc."""

    welds: Path | None = opt(
        None,
        "Weld data of `wpcal welds`: speeds, angles, passes, stitches, and what --arc on writes.",
        metavar="WELDS.json",
    )
    rules: WeldRulesAsked = group(WeldRulesAsked)
    arc: str = opt(
        "off", "Write arc instructions; off is a dry run without them. On needs --welds.", choices=("off", "on")
    )
    settings: ArcSettings = group("wpcal.controllers.program.arc:ArcSettings")
    choice: RunChoice = group("wpcal.weld.runs:RunChoice")

    def read(
        self,
        seams: Sequence[Seam],
        T_base_part: RigidTransform,
        *,
        part_glb: bytes | None,
        names: Collection[str],
        positions: Mapping[str, tuple[str, str]] | None = None,
    ) -> tuple[Mapping[str, SeamWeld] | None, ArcSettings | None]:
        """Return the weld data of the chosen seams, and how the arc is switched; None for what is not asked for.

        `seams`: All seams of the part, with frames in `base`.
        Raises `InputError` when the file cannot be used, names an unknown seam, or is missing with ``--arc on``.
        """
        arc = self._settings()
        if self.welds is None:
            return None, None
        from wpcal.weld.find import find_welds
        from wpcal.weld.record import changed_since, read_stated_welds

        table = self.rules.read()
        found = find_welds(
            seams,
            T_base_part,
            table,
            part_glb=part_glb,
            stated=read_stated_welds(self.welds, table),
            names=names,
            stated_in=str(self.welds),
            positions=positions,
        )
        for note in (*found.notes, *changed_since(self.welds, found.welds)):
            click.echo(f"wpcal: {self.welds}: {note}", err=True)
        return found.by_seam(), arc

    def _settings(self) -> ArcSettings | None:
        """Return how the arc is switched; None for a dry run.

        Raises `InputError` when it is asked for without weld data.
        """
        from wpcal.core.errors import ErrorCode, InputError

        if self.arc != "on":
            return None
        if self.welds is None:
            what = "arc instructions need weld data; write them with wpcal welds, check them, and give the file"
            raise InputError(what, code=ErrorCode.WELDS_MISSING)
        return self.settings
