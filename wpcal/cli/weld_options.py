"""Options about weld data: the table of rules, the file of weld data, and whether the arc burns."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import option

if TYPE_CHECKING:
    from wpcal.weld.rules import RuleTable


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
