"""Taught points: the table that holds them, and the point of the model that each of them is."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from wpcal.core.arrays import FloatArray, as_points
from wpcal.core.csv_text import csv_text
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes, sha256_of
from wpcal.core.orientation_columns import ANGLE_COLUMNS, orientations_of_table
from wpcal.core.pairs import PointPairs
from wpcal.core.readings import postures_of_readings
from wpcal.core.robot_space import RobotSpace, space_of_table
from wpcal.core.rotations import rx_ry_rz_deg
from wpcal.core.tables import Table, parse_table
from wpcal.taught.columns import COVARIANCE_COLUMNS, MODEL_COLUMNS, TAUGHT_COLUMNS, USES, covariances_of_table
from wpcal.taught.features.reference import ReferenceFeature, point_named
from wpcal.taught.kinds import KINDS, TouchKind

TAUGHT_SCHEMA = "wpcal/taught/1"
MISSING = {"nan", "None", "<NA>", "NaT"}  #: How the libraries of tables write an empty cell as text.


@dataclass(frozen=True, slots=True, eq=False)
class TaughtPoints:
    """Points touched with the robot."""

    names: tuple[str, ...]
    p_base: FloatArray  #: shape (n, 3). As read from the robot, in `base`, mm.
    #: length n. Name of the feature that each point is; empty if the point has model coordinates or its feature is not
    #: known.
    features: tuple[str, ...]
    p_part: FloatArray  #: shape (n, 3). Model coordinates in `part`, mm; NaN if the point has none.
    use: tuple[str, ...]  #: length n. ``yes``: fitted; ``check``: not fitted, tests the fit; ``no``: left out.
    path: str  #: The file, for messages.
    lines: tuple[int, ...]  #: length n. Line of each point in the file.
    space: RobotSpace = RobotSpace.NOMINAL  #: The model of the robot with which the points were computed.
    covariances: FloatArray | None = None  #: shape (n, 3, 3). Of the taught points in `base`, mm².
    #: length n, or empty. What each row was touched on; empty if all rows are points.
    kinds: tuple[TouchKind, ...] = ()
    #: shape (n,). Distance of the controlled point from the touched face along its outward normal, mm: the radius of
    #: the ball.
    radius_mm: FloatArray | None = None
    #: The names come from a controller's program, which names points in its own way: they need not be features.
    is_from_program: bool = False
    tcp_bias_mm: float = 0.0  #: Error of the tool centre point that all points share (95 %), mm.
    sha256: str | None = None  #: Of the bytes that were read; None for points that are not from a file.
    #: shape (n, 3, 3). The axes of the tool at each touch, as columns, in `base`; NaN in rows that do not say.
    R_base_tool: FloatArray | None = None
    #: shape (n, 3). Outward normals of the touched faces in `part`. They decide between faces equally near to a model
    #: point.
    normal_part: FloatArray | None = None
    #: shape (n, 3, s). What each point sees of one standard deviation of s errors that all share, in `base`, mm; the
    #: covariances contain them.
    shared: FloatArray | None = None

    @property
    def postures(self) -> dict[str, FloatArray]:
        """The axes of the tool in `base`, shape (3, 3), by the names of the rows that say them."""
        if self.R_base_tool is None:
            return {}
        return {name: R for name, R in zip(self.names, self.R_base_tool, strict=True) if not np.isnan(R).any()}

    @property
    def has_touches(self) -> bool:
        """Whether any row in use was touched on an edge or a face."""
        return any(k is not TouchKind.POINT and u != "no" for k, u in zip(self.kinds, self.use, strict=False))

    def kind_of(self, row: int) -> TouchKind:
        """Return what a row was touched on."""
        return self.kinds[row] if self.kinds else TouchKind.POINT

    def with_ball(self, radius_mm: float) -> TaughtPoints:
        """Return the touches with this radius of the ball for all rows on faces that state none.

        Raises `InputError` when the radius is negative.
        """
        if not radius_mm >= 0:
            raise InputError(f"radius of the ball: expected 0 mm or more, got {radius_mm} mm")
        stated = np.full(len(self.names), np.nan) if self.radius_mm is None else self.radius_mm
        on_face = np.array([self.kind_of(row).takes_radius for row in range(len(self.names))])
        return replace(self, radius_mm=np.where(np.isnan(stated), np.where(on_face, radius_mm, 0.0), stated))

    @classmethod
    def of_features(cls, names: Sequence[str], p_base: ArrayLike) -> TaughtPoints:
        """Return touched features of a part, for scripts that already have them.

        `names`: length n. Names of features, unique.
        `p_base`: shape (n, 3). In `base`, mm.
        Raises `InputError` when the lengths differ or a number is not finite.
        """
        points = as_points(p_base, name="taught points")
        if len(points) != len(names):
            raise InputError(f"{len(names)} names and {len(points)} taught points")
        n = len(points)
        return cls(tuple(names), points, tuple(names), np.full((n, 3), np.nan), ("yes",) * n, "", (0,) * n)


Taught: TypeAlias = Path | str | TaughtPoints | Mapping[str, ArrayLike] | ArrayLike
"""What scripts give as taught points: a file, points, positions by feature, a table, or positions alone."""


def taught_points(given: Taught) -> TaughtPoints:
    """Return taught points from what a script gives.

    A table (such as a DataFrame) has the columns of a file of taught points, and means what the file means. Positions
    have the shape (n, 3), in `base`, mm; a position is anything that lists three numbers, as a `build123d.Vector`.
    Positions alone are P1, P2, …, and their features are not known.

    Raises `InputError` when positions are not numbers of that shape, and what `read_taught` raises for a file.
    """
    if isinstance(given, TaughtPoints):
        return given
    if isinstance(given, str | Path):
        return read_taught(given)
    if isinstance(given, Mapping):
        return TaughtPoints.of_features(list(map(str, given)), _positions(given.values()))
    columns: Any = getattr(given, "columns", None)
    if columns is not None:
        return taught_from_table(_table_of(columns, given))
    points = as_points(_positions(given), name="taught points")
    named = TaughtPoints.of_features([f"P{row}" for row in range(1, len(points) + 1)], points)
    return replace(named, features=("",) * len(points))


def _positions(given: Any) -> Any:
    """Return positions as NumPy takes them; it does not list the numbers of a position of another library."""
    if not isinstance(given, Iterable):
        return given
    return [list(p) if isinstance(p, Iterable) else p for p in given]


def _table_of(columns: Iterable[Any], given: Any) -> Table:
    """Return a table of another library as the table of a file; values that are missing are empty cells."""
    names = [*columns]
    cells = [["" if str(cell).strip() in MISSING else str(cell).strip() for cell in given[name]] for name in names]
    text = csv_text([map(str, names), *zip(*cells, strict=True)])
    return parse_table(text.encode(), path="taught points")


def read_taught(path: Path | str) -> TaughtPoints:
    """Read ``name,x_mm,y_mm,z_mm[,feature][,model_x_mm,model_y_mm,model_z_mm][,use][,sigma_mm][,robot_space]…``.

    Six columns of a covariance can replace ``sigma_mm``, see `wpcal.taught.columns.covariances_of_table`. If the file
    has neither a column `feature` nor the columns `model_…`, each name is the name of a feature. With a column `kind`,
    rows can be touched on edges and faces: `radius_mm` is the radius of the ball, and a row can name its feature, or
    give a model point near its face, or neither. ``tcp_bias_mm`` is the error of the tool centre point that all points
    share. ``rx_deg, ry_deg, rz_deg`` or ``qx, qy, qz, qw`` are the posture of the tool in the base
    (`wpcal.core.orientation_columns`).

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when a column is missing or misspelt, a cell is not a number, a name appears twice or a word is
    unknown.
    Raises `FrameError` when one file holds points of the nominal and of the identified robot.
    """
    raw = read_bytes(Path(path))
    return replace(taught_from_table(parse_table(raw, path=str(path))), sha256=sha256_of(raw))


def read_features_to_touch(path: Path) -> tuple[str, ...]:
    """Return the features that the rows of a table name, in its order; rows may still lack their coordinates.

    Rows whose use is ``no`` and rows without a feature are left out.

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when it has no column ``name``, an unknown use, or no row names a feature.
    """
    table = parse_table(read_bytes(path), path=str(path))
    table.require(("name",))
    named = table.columns["feature" if table.has("feature") else "name"]
    use = table.choices("use", USES, default="yes")
    names = tuple(dict.fromkeys(name for name, word in zip(named, use, strict=True) if name and word != "no"))
    if not names:
        raise FormatError("no row names a feature", path=table.path)
    return names


def taught_from_table(table: Table) -> TaughtPoints:
    """Return the taught points of a table; columns and errors are those of `read_taught`."""
    table.require(("name", *TAUGHT_COLUMNS))
    table.refuse_misspelt(
        ("feature", *MODEL_COLUMNS, "use", "robot_space", "kind", "radius_mm", "tcp_bias_mm", *ANGLE_COLUMNS)
    )
    if any(column in table.columns for column in MODEL_COLUMNS):
        table.require(MODEL_COLUMNS)
    if table.has("feature") and table.has(*MODEL_COLUMNS) and not table.has("kind"):
        raise FormatError("give either the column feature or model_x_mm, model_y_mm, model_z_mm", path=table.path)
    names = table.unique_names("name")
    p_base = table.numbers(TAUGHT_COLUMNS)
    by_model = table.has(*MODEL_COLUMNS)
    use = table.choices("use", USES, default="yes")
    space, covariances = space_of_table(table), covariances_of_table(table)
    postures = orientations_of_table(table, is_optional=True)
    postures = postures_of_readings(table) if postures is None else postures
    is_touched = table.has("kind")
    read = table.numbers_where_given if is_touched else table.numbers
    p_part = read(MODEL_COLUMNS) if by_model else np.full(p_base.shape, np.nan)
    features = tuple(table.columns["feature"]) if table.has("feature") else names
    kinds, radius = _touch_columns(table) if is_touched else ((), None)
    if is_touched and not table.has("feature"):
        own = [kind is TouchKind.POINT and bool(np.isnan(p).any()) for kind, p in zip(kinds, p_part, strict=True)]
        features = tuple(name if is_own else "" for name, is_own in zip(names, own, strict=True))  # as without kinds
    elif by_model and not is_touched:
        features = ("",) * len(names)
    return TaughtPoints(
        names,
        p_base,
        features,
        p_part,
        use,
        table.path,
        table.lines,
        space,
        covariances,
        kinds,
        radius,
        tcp_bias_mm=_tcp_bias_mm(table),
        R_base_tool=postures,
    )


def _tcp_bias_mm(table: Table) -> float:
    """Return the largest error of the tool centre point that a row states, mm; 0 without the column."""
    if not table.has("tcp_bias_mm"):
        return 0.0
    stated = table.numbers(["tcp_bias_mm"])[:, 0]
    if (stated < 0).any():
        line = table.lines[int(np.argmin(stated))]
        raise FormatError("expected 0 mm or more", path=table.path, line=line, column="tcp_bias_mm")
    return float(stated.max())


def _touch_columns(table: Table) -> tuple[tuple[TouchKind, ...], FloatArray]:
    """Return kinds and radii; the radius is NaN where the row states none."""
    kinds = tuple(KINDS[word] for word in table.choices("kind", tuple(KINDS), default=TouchKind.POINT.value))
    if not table.has("radius_mm"):
        return kinds, np.full(len(kinds), np.nan)
    radius = table.numbers_where_given(["radius_mm"])[:, 0]
    for line, kind, value in zip(table.lines, kinds, radius, strict=True):
        if value < 0 or (value > 0 and not kind.takes_radius):
            what = f"expected a radius of 0 mm or more, got {value:g}"
            if value > 0:
                what = f"a ball has no radius at a {kind.value}; touch it with the wire tip, or touch its faces"
            raise FormatError(what, path=table.path, line=line, column="radius_mm")
    return kinds, radius


def pair_points(taught: TaughtPoints, features: Sequence[ReferenceFeature]) -> tuple[PointPairs, PointPairs | None]:
    """Find the model point of every taught point.

    Returns `pairs`: PointPairs. The points to fit, mm.
    Returns `check`: PointPairs or None. The points that test the fit.

    Raises `FormatError` when a feature's name is unknown (with the nearest names), or fewer than 3 points have use
    ``yes``.
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


def taught_csv(taught: TaughtPoints) -> str:
    """Return the table that `read_taught` reads. Columns that say nothing of any point are left out.

    Two things of a touch program have no column: the normals of the faces, and which errors the points share.
    """
    n = len(taught.names)
    columns = {"name": list(taught.names)} | _numbers(TAUGHT_COLUMNS, taught.p_base)
    if taught.kinds or np.isnan(taught.p_part).all():  # a point of a file without kinds has one or the other
        columns["feature"] = list(taught.features)
    columns |= _numbers(MODEL_COLUMNS, taught.p_part) | _words("kind", [kind.value for kind in taught.kinds], "")
    if taught.kinds and taught.radius_mm is not None:
        columns |= _numbers(("radius_mm",), taught.radius_mm[:, None])
    columns |= _words("use", taught.use, "yes")
    if taught.covariances is not None:
        rows, across = np.triu_indices(3)  # as `COVARIANCE_COLUMNS`
        columns |= _numbers(COVARIANCE_COLUMNS, taught.covariances[:, rows, across], digits=12)
    columns |= _words("tcp_bias_mm", [f"{taught.tcp_bias_mm:.6f}"] * n, f"{0:.6f}")
    if taught.R_base_tool is not None:
        columns |= _numbers(ANGLE_COLUMNS, rx_ry_rz_deg(taught.R_base_tool), digits=4)
    columns |= _words("robot_space", [taught.space.value] * n, RobotSpace.NOMINAL.value)
    return csv_text([columns, *zip(*columns.values(), strict=True)])


def _words(name: str, words: Sequence[str], usual: str) -> dict[str, list[str]]:
    """Return a column of words; nothing if all are the usual one."""
    return {} if set(words) <= {usual} else {name: list(words)}


def _numbers(names: Sequence[str], values: FloatArray, *, digits: int = 6) -> dict[str, list[str]]:
    """Return columns of numbers, empty where a number is NaN; nothing if all are."""
    if np.isnan(values).all():
        return {}
    cells = [["" if np.isnan(v) else f"{v:.{digits}f}" for v in column] for column in values.T.tolist()]
    return dict(zip(names, cells, strict=True))


def taught_record(taught: TaughtPoints) -> dict[str, Any]:
    """Return the record ``wpcal/taught/1`` of the points of a program, which state neither kinds nor uses."""
    points = []
    for name, p, feature in zip(taught.names, taught.p_base.tolist(), taught.features, strict=True):
        posture = taught.postures.get(name)
        angles = None if posture is None else rx_ry_rz_deg(posture).tolist()
        points.append({"name": name, "p_base_mm": p, "feature": feature, "rx_ry_rz_deg": angles})
    return {"schema": TAUGHT_SCHEMA, "robot_space": taught.space.value, "points": points}
