"""ROS 2: one ``geometry_msgs/PoseArray`` per seam as YAML, and a sidecar with names, roles and predicted errors.

Metres and quaternions x, y, z, w as in REP 103. Poses are those of the tool in the robot's base, which REP 199 calls
``base``. A PoseArray cannot hold names: the sidecar lists them, row by row.

References: REP 103 (units and conventions), REP 199 (frames of serial manipulators), geometry_msgs/msg/PoseArray.
"""

import json

from wpcal.controllers.language.naming import NameRules, comment_lines, safe_name, safe_names
from wpcal.controllers.language.rounding import rounded
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe, describe_path, errors_mm
from wpcal.controllers.registry import Exporter
from wpcal.core.rotations import quaternion_from_rotation

NAMES = NameRules("ROS", 60)  #: For names of files. The length is our choice; ROS sets no limit.
DECIMALS = 9  #: 1e-9 m is 1e-6 mm; 1e-9 in a quaternion moves a point at 2 m by 4e-6 mm.
SIDECAR_SCHEMA = "wpcal/ros-sidecar/1"
FRAME_ID = "base"
MM = 1e-3
LONGEST_COMMENT = 100


def write_ros(program: WeldProgram) -> dict[str, str]:
    """Write one PoseArray per seam, and the sidecar. ``SEAM.pose_array.yaml`` and ``NAME.sidecar.yaml``."""
    names = safe_names([path.seam.name for path in program.paths], NAMES)
    files = {f"{names[path.seam.name]}.pose_array.yaml": _pose_array(path) for path in program.paths}
    sidecar = [
        *comment_lines(describe(program, has_arc=False), mark="# ", longest=LONGEST_COMMENT),
        f"schema: {SIDECAR_SCHEMA}",
        "message: geometry_msgs/msg/PoseArray",
        f"frame_id: {FRAME_ID}",
        "units: {length: m, quaternion: xyzw}",
        f"wire_axis: +{program.torch.tool_axis.value}",
        "z_sense: inward",
        *([] if program.safe_point is None else ["safe_point:", *_rows(program.safe_point)]),
        "seams:",
    ]
    for path in program.paths:
        sidecar += _entry(path, f"{names[path.seam.name]}.pose_array.yaml", program.weld_speed_mm_s(path))
    stem = safe_name(program.controller.program_name, NAMES)
    return {**files, f"{stem}.sidecar.yaml": "\n".join([*sidecar, ""])}


def _pose_array(path: WeldPath) -> str:
    head = ["header:", "  stamp: {sec: 0, nanosec: 0}", f"  frame_id: {FRAME_ID}", "poses:"]
    return "\n".join([*head, *_rows(path), ""])


def _rows(path: WeldPath | SafePoint) -> list[str]:
    k = DECIMALS
    places = rounded(path.p_base * MM, k).tolist()
    turns = rounded(quaternion_from_rotation(path.R_base), k).tolist()
    return [
        f"- position: {{x: {x:.{k}f}, y: {y:.{k}f}, z: {z:.{k}f}}}\n"
        f"  orientation: {{x: {qx:.{k}f}, y: {qy:.{k}f}, z: {qz:.{k}f}, w: {qw:.{k}f}}}"
        for (x, y, z), (qx, qy, qz, qw) in zip(places, turns, strict=True)
    ]


def _entry(path: WeldPath, file: str, mm_s: float) -> list[str]:
    """Return the sidecar's lines of one seam. Text is written as JSON strings, which YAML reads."""
    along = ("null" if mm is None else f"{mm * MM:.{DECIMALS}f}" for mm in errors_mm(path))
    errors = "null" if path.u95_mm is None else f"[{', '.join(along)}]"
    return [
        f"- name: {json.dumps(path.seam.name)}",
        f"  file: {json.dumps(file)}",
        f"  what: {json.dumps(describe_path(path))}",
        f"  closed: {json.dumps(path.seam.closed)}",
        f"  weld_speed_m_s: {mm_s * MM:.{DECIMALS}g}",
        f"  roles: [{', '.join(path.roles)}]",
        f"  error_95_m: {errors}",
    ]


ROS = Exporter("ros", "ROS 2: one PoseArray YAML per seam, and a sidecar with names and errors", write_ros)
