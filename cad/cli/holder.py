"""Options of `wpcal calibrate` for a part that robot 2 holds, and the cell file that then knows the grasp."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import option

if TYPE_CHECKING:
    from wpcal.planning.cell.grasp import Holding


@dataclass(frozen=True, slots=True, kw_only=True)
class HolderFlags:
    """The cell and the joints at which robot 2 held the part."""

    cell_json: Path | None = option(
        "--cell",
        metavar="CELL.json",
        type=click.Path(path_type=Path),
        help="The cell: of two robots, for --holder-joints; cell.json with the part in the gripper is written.",
    )
    holder_joints: str | None = option(
        "--holder-joints", metavar="Q1,…,Q6", help="Shown angles of robot 2 while it held the part, deg."
    )

    def read(self) -> Holding | None:
        """Read the cell and the joints of robot 2 if both are given.

        Raises
        ------
        InputError
            If only one of them is given, or one cannot be used.
        """
        from wpcal.core.errors import InputError
        from wpcal.planning.cell.grasp import read_holding

        if (self.cell_json is None) != (self.holder_joints is None):
            raise InputError("--cell and --holder-joints belong together: where robot 2 is and how it held the part")
        if self.cell_json is None or self.holder_joints is None:
            return None
        return read_holding(self.cell_json, self.holder_joints)
