"""Taught points from a program on the controller: coordinates turned into the robot's base, or said what is missing."""

from __future__ import annotations

import csv
import io
import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from importlib import import_module
from pathlib import Path

import numpy as np

from wpcal.core.arrays import FloatArray, frozen
from wpcal.core.errors import ErrorCode, FormatError, InputError
from wpcal.core.records import read_bytes
from wpcal.core.robot_space import RobotSpace
from wpcal.core.transform import RigidTransform
from wpcal.features.reference import ReferenceFeature
from wpcal.robot.kinematics.arm import Arm
from wpcal.taught.programs import BASE, JointValues, ProgramLanguage, ProgramPoint, ProgramPoints
from wpcal.taught.table import TaughtPoints

LANGUAGES = {
    ".mod": "wpcal.controllers.abb.read",
    ".prg": "wpcal.controllers.abb.read",
    ".sys": "wpcal.controllers.abb.read",
    ".dat": "wpcal.controllers.kuka.read",
    ".ls": "wpcal.controllers.fanuc.read",
    ".jbi": "wpcal.controllers.yaskawa.read",
}
"""Suffix of a file and the module that reads it; the module's `LANGUAGE` is a `ProgramLanguage`."""
ANY_FRAME = ""
"""Key of the user frame that holds for every point whose frame is not known otherwise."""
ENCODING = "latin-1"
"""Controllers write one byte a character; every byte is a character of Latin-1, and only names can hold such bytes."""


def is_program(path: Path) -> bool:
    """Tell by the suffix whether a file is a controller's program."""
    return path.suffix.lower() in LANGUAGES


@dataclass(frozen=True, slots=True, eq=False)
class ProgramReading:
    """Which points of a program are wanted, and how they come into the base.

    Parameters
    ----------
    uframes : mapping of str to (sequence of float or str)
        User frames by name or number as the program calls them; the key ``""`` holds for every point whose frame is not
        known otherwise. Values are numbers in the order of that controller's pendant (mm and degrees; RAPID: mm and
        q1 to q4), ``base``, or the name of a frame that the file carries.
    tool : sequence of float, optional
        x, y, z of the tool centre point in the flange, mm, for points recorded without a tool.
    arm : Arm, optional
        For points stored as joint angles or pulses; they need `tool` as well. With an identified arm all points must be
        of this kind: coordinates in a program were computed with the controller's nominal model.
    points : sequence of str, optional
        Only these.
    """

    uframes: Mapping[str, str | Sequence[float]] = field(default_factory=dict)
    tool: Sequence[float] | None = None
    arm: Arm | None = None
    points: Sequence[str] | None = None


def read_taught_program(path: Path, reading: ProgramReading | None = None) -> TaughtPoints:
    """Read the taught points of a program as points in `base`.

    Parameters
    ----------
    path : Path
        RAPID ``.mod``, KRL ``.dat``, FANUC ``.ls`` or INFORM ``.jbi``.
    reading : ProgramReading, optional

    Returns
    -------
    TaughtPoints
        The name of each point is its feature; all are to be used.

    Raises
    ------
    InputError
        When the file cannot be opened, its suffix is unknown, or what is given is not usable.
    FormatError
        When it breaks its format, holds no points or no such points, or does not say in which frame a point stands.
    """
    require_program(path)
    return points_in_base(parse_program(read_bytes(path), path), path, reading or ProgramReading())


def parse_program(raw: bytes, path: Path) -> ProgramPoints:
    """Return what the bytes of a program hold, in the frames that it names; unusable points as well.

    Parameters
    ----------
    raw : bytes
    path : Path
        Its suffix tells the language; messages name it.

    Raises
    ------
    InputError
        When the suffix is unknown.
    FormatError
        When the program breaks its format.
    """
    return _language(path).read(raw.decode(ENCODING), str(path))


def usable_points(found: ProgramPoints, *, arm: Arm | None = None) -> tuple[tuple[str, ...], dict[str, str]]:
    """Return the names of the points that have coordinates (or joints, with an arm), and why the others have none."""
    count = Counter(point.name for point in found.points)
    faults = {
        point.name: f"appears {count[point.name]} times" if count[point.name] > 1 else point.fault or ""
        for point in found.points
        if count[point.name] > 1 or (point.fault and not (arm is not None and point.joints is not None))
    }
    return tuple(name for name in count if name not in faults), faults


def points_in_base(found: ProgramPoints, path: Path, reading: ProgramReading) -> TaughtPoints:
    """Return the points of a program in `base`; errors as in `read_taught_program`.

    Parameters
    ----------
    found : ProgramPoints
        From `parse_program` of the same path.
    path : Path
    reading : ProgramReading
    """
    language, shown = _language(path), str(path)
    tool, arm = reading.tool, reading.arm
    chosen = _chosen(found, reading.points, shown)
    given = {key: _given_frame(key, value, language, found) for key, value in reading.uframes.items()}
    if tool is not None and (len(tool) != 3 or not all(math.isfinite(v) for v in tool)):
        raise InputError(f"tool: expected x, y, z in mm, got {list(tool)}")
    _require_one_space(chosen, arm, shown)
    p_base = [
        _through_arm(point, point.joints, arm, tool, shown)
        if arm is not None and point.joints is not None
        else _in_base(point, given, tool, found, language, shown)
        for point in chosen
    ]
    names = tuple(point.name for point in chosen)
    return TaughtPoints(
        names,
        frozen(p_base),
        names,
        frozen(np.full((len(names), 3), np.nan)),
        ("yes",) * len(names),
        shown,
        tuple(point.line for point in chosen),
        RobotSpace.NOMINAL if arm is None else arm.space,
    )


def names_as_features(taught: TaughtPoints, features: Sequence[ReferenceFeature]) -> TaughtPoints:
    """Take the names of a program's points for features where the part has them, and leave the others to be found.

    Controllers number their points (``P1``, ``C00003``), and only some can be named: a name that the part has
    not, or has for a plane or an axis, says nothing. Points that do not come from a program are returned as they are.

    Parameters
    ----------
    taught : TaughtPoints
    features : sequence of ReferenceFeature
        Of the part.
    """
    if not is_program(Path(taught.path)):
        return taught
    known = {feature.name.lower() for feature in features if feature.kind.is_point}
    return replace(taught, features=tuple(name if name.lower() in known else "" for name in taught.features))


def require_program(path: Path) -> None:
    """Refuse a file that no language claims.

    Raises
    ------
    InputError
        Naming the known suffixes.
    """
    if not is_program(path):
        known = ", ".join(LANGUAGES)
        raise InputError(f"{path}: unknown kind of program {path.suffix or '(no suffix)'!r}; known: {known}")


def parse_uframes(texts: Sequence[str]) -> dict[str, str | Sequence[float]]:
    """Read ``[NAME=]VALUES``: numbers with commas between them, or a word.

    Raises
    ------
    InputError
        When the same frame is given twice or VALUES is empty.
    """
    frames: dict[str, str | Sequence[float]] = {}
    for text in texts:
        name, _, values = text.rpartition("=")
        if not values.strip():
            raise InputError(f"--uframe: expected [NAME=]VALUES, got {text!r}")
        if name.strip() in frames:
            raise InputError(f"--uframe: {name.strip() or 'the frame without a name'} is given twice")
        try:
            frames[name.strip()] = [float(value) for value in values.split(",")]
        except ValueError:
            frames[name.strip()] = values.strip()
    return frames


def taught_csv(taught: TaughtPoints) -> str:
    """Return the table that `wpcal calibrate` reads: name, coordinates in `base`, feature (robot_space)."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    space = [] if taught.space is RobotSpace.NOMINAL else [taught.space.value]
    writer.writerow(("name", "x_mm", "y_mm", "z_mm", "feature", *(["robot_space"] if space else [])))
    for name, p, feature in zip(taught.names, taught.p_base, taught.features, strict=True):
        writer.writerow([name, *(f"{v:.6f}" for v in p), feature, *space])
    return text.getvalue()


def _language(path: Path) -> ProgramLanguage:
    require_program(path)
    language: ProgramLanguage = import_module(LANGUAGES[path.suffix.lower()]).LANGUAGE
    return language


def _chosen(found: ProgramPoints, points: Sequence[str] | None, path: str) -> list[ProgramPoint]:
    if not found.points:
        raise FormatError("holds no stored positions", path=path)
    seen: dict[str, int] = {}
    for point in found.points:
        if point.name in seen and (points is None or point.name in points):
            what = f"the point {point.name!r} appears twice, first in line {seen[point.name]}"
            raise FormatError(what, path=path, line=point.line)
        seen[point.name] = point.line
    missing = [name for name in points or () if name not in seen]
    if missing:
        raise FormatError(f"has no point {', '.join(missing)}; it has {', '.join(seen)}", path=path)
    return [point for point in found.points if points is None or point.name in points]


def _given_frame(
    key: str, value: str | Sequence[float], language: ProgramLanguage, found: ProgramPoints
) -> RigidTransform:
    if isinstance(value, str):
        if value == BASE:
            return RigidTransform.identity(target="base", source="frame")
        if value not in found.frames:
            carried = ", ".join(found.frames) or "none"
            raise InputError(f"user frame {value!r}: the file carries no such frame; it carries {carried}")
        return found.frames[value]
    try:
        return language.pose([float(v) for v in value])
    except InputError as error:
        what = f"user frame {key or list(value)}: {error}"
        raise InputError(f"{what}; expected {language.pose_words} as on the pendant") from None


def _in_base(
    point: ProgramPoint,
    given: Mapping[str, RigidTransform],
    tool: Sequence[float] | None,
    found: ProgramPoints,
    language: ProgramLanguage,
    path: str,
) -> FloatArray:
    if point.fault:
        what = f"point {point.name}: {point.fault}"
        what += "" if point.joints is None else "; or give the arm with --robot, and --tool"
        what += "; or name the points to read with --points"
        raise FormatError(what, path=path, line=point.line)
    p = point.p_mm
    if point.at_flange:
        if tool is None:
            what = "was recorded without a tool, so that its position is the flange's; give --tool X,Y,Z"
            raise FormatError(
                f"point {point.name}: {what} of the tool centre point in the flange", path=path, line=point.line
            )
        p = p + point.R @ np.asarray(tool, dtype=np.float64)
    return _frame_of(point, given, found, language, path).apply(p)


def _require_one_space(points: Sequence[ProgramPoint], arm: Arm | None, path: str) -> None:
    if arm is None or arm.space is RobotSpace.NOMINAL:
        return
    for point in points:
        if point.joints is None:
            what = f"point {point.name}: holds coordinates, which the controller computed with its nominal model; "
            what += f"{arm.name} is an identified arm and needs joint angles or pulses"
            raise FormatError(what, path=path, line=point.line)


def _through_arm(
    point: ProgramPoint, joints: JointValues, arm: Arm, tool: Sequence[float] | None, path: str
) -> FloatArray:
    """Return where the tool tip was, by the forward kinematics of the arm."""
    if tool is None:
        what = "is stored as joint values; give --tool X,Y,Z of the tool centre point in the flange"
        raise FormatError(f"point {point.name}: {what}", path=path, line=point.line)
    try:
        q = arm.angles_from_pulses(joints.values) if joints.in_pulses else np.deg2rad(joints.values)
        T = arm.forward(q[None])[0]
    except (InputError, ValueError) as error:
        raise FormatError(f"point {point.name}: {error}", path=path, line=point.line) from None
    if not arm.within_limits(q):
        what = f"its joint values are beyond the limits of {arm.name}: another arm, or other pulses per degree"
        raise FormatError(f"point {point.name}: {what}", path=path, line=point.line)
    return np.asarray(T[:3, :3] @ np.asarray(tool, dtype=np.float64) + T[:3, 3], dtype=np.float64)


def _frame_of(
    point: ProgramPoint,
    given: Mapping[str, RigidTransform],
    found: ProgramPoints,
    language: ProgramLanguage,
    path: str,
) -> RigidTransform:
    """Find ``T_base_frame``: given by its name, base, carried by the file, given for any; in this order."""
    if point.frame is not None and point.frame in given:
        return given[point.frame]
    if point.frame == BASE:
        return RigidTransform.identity(target="base", source="frame")
    if point.frame is not None and point.frame in found.frames:
        return found.frames[point.frame]
    if ANY_FRAME in given:
        return given[ANY_FRAME]
    if point.frame is None:
        what = f"the file does not say its user frame; give --uframe {language.pose_words} or --uframe base"
        if found.frames:
            what += f", or one that the file carries: {', '.join(found.frames)}"
    else:
        what = f"stands in user frame {point.frame}, whose values the file does not carry; "
        what += f"give --uframe {point.frame}={language.pose_words}"
    code = ErrorCode.USER_FRAME_MISSING
    raise FormatError(f"point {point.name}: {what}", path=path, line=point.line, code=code)
