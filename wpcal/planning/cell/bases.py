"""The place of base 2 relative to base 1, from points that both robots touched, written into a cell file.

The fit is that of a part: the points in the base of robot 2 take the place of the model.
"""

from __future__ import annotations

import copy
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from wpcal.calibrate import CalibrationResult, Criterion, Solver, calibrate
from wpcal.core.errors import FormatError
from wpcal.core.pairs import PointPairs
from wpcal.core.records import read_json
from wpcal.core.tables import read_table
from wpcal.planning.cell.cell import Cell
from wpcal.planning.cell.cell_file import CELL_SCHEMA, cell_from_record
from wpcal.planning.cell.grasp import NO_GRASP, with_arms

BASE1_COLUMNS = ("base1_x_mm", "base1_y_mm", "base1_z_mm")
BASE2_COLUMNS = ("base2_x_mm", "base2_y_mm", "base2_z_mm")
FEWEST = 3  #: Fewest points that determine a pose in space.


@dataclass(frozen=True, slots=True, eq=False)
class MeasuredBases:
    """A cell with the measured place of robot 2."""

    result: CalibrationResult  #: Of the points; its `T_base_part` is ``T_base1_base2``.
    #: ``cell.json`` with the new ``T_world_base`` of robot 2, and the arm files that it names.
    files: Mapping[str, Any]
    moved_mm: float  #: Distance between the measured base of robot 2 and the base in the cell file.


def read_base_points(path: Path) -> PointPairs:
    """Read ``name,base1_x_mm,base1_y_mm,base1_z_mm,base2_x_mm,base2_y_mm,base2_z_mm``, one row per point.

    Raises
    ------
    InputError : When the file cannot be opened.
    FormatError
        When a column is missing, a cell is not a number, a name appears twice, or there are fewer than three points.
    """
    table = read_table(path)
    table.require(("name", *BASE1_COLUMNS, *BASE2_COLUMNS))
    names = table.unique_names("name")
    if len(names) < FEWEST:
        raise FormatError(
            f"two bases need at least {FEWEST} points that both robots touched, got {len(names)}", path=str(path)
        )
    return PointPairs(tuple(names), table.numbers(BASE2_COLUMNS), table.numbers(BASE1_COLUMNS))


def measure_bases(cell_json: Path, touched: PointPairs, *, tolerance_mm: float) -> MeasuredBases:
    r"""Fit the place of robot 2 and put it into a cell.

    .. math:: T_{world,base2} = T_{world,base1} \, T_{base1,base2}

    `touched`: Of n points: source in base 2, target in base 1, mm.
    Raises `GeometryError` when the points are on one line.
    Raises `FormatError` when the file breaks its format.
    """
    record = copy.deepcopy(read_json(cell_json, schema=CELL_SCHEMA))
    cell = _read_without_grasp(record, cell_json)
    result = calibrate(touched, criterion=Criterion.MINIMAX, solver=Solver.EXACT, tolerance_mm=tolerance_mm)
    fitted = result.T_base_part.relabelled(target="base1", source="base2")
    T_world_base2 = cell.T_world_base @ fitted
    record["holder_robot"]["T_world_base"] = T_world_base2.to_record()
    moved = float(np.linalg.norm(T_world_base2.t_mm - cell.T_world_base2.t_mm))
    return MeasuredBases(result, with_arms(record, cell_json), moved)


def _read_without_grasp(record: Mapping[str, Any], path: Path) -> Cell:
    """Read a cell and check everything except its grasp, which may be measured later."""
    filled = copy.deepcopy(dict(record))
    holder = filled.get("holder_robot")
    if isinstance(holder, dict) and holder.get("T_flange_part") is None:
        holder["T_flange_part"] = NO_GRASP
    return cell_from_record(filled, path=path)
