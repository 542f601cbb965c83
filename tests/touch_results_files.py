"""Results files of touch programs as controllers write them (docs/reference/touch-results.md), made for tests."""

from collections.abc import Callable, Mapping

import numpy as np

from wpcal.controllers.language.rounding import rounded_frame
from wpcal.core.arrays import FloatArray
from wpcal.core.rotations import quaternion_from_rotation, zyx_angles
from wpcal.core.tangent import log_rotation
from wpcal.core.transform import RigidTransform
from wpcal.touch.searches import STORED_NUMBERS, Outcome, TouchPlan, halves_of

Stored = Mapping[str, FloatArray | Outcome]
"""Of each search: the place in `part` as planned, or why there is none."""


def rapid(plan: TouchPlan, stored: Stored) -> dict[str, str]:
    part = _rapid_pose(plan.T_base_part.t_mm, plan.T_base_part.R)
    lines = [
        "%%%",
        "  VERSION:1",
        "  LANGUAGE:ENGLISH",
        "%%%",
        "MODULE WPCAL_touch_res",
        f'  PERS string wptPlan:="{plan.fingerprint}";',
        '  PERS string wptTool:="tTorch";',
        f"  PERS num wptCount:={len(plan.searches)};",
        f'  PERS wobjdata wptPart:=[FALSE,TRUE,"",[{part}],[[0,0,0],[1,0,0,0]]];',
    ]
    for name, number, p, R in _rows(plan, stored):
        ends = "[0,0,0,0],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]"
        lines.append(f"  PERS num wptO_{name}:={number};")
        lines.append(f"  PERS robtarget wptP_{name}:=[{_rapid_pose(p, R)},{ends}];")
    return {"WPCAL_touch_res.mod": "\r\n".join([*lines, "ENDMODULE", ""])}


def _rapid_pose(p: FloatArray, R: FloatArray) -> str:
    q = np.roll(quaternion_from_rotation(R), 1)
    return f"[{','.join(f'{v:.9g}' for v in p)}],[{','.join(f'{v:.9g}' for v in q)}]"


def krl(plan: TouchPlan, stored: Stored) -> dict[str, str]:
    place = _labelled(plan.T_base_part.t_mm, plan.T_base_part.R, "XYZABC", reverse=True)
    lines = [
        "&ACCESS RVO",
        "DEFDAT WPCAL_TOUCH PUBLIC",
        "DECL CHAR WPPLAN[8]",
        f'WPPLAN[]="{plan.fingerprint}"',
        "DECL INT WPTOOL=1",
        f"DECL INT WPCOUNT={len(plan.searches)}",
        f"DECL FRAME WPPART={{{place}}}",
    ]
    for name, number, p, R in _rows(plan, stored):
        lines.append(f"DECL INT WPO_{name}={number}")
        lines.append(f"DECL E6POS WPR_{name}={{{_labelled(p, R, 'XYZABC', reverse=True)},S 6,T 27,E1 0.0,E2 0.0}}")
    return {"WPCAL_touch.dat": "\r\n".join([*lines, "ENDDAT", ""])}


def _labelled(p: FloatArray, R: FloatArray, keys: str, *, reverse: bool) -> str:
    angles = np.degrees(zyx_angles(R))
    values = [*p, *(angles[::-1] if reverse else angles)]
    return ",".join(f"{key} {value:.6f}" for key, value in zip(keys, values, strict=True))


def fanuc(plan: TouchPlan, stored: Stored) -> dict[str, str]:
    numbers = {151: halves_of(plan.fingerprint)[0], 152: halves_of(plan.fingerprint)[1], 153: 8, 154: 1}
    numbers[155] = len(plan.searches)
    frame = rounded_frame(plan.T_base_part, mm_decimals=3, deg_decimals=3)
    places = {51: _fanuc_pose(frame.t_mm, frame.R)}
    for k, (_, number, p, R) in enumerate(_rows(plan, stored, frame)):
        numbers[156 + k] = number
        if number == 1:
            places[52 + k] = _fanuc_pose(p, R)
    registers = [f"  [{n}] = {numbers.get(n, 0)}  '' " for n in range(1, 201)]
    positions = [
        f"    [1,{n}] =   'touch' \r\n  Group: 1   Config: N U T, 0, 0, 0\r\n{places[n]}"
        if n in places
        else f"    [1,{n}] =   '' Uninitialized"
        for n in range(1, 101)
    ]
    head = "Storage: CMOS  Access: RW  : ARRAY"
    return {
        "posreg.va": "\r\n".join([f"[*POSREG*]$POSREG  {head}[1,100] OF Position Reg", *positions, ""]),
        "numreg.va": "\r\n".join(
            [f"[*NUMREG*]$NUMREG  {head}[200] OF Numeric Reg", *registers, "[*NUMREG*]$MAXREGNUM  : INTEGER = 200", ""]
        ),
    }


def _fanuc_pose(p: FloatArray, R: FloatArray) -> str:
    cells = [f"{v:9.3f}".replace(" 0.", "  .").replace("-0.", " -.") for v in (*p, *np.degrees(zyx_angles(R)))]
    rows = [[f"{key}: {cell}" for key, cell in zip("XYZWPR", cells, strict=True)][i : i + 3] for i in (0, 3)]
    return "\r\n".join("  " + "   ".join(row) for row in rows)


def inform(plan: TouchPlan, stored: Stored) -> dict[str, str]:
    byte, double, places = [0] * 100, [0] * 100, ["0,0,0"] * 128
    double[50:55] = [*halves_of(plan.fingerprint), 8, 1, len(plan.searches)]
    frame = rounded_frame(plan.T_base_part, mm_decimals=3, deg_decimals=4)  # typed in at the controller
    for k, (_, number, p, R) in enumerate(_rows(plan, stored, frame)):
        byte[50 + k] = number
        if number == 1:
            angles = np.degrees(zyx_angles(R))
            places[50 + k] = ",".join([*(f"{v:.3f}" for v in p), *(f"{v:.4f}" for v in angles)])
    rows = ["/CNFG", "///SHARE 100,100,100,100,20,128,20,20"]
    for kind, values in (("B", byte), ("I", [0] * 100), ("D", double)):
        rows += [f"///{kind}", *(" ".join(map(str, values[i : i + 10])) for i in range(0, 100, 10))]
    return {"VAR.DAT": "\r\n".join([*rows, "///P", *places, ""])}


def urscript(plan: TouchPlan, stored: Stored) -> dict[str, str]:
    head = f"2026-11-22 10:00:00 INFO wpcal {plan.fingerprint}"
    lines = [
        f"2026-11-22 09:00:00 INFO wpcal {'f' * 8} begin 3",
        f"{head} begin {len(plan.searches)}",
        f"{head} tool p[0,0,0.35,0,0,0]",
        f"{head} part {_ur_pose(plan.T_base_part.t_mm, plan.T_base_part.R)}",
    ]
    for name, number, p, R in _rows(plan, stored):
        if number:
            place = f" {_ur_pose(p, R)}" if number == 1 else ""
            lines.append(f"{head} {name} {['', 'found', 'missed', 'active'][number]}{place}")
    return {"log_history.txt": "\n".join([*lines, "PolyScope: other line", f"{head} end", ""])}


def _ur_pose(p: FloatArray, R: FloatArray) -> str:
    return "p[" + ",".join(f"{v:.9g}" for v in (*(np.asarray(p) / 1000.0), *log_rotation(R))) + "]"


def kawasaki(plan: TouchPlan, stored: Stored) -> dict[str, str]:
    trans = [f"wpt_part {_oat(plan.T_base_part.t_mm, plan.T_base_part.R)}"]
    reals = [f"wpt_count = {len(plan.searches)}"]
    for name, number, p, R in _rows(plan, stored):
        reals.append(f"wpto_{name.lower()} = {number}")
        if number == 1:
            trans.append(f"wptp_{name.lower()} {_oat(p, R)}")
    texts = [f'$wpt_plan = "{plan.fingerprint}"', '$wpt_tool = "ttorch"']
    program = [".PROGRAM wpcal_touch()", "  BASE wpt_part", "  LMOVE wpt_t1_s", ".END"]
    return {
        "saved.as": "\n".join(
            [*program, ".TRANS", *trans, ".END", ".REALS", *reals, ".END", ".STRINGS", *texts, ".END", ""]
        )
    }


def _oat(p: FloatArray, R: FloatArray) -> str:
    a = np.arctan2(np.hypot(R[0, 2], R[1, 2]), R[2, 2])
    o = np.arctan2(R[1, 2], R[0, 2]) if np.sin(a) > 1e-9 else 0.0
    S = np.array([[np.cos(o), np.sin(o), 0], [-np.sin(o), np.cos(o), 0], [0, 0, 1.0]]) @ R
    c, s = np.cos(a), np.sin(a)
    t = np.arctan2(S[1, 0], S[1, 1])
    assert abs(S[2, 2] - c) < 1e-9
    assert abs(S[0, 2] - s) < 1e-9
    return " ".join(f"{v:.6f}" for v in (*p, *np.degrees([o, a, t])))


def _rows(
    plan: TouchPlan, stored: Stored, frame: RigidTransform | None = None
) -> list[tuple[str, int, FloatArray, FloatArray]]:
    """Return name, outcome, place and posture of each search, relative to the frame that the controller has."""
    T = (plan.T_base_part if frame is None else frame).inverse() @ plan.T_base_part.relabelled(
        target="base", source="planned"
    )
    rows = []
    for search in plan.searches:
        value = stored[search.name]
        found = not isinstance(value, Outcome)
        number = STORED_NUMBERS[Outcome.FOUND if found else value]
        p = T.apply(np.asarray(value)) if found else np.zeros(3)
        rows.append((search.name.upper(), number, p, T.R @ search.R_part_tool if found else np.eye(3)))
    return rows


WRITERS: dict[str, Callable[[TouchPlan, Stored], dict[str, str]]] = {
    "rapid": rapid,
    "krl": krl,
    "fanuc": fanuc,
    "inform": inform,
    "urscript": urscript,
    "as": kawasaki,
}
DIGITS_MM = {"rapid": 1e-5, "krl": 1e-5, "fanuc": 1e-3, "inform": 1e-3, "urscript": 1e-5, "as": 1e-5}
"""What the last digit of a place leaves."""
