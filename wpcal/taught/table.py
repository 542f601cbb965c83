"""The file of taught points, and which point of the model each of them is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from enum import Enum
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, as_points
from wpcal.core.errors import FormatError, InputError
from wpcal.core.pairs import PointPairs
from wpcal.core.robot_space import RobotSpace, space_of_table
from wpcal.core.tables import Table, read_table
from wpcal.features.reference import ReferenceFeature, point_named
from wpcal.taught.pairs import covariances_of_table

TAUGHT_COLUMNS = ("x_mm", "y_mm", "z_mm")
MODEL_COLUMNS = ("model_x_mm", "model_y_mm", "model_z_mm")
USES = ("yes", "check", "no")


class TouchKind(Enum):
    """What a row of the file was touched on."""

    POINT = "point"
    """A corner, the centre of a hole: the tip stood at the feature itself."""
    PLANE = "plane"
    EDGE = "edge"
    HOLE = "hole"
    """On the wall of a hole; three or more touches give its axis."""
    CYLINDER = "cylinder"
    SPHERE = "sphere"
    SURFACE = "surface"
    """Any face, free-form ones as well."""


NO_RADIUS = (TouchKind.POINT, TouchKind.EDGE)
"""A ball does not sit at a corner or on an edge: where its centre then is depends on the angle of the faces."""


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
    kinds : tuple of TouchKind, length n, or empty
        What each was touched on; points alone where empty.
    radius_mm : ndarray, shape (n,), or None
        Of touches on faces: how far the controlled point stood off along the outward normal (radius of the ball).
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
    kinds: tuple[TouchKind, ...] = ()
    radius_mm: FloatArray | None = None

    @property
    def has_touches(self) -> bool:
        """Whether a row that is used was touched on an edge or a face."""
        return any(k is not TouchKind.POINT and u != "no" for k, u in zip(self.kinds, self.use, strict=False))

    def kind_of(self, row: int) -> TouchKind:
        """What a row was touched on."""
        return self.kinds[row] if self.kinds else TouchKind.POINT

    def with_ball(self, radius_mm: float) -> TaughtPoints:
        """Return the touches with a ball of this radius on every face row that states none.

        Raises
        ------
        InputError
            When the radius is negative.
        """
        if not radius_mm >= 0:
            raise InputError(f"the radius of a ball is a length that is not negative, got {radius_mm} mm")
        stated = np.full(len(self.names), np.nan) if self.radius_mm is None else self.radius_mm
        on_face = np.array([self.kind_of(row) not in NO_RADIUS for row in range(len(self.names))])
        return replace(self, radius_mm=np.where(np.isnan(stated), np.where(on_face, radius_mm, 0.0), stated))

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
    """Read ``name,x_mm,y_mm,z_mm[,feature][,model_x_mm,model_y_mm,model_z_mm][,use][,sigma_mm][,robot_space]``.

    In place of ``sigma_mm`` the six columns of a covariance may stand, see
    `wpcal.taught.pairs.covariances_of_table`. Without the columns `feature` and `model_…` the name is the
    feature's name. With a column `kind` rows may be touched on edges and faces, `radius_mm` is that of the ball, and
    each row may name its feature, or a model point near its face, or neither.

    Raises
    ------
    InputError
        When the file cannot be opened.
    FormatError
        When a column is missing or misspelt, a number is none, a name appears twice or a word of `use` is unknown.
    FrameError
        When points of the nominal and of the identified robot stand in one file.
    """
    return taught_from_table(read_table(path))


def taught_from_table(table: Table) -> TaughtPoints:
    """Return the taught points of a table; columns and errors as in `read_taught`."""
    table.require(("name", *TAUGHT_COLUMNS))
    table.refuse_misspelt(("feature", *MODEL_COLUMNS, "use", "robot_space", "kind", "radius_mm"))
    if any(column in table.columns for column in MODEL_COLUMNS):
        table.require(MODEL_COLUMNS)
    if table.has("feature") and table.has(*MODEL_COLUMNS) and not table.has("kind"):
        raise FormatError("give either the column feature or model_x_mm, model_y_mm, model_z_mm", path=table.path)
    names = table.unique_names("name")
    p_base = table.numbers(TAUGHT_COLUMNS)
    by_model = table.has(*MODEL_COLUMNS)
    use = table.choices("use", USES, default="yes")
    space, covariances = space_of_table(table), covariances_of_table(table)
    if table.has("kind"):
        p_part = table.numbers_where_given(MODEL_COLUMNS) if by_model else np.full(p_base.shape, np.nan)
        kinds, radius = _touch_columns(table)
        features = tuple(table.columns["feature"]) if table.has("feature") else _points_own_names(names, kinds, p_part)
        return TaughtPoints(
            names, p_base, features, p_part, use, table.path, table.lines, space, covariances, kinds, radius
        )
    p_part = table.numbers(MODEL_COLUMNS) if by_model else np.full(p_base.shape, np.nan)
    features = tuple(table.columns["feature"]) if table.has("feature") else names
    named = ("",) * len(names) if by_model else features
    return TaughtPoints(names, p_base, named, p_part, use, table.path, table.lines, space, covariances)


def _points_own_names(names: Sequence[str], kinds: Sequence[TouchKind], p_part: FloatArray) -> tuple[str, ...]:
    """Take the names of points without model coordinates for their features, as in a file without kinds."""
    own = [kind is TouchKind.POINT and bool(np.isnan(p).any()) for kind, p in zip(kinds, p_part, strict=True)]
    return tuple(name if is_own else "" for name, is_own in zip(names, own, strict=True))


def _touch_columns(table: Table) -> tuple[tuple[TouchKind, ...], FloatArray]:
    """Kinds, and radii with NaN where none is stated."""
    kinds = tuple(TouchKind(word) for word in table.choices("kind", [k.value for k in TouchKind], default="point"))
    if not table.has("radius_mm"):
        return kinds, np.full(len(kinds), np.nan)
    radius = table.numbers_where_given(["radius_mm"])[:, 0]
    for line, kind, value in zip(table.lines, kinds, radius, strict=True):
        if value < 0 or (value > 0 and kind in NO_RADIUS):
            what = f"expected a radius that is not negative, got {value:g}"
            if value > 0:
                what = f"a ball has no radius at a {kind.value}; touch it with the wire tip, or touch its faces"
            raise FormatError(what, path=table.path, line=line, column="radius_mm")
    return kinds, radius


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
        return point_named(features, name)
    except InputError as error:
        raise FormatError(str(error), path=taught.path, line=line) from None
