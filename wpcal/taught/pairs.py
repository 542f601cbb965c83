"""The file of point pairs: the same points on the model and on the real part, one row per point."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from wpcal.core.errors import FormatError
from wpcal.core.pairs import PointPairs
from wpcal.core.robot_space import space_of_table
from wpcal.core.tables import read_table
from wpcal.taught.columns import MODEL_COLUMNS, USES, covariances_of_table

REAL_COLUMNS = ("real_x_mm", "real_y_mm", "real_z_mm")


def read_pairs(path: Path) -> tuple[PointPairs, PointPairs | None]:
    """Read ``name,model_x_mm,model_y_mm,model_z_mm,real_x_mm,real_y_mm,real_z_mm[,use][,sigma_mm][,robot_space]``.

    Six columns of a covariance can replace ``sigma_mm``, see `wpcal.taught.columns.covariances_of_table`.

    Returns `pairs`: PointPairs. The rows with use ``yes`` or empty: source ``part``, target ``base``, mm.
    Returns `check`: The rows with use ``check``: they are not fitted and test the fit. Rows with use ``no`` are left
    out.

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when a column is missing, a cell is not a finite number, a name appears twice, or fewer than 3
    rows are to be fitted.
    Raises `FrameError` when one file holds points of the nominal and of the identified robot.
    """
    table = read_table(path)
    table.require(("name", *MODEL_COLUMNS, *REAL_COLUMNS))
    names = np.array(table.unique_names("name"), dtype=object)
    model, real = table.numbers(MODEL_COLUMNS), table.numbers(REAL_COLUMNS)
    use = np.array(table.choices("use", USES, default="yes"))
    fitted = np.count_nonzero(use == "yes")
    if fitted < 3:
        raise FormatError(f"a fit needs at least 3 points, got {fitted}", path=str(path), line=table.lines[-1])
    space, covariances = space_of_table(table), covariances_of_table(table)
    pairs, check = (
        PointPairs(
            tuple(names[rows]), model[rows], real[rows], None if covariances is None else covariances[rows], space=space
        )
        for rows in (use == word for word in USES[:2])
    )
    return pairs, check if len(check) else None
