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
COVARIANCE_COLUMNS = ("cov_xx_mm2", "cov_xy_mm2", "cov_xz_mm2", "cov_yy_mm2", "cov_yz_mm2", "cov_zz_mm2")
"""The upper triangle of the covariance of a taught point, row by row, axes of the base."""
SYMMETRIC = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])
"""Where each entry of the matrix stands among these columns."""
LEAST_RATIO = 1e-12
"""Least ratio of the smallest to the largest eigenvalue of a covariance: below, its inverse is round-off."""


def read_pairs(path: Path) -> tuple[PointPairs, PointPairs | None]:
    """Read ``name,model_x_mm,model_y_mm,model_z_mm,real_x_mm,real_y_mm,real_z_mm[,use][,sigma_mm][,robot_space]``.

    In place of ``sigma_mm`` the six columns of a covariance may stand, see `covariances_of_table`.

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
    """Return the covariances of taught points, mm², shape (n, 3, 3); None where the table states none.

    Parameters
    ----------
    table : Table
        With a column ``sigma_mm``, the standard deviation per axis of each point, or the six columns ``cov_xx_mm2``,
        ``cov_xy_mm2``, ``cov_xz_mm2``, ``cov_yy_mm2``, ``cov_yz_mm2``, ``cov_zz_mm2``, the covariance of each point
        along the axes of the base.

    Raises
    ------
    FormatError
        When a column of errors is misspelt or missing, both kinds are there, a standard deviation is not positive, or
        a covariance is not positive definite.
    """
    table.refuse_misspelt(("sigma_mm", *COVARIANCE_COLUMNS))
    if not any(table.has(column) for column in COVARIANCE_COLUMNS):
        return _isotropic(table) if table.has("sigma_mm") else None
    if table.has("sigma_mm"):
        raise FormatError("give either the column sigma_mm or the six of the covariance", path=table.path, line=1)
    covariances = table.numbers(COVARIANCE_COLUMNS)[:, SYMMETRIC]
    eigenvalues = np.linalg.eigvalsh(covariances)
    for line, value, largest in zip(table.lines, eigenvalues[:, 0], eigenvalues[:, 2], strict=True):
        if value <= LEAST_RATIO * largest:
            raise FormatError(
                f"the covariance is not positive definite: its least eigenvalue is {value:.3g} mm²",
                path=table.path,
                line=line,
            )
    return np.asarray(covariances, dtype=np.float64)


def _isotropic(table: Table) -> FloatArray:
    sigma = table.numbers(["sigma_mm"])[:, 0]
    for line, value in zip(table.lines, sigma, strict=True):
        if value <= 0:
            raise FormatError(
                f"expected a positive number, got {value:g}", path=table.path, line=line, column="sigma_mm"
            )
    return np.asarray(sigma[:, None, None] ** 2 * np.eye(3), dtype=np.float64)
