"""The file of point pairs: the same points of the model and of the real part, one row a point."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError
from wpcal.core.pairs import PointPairs
from wpcal.core.robot_space import space_of_table
from wpcal.core.tables import Table, read_table

MODEL_COLUMNS = ("model_x_mm", "model_y_mm", "model_z_mm")
REAL_COLUMNS = ("real_x_mm", "real_y_mm", "real_z_mm")
USES = ("yes", "check", "no")


def read_pairs(path: Path) -> tuple[PointPairs, PointPairs | None]:
    """Read ``name,model_x_mm,model_y_mm,model_z_mm,real_x_mm,real_y_mm,real_z_mm[,use][,sigma_mm][,robot_space]``.

    Parameters
    ----------
    path : Path

    Returns
    -------
    pairs : PointPairs
        The rows to fit (use ``yes`` or empty), source ``part``, target ``base``, mm.
    check : PointPairs or None
        The rows with use ``check``: touched to judge the fit and left out of it. Rows with ``no`` are not read on.

    Raises
    ------
    InputError
        When the file cannot be opened.
    FormatError
        When a column is missing, a cell is no finite number, a name appears twice, or fewer than 3 rows are to fit.
    FrameError
        When points of the nominal and of the identified robot stand in one file.
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
            tuple(names[rows]),
            model[rows],
            real[rows],
            None if covariances is None else covariances[rows],
            space=space,
        )
        for rows in (use == word for word in USES[:2])
    )
    return pairs, check if len(check) else None


def covariances_of_table(table: Table) -> FloatArray | None:
    """Return the covariances of taught points from a column ``sigma_mm``, mm², shape (n, 3, 3); None without one.

    Parameters
    ----------
    table : Table
        ``sigma_mm`` is the standard deviation per axis of each point.

    Raises
    ------
    FormatError
        When a cell is no positive number.
    """
    if not table.has("sigma_mm"):
        return None
    sigma = table.numbers(["sigma_mm"])[:, 0]
    for line, value in zip(table.lines, sigma, strict=True):
        if value <= 0:
            raise FormatError(
                f"expected a positive number, got {value:g}", path=table.path, line=line, column="sigma_mm"
            )
    return np.asarray(sigma[:, None, None] ** 2 * np.eye(3), dtype=np.float64)
