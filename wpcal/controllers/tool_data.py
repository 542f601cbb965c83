r"""The tool centre point that a program of a controller states.

RAPID: ``PERS tooldata tGun:=[TRUE,[[x,y,z],[q1,q2,q3,q4]],[…]]``. KRL: ``TOOL_DATA[3]={X …,Y …,Z …,A …,B …,C …}`` and
``$TOOL={…}``. URScript: ``set_tcp(p[x,y,z,rx,ry,rz])``, in metres and a rotation vector.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes
from wpcal.core.numbers import parse_number
from wpcal.core.rotations import rotation_from_quaternion, rotation_from_zyx
from wpcal.core.tangent import exp_rotation
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed

LARGEST = 1e4
UNIT_ATOL = 1e-2
"""Programs print quaternions with few digits."""
NUMBER = r"\s*([-+0-9.eE]+)\s*"
RAPID = re.compile(
    r"\btooldata\s+(\w+)\s*:=\s*\[\s*(?:TRUE|FALSE)\s*,\s*\[\s*\["
    + ",".join([NUMBER] * 3)
    + r"\]\s*,\s*\["
    + ",".join([NUMBER] * 4)
    + r"\]",
    re.IGNORECASE,
)
KRL = re.compile(r"(\$TOOL|TOOL_DATA\s*\[\s*\d+\s*\])\s*=\s*\{([^}]*)\}", re.IGNORECASE)
KRL_AXIS = re.compile(r"\b([XYZABC])\s+([-+0-9.eE]+)", re.IGNORECASE)
URSCRIPT = re.compile(r"\b(set_tcp)\s*\(\s*p\s*\[" + ",".join([NUMBER] * 6) + r"\]", re.IGNORECASE)
MM_PER_M = 1000.0


def read_tool_data(path: Path, name: str | None = None) -> RigidTransform:
    """Read the tool centre point from a program. ``T_flange_tool``.

    Parameters
    ----------
    path : RAPID, KRL (``.src``, ``.dat``) or URScript.
    name : Which tool: the name of a tooldata, ``TOOL_DATA[3]`` or ``3``. Needed if the file has several.

    Raises
    ------
    InputError : When the file cannot be opened, has no tool, or `name` is not one of several.
    FormatError : When the numbers are not a pose.
    """
    text = read_bytes(path).decode("latin-1")
    try:
        found = {**_rapid(text), **_krl(text), **_urscript(text)}
    except InputError as error:
        raise FormatError(str(error), path=str(path)) from None
    if not found:
        raise InputError(
            f"{path}: no tool data: expected a tooldata (RAPID), TOOL_DATA or $TOOL (KRL), or set_tcp (UR)"
        )
    if name is None and len(found) == 1:
        return next(iter(found.values()))
    wanted = "" if name is None else name.lower().replace(" ", "")
    for key, tool in found.items():
        if wanted in (key.lower(), key.lower().removeprefix("tool_data[").removesuffix("]")):
            return tool
    which = "several tools: name one" if name is None else f"no tool {name!r}"
    raise InputError(f"{path}: {which}; the file has {listed(found)}")


def _rapid(text: str) -> dict[str, RigidTransform]:
    found = {}
    for match in RAPID.finditer(text):
        values = np.array([parse_number(cell, most=LARGEST) for cell in match.groups()[1:]])
        q = np.roll(values[3:], -1)
        if not abs(float(np.linalg.norm(q)) - 1.0) <= UNIT_ATOL:
            raise InputError(f"tooldata {match[1]}: the quaternion has length {np.linalg.norm(q):.4g}")
        found[match[1]] = RigidTransform(rotation_from_quaternion(q), values[:3], "flange", "tool")
    return found


def _krl(text: str) -> dict[str, RigidTransform]:
    found = {}
    for name, body in KRL.findall(text):
        axes = {key.upper(): parse_number(cell, most=LARGEST) for key, cell in KRL_AXIS.findall(body)}
        if not {"X", "Y", "Z"} <= set(axes):
            continue
        a, b, c = (np.radians(axes.get(key, 0.0)) for key in "ABC")
        place = np.array([axes[key] for key in "XYZ"])
        found[re.sub(r"\s", "", name).upper()] = RigidTransform(rotation_from_zyx(c, b, a), place, "flange", "tool")
    return found


def _urscript(text: str) -> dict[str, RigidTransform]:
    found = {}
    for match in URSCRIPT.finditer(text):
        values = np.array([parse_number(cell, most=LARGEST) for cell in match.groups()[1:]])
        found["set_tcp"] = RigidTransform(exp_rotation(values[3:]), MM_PER_M * values[:3], "flange", "tool")
    return found
