"""Read an arm from a URDF file: axes in space become Denavit-Hartenberg links.

A URDF states each joint by an origin and an axis. The links here are found from the axes as lines alone, so the result
does not depend on where the file puts its frames; parallel neighbours get Hayati's link.

References: Hayati 1983, Robot arm geometric link parameter estimation, for links with parallel axes.
"""

from __future__ import annotations

import xml.etree.ElementTree as ET
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from wpcal.core.arrays import FloatArray
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes
from wpcal.core.numbers import parse_number
from wpcal.core.rotations import rotation_from_zyx
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed, shown
from wpcal.robot.kinematics.arm import Arm, Joint
from wpcal.robot.kinematics.forward import MDHChain

MM_PER_M = 1000.0
LEAST_AXIS = 1e-6  #: Length of an axis. A URDF states unit vectors; one that is nearly zero has no direction.
LARGEST_M = 1e6  #: The largest coordinate of wpcal, in the unit of a URDF.
LARGEST_RAD = 1e6
"""Limits of a joint, rad and rad/s. Files of joints that turn for ever state 1e16 at times; these are refused, since no
robot arm has such a limit."""
NEARLY_PARALLEL_SIN = 0.1
"""Axes closer than about 6° take Hayati's link: their common normal may lie metres away and move with every digit."""
MEETING_MM = 1e-6  #: Axes nearer than this meet; the digits of a URDF are coarser.


@dataclass(frozen=True, slots=True, eq=False)
class _UrdfJoint:
    name: str
    kind: str
    parent: str
    child: str
    T_parent_child: FloatArray
    axis: FloatArray
    limits: tuple[float, float]
    speed: float | None


def read_urdf(path: Path, *, base_link: str | None = None, tip_link: str | None = None) -> Arm:
    """Read the chain of revolute joints from one link of a URDF to another.

    `base_link`: Link whose frame becomes `base`; unless given, the link ``base`` where there is one (by convention of
    the ROS-Industrial packages the controller's own base frame), else the root.

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when it is not a URDF file, branches, or has a joint on the way that is neither revolute nor
    fixed.
    """
    root = urdf_root(path)
    try:
        joints = {joint.child: joint for joint in map(_parse_joint, root.findall("joint"))}
        return _arm(root.get("name", path.stem), joints, base_link, tip_link)
    except InputError as error:
        raise FormatError(str(error), path=str(path)) from None
    except (AttributeError, TypeError, ValueError) as error:
        raise FormatError(f"a joint is not as the URDF format says: {error}", path=str(path)) from None


def urdf_root(path: Path) -> ET.Element:
    """Read a URDF file as XML.

    Raises `InputError` when the file cannot be opened.
    Raises `FormatError` when it is not XML.
    """
    try:
        return ET.fromstring(read_bytes(path).decode("utf-8"))
    except (ET.ParseError, UnicodeDecodeError) as error:
        raise FormatError(f"is not XML: {error}", path=str(path)) from None


def link_places(root: ET.Element) -> dict[str, tuple[int, FloatArray]]:
    """Return where the links of a robot are with all joints at zero.

    Returns dict of str to (int, ndarray of shape (4, 4)). By the name of the link: how many joints move it, and its
    frame in the base that `read_urdf` uses, mm.
    """
    joints = {joint.child: joint for joint in map(_parse_joint, root.findall("joint"))}
    links = {joint.parent for joint in joints.values()} | set(joints)
    T_base_root = np.linalg.inv(_fixed_pose(joints, "base" if "base" in links else sorted(links - set(joints))[0]))
    places = {}
    for link in links:
        T, moving = T_base_root, 0
        for joint in _way(joints, link):
            T = T @ joint.T_parent_child
            moving += joint.kind != "fixed"
        places[link] = (moving, np.asarray(T, dtype=np.float64))
    return places


def _parse_joint(element: ET.Element) -> _UrdfJoint:
    name = element.get("name", "?")
    parent, child = element.find("parent"), element.find("child")
    if parent is None or child is None:
        raise FormatError(f"joint {name} has no parent or no child")
    origin, axis, limit = element.find("origin"), element.find("axis"), element.find("limit")
    T = np.eye(4) if origin is None else origin_pose(origin)
    bounds, speed = (-np.pi, np.pi), None
    kind = element.get("type", "?")
    if limit is not None and kind == "revolute":  # limits of a continuous joint have no meaning
        bounds = (_limit(limit, "lower", -np.pi, name), _limit(limit, "upper", np.pi, name))
    if limit is not None:
        speed = _limit(limit, "velocity", 0.0, name) or None
    direction = _numbers("1 0 0" if axis is None else axis.get("xyz", "1 0 0"))
    length = float(np.linalg.norm(direction))
    if length < LEAST_AXIS:
        raise FormatError(f"joint {name}: expected an axis of length 1, got one of length {length:g}")
    return _UrdfJoint(name, kind, str(parent.get("link")), str(child.get("link")), T, direction / length, bounds, speed)


def origin_pose(origin: ET.Element) -> FloatArray:
    """Return the pose of an element ``origin``, shape (4, 4), mm."""
    T = np.eye(4)
    T[:3, :3] = rotation_from_zyx(*_numbers(origin.get("rpy", "0 0 0")))
    T[:3, 3] = MM_PER_M * _numbers(origin.get("xyz", "0 0 0"))
    return T


def _numbers(text: str) -> FloatArray:
    values = np.array([parse_number(cell, most=LARGEST_M) for cell in text.split()])
    if values.shape != (3,):
        raise FormatError(f"expected three numbers, got {shown(text)}")
    return values


def _limit(element: ET.Element, key: str, usual: float, joint: str) -> float:
    text = element.get(key)
    try:
        return usual if text is None else parse_number(text, most=LARGEST_RAD)
    except InputError as error:
        raise FormatError(f"joint {joint}: {key}: {error}") from None


def _arm(name: str, joints: dict[str, _UrdfJoint], base_link: str | None, tip_link: str | None) -> Arm:
    links = {joint.parent for joint in joints.values()} | set(joints)
    roots = sorted(links - set(joints))
    if len(roots) != 1:
        raise FormatError(f"expected one root link, found {listed(roots) or 'none'}")
    base = base_link or ("base" if "base" in links else roots[0])
    tip = tip_link or ("tool0" if "tool0" in links else _end_of_chain(joints, roots[0]))
    for link in (base, tip):
        if link not in links:
            raise FormatError(f"there is no link {link!r}")
    T_base_root = np.asarray(np.linalg.inv(_fixed_pose(joints, base)), dtype=np.float64)
    T, moving, points, directions = T_base_root, [], [], []
    for joint in _way(joints, tip):
        T = np.asarray(T @ joint.T_parent_child, dtype=np.float64)
        if joint.kind in ("revolute", "continuous"):
            moving.append(joint)
            points.append(T[:3, 3])
            directions.append(T[:3, :3] @ joint.axis)
        elif joint.kind != "fixed":
            raise FormatError(f"joint {joint.name} is {joint.kind}, expected revolute or fixed")
    if not moving:
        raise FormatError(f"no revolute joint between {base!r} and {tip!r}")
    return Arm(
        name=name,
        chain=chain_from_axes(np.array(points), np.array(directions), T),
        joints=tuple(Joint(joint.name, 1, *joint.limits, joint.speed) for joint in moving),
        mount_mm=T_base_root[:3, 3],
    )


def _way(joints: dict[str, _UrdfJoint], link: str) -> list[_UrdfJoint]:
    """Joints from the root to a link."""
    way: list[_UrdfJoint] = []
    while link in joints:
        way.append(joints[link])
        link = joints[link].parent
        if len(way) > len(joints):
            raise FormatError(f"the joints form a circle at link {link!r}")
    return way[::-1]


def _fixed_pose(joints: dict[str, _UrdfJoint], link: str) -> FloatArray:
    """Pose of a link in the root that no moving joint may come before."""
    T = np.eye(4)
    for joint in _way(joints, link):
        if joint.kind != "fixed":
            raise FormatError(f"link {link!r} cannot be the base: it moves with joint {joint.name}")
        T = T @ joint.T_parent_child
    return T


def _end_of_chain(joints: dict[str, _UrdfJoint], root: str) -> str:
    children_of: dict[str, list[str]] = {}
    for joint in joints.values():
        children_of.setdefault(joint.parent, []).append(joint.child)
    link = root
    while children := sorted(children_of.get(link, [])):
        if len(children) > 1:
            raise FormatError(f"link {link!r} branches into {listed(children)}: name the tip link")
        link = children[0]
    return link


def chain_from_axes(points: FloatArray, directions: FloatArray, T_base_flange: FloatArray) -> MDHChain:
    """Return the chain whose axes at zero are the given lines.

    `points`, `directions`: shape (n, 3). A point on each axis (mm) and its unit direction, in the base.
    `T_base_flange`: shape (4, 4). The flange at zero, in the base.
    """
    n = len(points)
    frame = _first_frame(points, directions, T_base_flange)
    T_base_dh0, rows, parallel = frame, [], []
    for i in range(n):
        last = i == n - 1
        point = T_base_flange[:3, 3] if last else points[i + 1]
        direction = T_base_flange[:3, 2] if last else directions[i + 1]
        row, hayati = _link(frame, point, direction, last=last)
        rows.append(row)
        parallel.append(hayati)
        frame = frame @ _link_matrix(row)
    theta, d, a, alpha, beta = np.array(rows).T
    return MDHChain(
        theta,
        d,
        a,
        alpha,
        beta,
        tuple(parallel),
        T_base_dh0=RigidTransform.from_matrix(T_base_dh0, target="base", source="dh0"),
        T_dhn_flange=RigidTransform.from_matrix(np.linalg.inv(frame) @ T_base_flange, target="dhn", source="flange"),
    )


def _first_frame(points: FloatArray, directions: FloatArray, T_base_flange: FloatArray) -> FloatArray:
    """Frame on axis 1 nearest to the base's origin, turned so that the first link needs no offset."""
    z = directions[0]
    seed = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = seed - (seed @ z) * z
    x /= np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3, :4] = np.column_stack([x, np.cross(z, x), z, points[0] - (points[0] @ z) * z])
    last = len(points) == 1
    target = (T_base_flange[:3, 3], T_base_flange[:3, 2]) if last else (points[1], directions[1])
    (theta, *_), _ = _link(frame, *target, last=last)
    return np.asarray(frame @ _link_matrix((theta, 0.0, 0.0, 0.0, 0.0)), dtype=np.float64)


def _link(frame: FloatArray, point: FloatArray, direction: FloatArray, *, last: bool) -> tuple[tuple[float, ...], bool]:
    """Parameters (θ, d, a, α, β) from a frame to the next axis, and whether it is Hayati's link."""
    p, z = frame[:3, :3].T @ (point - frame[:3, 3]), frame[:3, :3].T @ direction  # in the frame
    sin = float(np.hypot(z[0], z[1]))
    parallel = sin < NEARLY_PARALLEL_SIN
    if parallel:
        foot = p - (p[2] / z[2]) * z  # where the next axis meets the plane z = 0 of this frame
        d = float(p[2]) if last else 0.0  # no axis follows the last one: its d reaches the flange
        foot = p - np.array([0.0, 0.0, d]) if last else foot
        a = float(np.hypot(foot[0], foot[1]))
        x = foot[:2] / a if a > MEETING_MM else np.array([1.0, 0.0])
    else:
        normal = np.array([z[1], -z[0]]) / sin  # direction of z_next × z, in the plane of this frame
        a, x = float(p[:2] @ normal), normal
        if a < -MEETING_MM or (abs(a) <= MEETING_MM and (normal[0], normal[1]) < (-MEETING_MM, 0.0)):
            a, x = -a, -normal
        d = float(p[2] - z[2] * (p[0] * z[0] + p[1] * z[1]) / sin**2)
    a = a if abs(a) > MEETING_MM else 0.0
    along, across = float(z[0] * x[0] + z[1] * x[1]), float(z[1] * x[0] - z[0] * x[1])
    theta, alpha = float(np.arctan2(x[1], x[0])), float(np.arctan2(-across, z[2]))
    beta = float(np.arcsin(along)) if parallel else 0.0
    return (theta, d, a, alpha, beta), parallel and not last


def _link_matrix(row: tuple[float, ...]) -> FloatArray:
    theta, d, a, alpha, beta = row
    T = np.eye(4)
    T[:3, :3] = rotation_from_zyx(0.0, 0.0, theta) @ rotation_from_zyx(alpha, 0.0, 0.0) @ rotation_from_zyx(0, beta, 0)
    T[:3, 3] = a * np.cos(theta), a * np.sin(theta), d
    return T
