"""The file of taught points, and which point of the model each of them is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from wpcal.calibrate.pairs_file import covariances_of_table
from wpcal.core.arrays import FloatArray, as_points
from wpcal.core.errors import FormatError, InputError
from wpcal.core.pairs import PointPairs
from wpcal.core.robot_space import RobotSpace, space_of_table
from wpcal.core.tables import read_table
from wpcal.features.reference import ReferenceFeature, feature_named

TAUGHT_COLUMNS = ("x_mm", "y_mm", "z_mm")
MODEL_COLUMNS = ("model_x_mm", "model_y_mm", "model_z_mm")
USES = ("yes", "check", "no")


@dataclass(frozen=True, slots=True, eq=False)
class TaughtPoints:
    """Points touched with the robot.

    Parameters
    ----------
    names : tuple of str, length n
    p_base : ndarray, shape (n, 3)
        As read from the robot, in `base`, mm.
    features : tuple of str, length n
        Name of the feature that each point is; empty where `p_part` says it.
    p_part : ndarray, shape (n, 3)
        Model coordinates in `part`, mm; NaN where `features` says it.
    use : tuple of str, length n
        ``yes``: fitted; ``check``: reported against the fit; ``no``: left out.
    path : str
        The file, for messages.
    lines : tuple of int, length n
        Line of each point in the file.
    space : RobotSpace
        With which model of the robot the points were computed.
    covariances : ndarray, shape (n, 3, 3), or None
        Of the taught points in `base`, mm².
    """

    names: tuple[str, ...]
    p_base: FloatArray
    features: tuple[str, ...]
    p_part: FloatArray
    use: tuple[str, ...]
    path: str
    lines: tuple[int, ...]
    space: RobotSpace = RobotSpace.NOMINAL
    covariances: FloatArray | None = None

    @classmethod
    def of_features(cls, names: Sequence[str], p_base: ArrayLike) -> TaughtPoints:
        """Return touched features of a part, for scripts that have them in hand.

        Parameters
        ----------
        names : sequence of str, length n
            Names of features, unique.
        p_base : array_like, shape (n, 3)
            In `base`, mm.

        Raises
        ------
        InputError
            When the lengths differ or a number is not finite.
        """
        points = as_points(p_base, name="taught points")
        if len(points) != len(names):
            raise InputError(f"{len(names)} names and {len(points)} taught points")
        n = len(points)
        return cls(tuple(names), points, tuple(names), np.full((n, 3), np.nan), ("yes",) * n, "", (0,) * n)


def read_taught(path: Path) -> TaughtPoints:
    """Read ``name,x_mm,y_mm,z_mm[,feature | model_x_mm,model_y_mm,model_z_mm][,use][,sigma_mm][,robot_space]``.

    In place of ``sigma_mm`` the six columns of a covariance may stand, see
    `wpcal.calibrate.pairs_file.covariances_of_table`. Without the columns `feature` and `model_…` the name is the
    feature's name.

    Raises
    ------
    InputError
        When the file cannot be opened.
    FormatError
        When a column is missing or misspelt, a number is none, a name appears twice or a word of `use` is unknown.
    FrameError
        When points of the nominal and of the identified robot stand in one file.
    """
    table = read_table(path)
    table.require(("name", *TAUGHT_COLUMNS))
    table.refuse_misspelt(("feature", *MODEL_COLUMNS, "use", "robot_space"))
    if any(column in table.columns for column in MODEL_COLUMNS):
        table.require(MODEL_COLUMNS)
    if table.has("feature") and table.has(*MODEL_COLUMNS):
        raise FormatError("give either the column feature or model_x_mm, model_y_mm, model_z_mm", path=table.path)
    names = table.unique_names("name")
    p_base = table.numbers(TAUGHT_COLUMNS)
    by_model = table.has(*MODEL_COLUMNS)
    p_part = table.numbers(MODEL_COLUMNS) if by_model else np.full(p_base.shape, np.nan)
    features = tuple(table.columns["feature"]) if table.has("feature") else names
    use = table.choices("use", USES, default="yes")
    named = ("",) * len(names) if by_model else features
    space, covariances = space_of_table(table), covariances_of_table(table)
    return TaughtPoints(names, p_base, named, p_part, use, table.path, table.lines, space, covariances)


def pair_points(taught: TaughtPoints, features: Sequence[ReferenceFeature]) -> tuple[PointPairs, PointPairs | None]:
    """Find the model point of every taught point.

    Parameters
    ----------
    taught : TaughtPoints
    features : sequence of ReferenceFeature
        Of the part.

    Returns
    -------
    pairs : PointPairs
        The points to fit.
    check : PointPairs or None
        The points to report against the fit.

    Raises
    ------
    FormatError
        When a feature's name is unknown (with the nearest names), or fewer than 3 points are to be fitted.
    """
    p_part = np.array(taught.p_part)
    for row, (name, use) in enumerate(zip(taught.features, taught.use, strict=True)):
        if use != "no" and np.isnan(p_part[row]).any():
            p_part[row] = _feature_point(taught, features, name, taught.lines[row])
    uses = np.array(taught.use)
    fitted = np.flatnonzero(uses == "yes")
    if len(fitted) < 3:
        raise FormatError(f"a fit needs at least 3 points with use yes, got {len(fitted)}", path=taught.path)
    pairs, check = (
        PointPairs(
            tuple(taught.names[i] for i in rows),
            p_part[rows],
            taught.p_base[rows],
            None if taught.covariances is None else taught.covariances[rows],
            space=taught.space,
        )
        for rows in (fitted, np.flatnonzero(uses == "check"))
    )
    return pairs, check if len(check) else None


def _feature_point(taught: TaughtPoints, features: Sequence[ReferenceFeature], name: str, line: int) -> FloatArray:
    if not name:
        raise FormatError("the feature is empty", path=taught.path, line=line, column="feature")
    try:
        return feature_named(features, name).p_mm
    except InputError as error:
        raise FormatError(str(error), path=taught.path, line=line) from None
