"""Columns that the files of taught points and of point pairs have in common."""

from __future__ import annotations

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError
from wpcal.core.tables import Table

TAUGHT_COLUMNS = ("x_mm", "y_mm", "z_mm")  #: A touched point in the base.
MODEL_COLUMNS = ("model_x_mm", "model_y_mm", "model_z_mm")  #: The same point on the model, in the frame of the part.
USES = ("yes", "check", "no")  #: Words of the column `use`: fitted; not fitted, but tests the fit; left out.
COVARIANCE_COLUMNS = ("cov_xx_mm2", "cov_xy_mm2", "cov_xz_mm2", "cov_yy_mm2", "cov_yz_mm2", "cov_zz_mm2")
"""The upper triangle of the covariance of a taught point, row by row, along the axes of the base."""
SYMMETRIC = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])  #: The column of each entry of the matrix.
LEAST_RATIO = 1e-12
"""Least ratio of the smallest to the largest eigenvalue of a covariance. Below it, the inverse is round-off."""


def covariances_of_table(table: Table) -> FloatArray | None:
    """Return the covariances of taught points in the base, mm², shape (n, 3, 3); None if the table states none.

    `table`: Either with the column ``sigma_mm``, the standard deviation per axis of each point, or with the six columns
    `COVARIANCE_COLUMNS`, the covariance of each point.
    Raises `FormatError` when a column is misspelt or missing, both kinds of columns are there, a standard deviation is
    not positive, or a covariance is not positive definite.
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
