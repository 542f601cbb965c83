"""Tesseract command language: a Python module that builds a CompositeInstruction of the seams.

Tesseract's own text form is a C++ archive that changes with its version; its Python interface is more stable. The
module holds the poses as plain numbers and a function `build`. A pose is x, y, z in metres, then the quaternion
w, x, y, z in the order of Eigen's constructor. Poses are those of the tool in the robot's base.

References: tesseract_robotics: CartesianWaypoint, MoveInstruction, CompositeInstruction.
"""

import numpy as np

from wpcal.controllers.language.naming import NameRules, comment_lines, safe_name
from wpcal.controllers.language.rounding import rounded
from wpcal.controllers.program import SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe, describe_path
from wpcal.controllers.registry import Exporter
from wpcal.core.rotations import quaternion_from_rotation

NAMES = NameRules(
    "Python",
    60,
    "and as assert async await break class continue def del elif else except finally for from global if import in is "
    "lambda nonlocal not or pass raise return try while with yield",
)
DECIMALS = 9  #: 1e-9 m is 1e-6 mm; 1e-9 in a quaternion moves a point at 2 m by 4e-6 mm.
MM = 1e-3
LONGEST_COMMENT = 100
BUILD = '''

def build(manipulator, working_frame="base", tcp_frame="tool0", profile="DEFAULT"):
    """Return a CompositeInstruction: free motion to the safe point, then linear moves, and back to it."""
    from tesseract_robotics import tesseract_command_language as tcl
    from tesseract_robotics import tesseract_common as common

    program = tcl.CompositeInstruction(profile)
    program.setManipulatorInfo(common.ManipulatorInfo(manipulator, working_frame, tcp_frame))
    moves = [(pose, number == 0 and not SAFE_POINT) for poses in SEAMS.values() for number, pose in enumerate(poses)]
    moves = [*((pose, True) for pose in SAFE_POINT), *moves, *((pose, False) for pose in SAFE_POINT)]
    for (x, y, z, qw, qx, qy, qz), is_free in moves:
        turn = common.Quaterniond(qw, qx, qy, qz)
        pose = common.Isometry3d.Identity() * common.Translation3d(x, y, z) * turn
        waypoint = tcl.CartesianWaypointPoly_wrap_CartesianWaypoint(tcl.CartesianWaypoint(pose))
        kind = tcl.MoveInstructionType_FREESPACE if is_free else tcl.MoveInstructionType_LINEAR
        move = tcl.MoveInstruction(waypoint, kind, profile)
        program.appendMoveInstruction(tcl.MoveInstructionPoly_wrap_MoveInstruction(move))
    return program
'''


def write_tesseract(program: WeldProgram) -> dict[str, str]:
    """Write one Python module with all seams. ``NAME_tesseract.py``."""
    head = [
        *describe(program, has_arc=False),
        "poses of the tool in the base: x y z in m, then the quaternion w x y z",
        f"written with {DECIMALS} decimals: within 0.000001 mm and 0.000001 deg",
        "per seam: the way to it with the approach, its points, the retract and the way from it",
    ]
    lines = [*comment_lines(head, mark="# ", longest=LONGEST_COMMENT), ""]
    safe = [] if program.safe_point is None else _rows(program.safe_point)
    lines += ["SAFE_POINT = [", *(row[4:] for row in safe), "]", "SEAMS = {"]
    for path in program.paths:
        lines += comment_lines([describe_path(path)], mark="    # ", longest=LONGEST_COMMENT)
        lines += [f"    {path.seam.name!a}: [", *_rows(path), "    ],"]
    stem = safe_name(program.controller.program_name, NAMES)
    return {f"{stem}_tesseract.py": "\n".join([*lines, "}"]) + BUILD}


def _rows(path: WeldPath | SafePoint) -> list[str]:
    q_wxyz = np.roll(quaternion_from_rotation(path.R_base), 1, axis=1)
    table = rounded(np.concatenate([path.p_base * MM, q_wxyz], axis=1), DECIMALS).tolist()
    k = DECIMALS
    return [
        f"        ({x:.{k}f}, {y:.{k}f}, {z:.{k}f}, {w:.{k}f}, {a:.{k}f}, {b:.{k}f}, {c:.{k}f}),"
        for x, y, z, w, a, b, c in table
    ]


TESSERACT = Exporter("tesseract", "Tesseract: NAME_tesseract.py that builds a CompositeInstruction", write_tesseract)
