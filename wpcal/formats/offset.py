"""The part's place as the datum of a machine tool, so that its own programs in part coordinates run on the real part.

The place is that in `base`, which has to be the coordinates of the machine. Sinumerik turns by RPY angles (about Z, the
new Y, the new X), Heidenhain by spatial angles about fixed axes (A, then B, then C): both are R = Rz Ry Rx. The
rotation of a G54 is about Z only; what is left out is told in the file.

References: Siemens, SINUMERIK 840D sl Function Manual, Basic Functions, K2: Frames. Heidenhain, iTNC 530 User's Manual,
PLANE SPATIAL. Yin et al. (2003), section 5.
"""

from textwrap import wrap

import numpy as np

from wpcal.controllers.language.naming import NameRules, safe_name
from wpcal.controllers.program import WeldProgram
from wpcal.controllers.program.describe import describe
from wpcal.controllers.registry import Exporter
from wpcal.core.rotations import zyx_angles

NAMES = NameRules("a datum", 24)  #: For the names of the files.
LEVEL_DEG = 0.001  #: A part that is tilted by less needs no tilted plane.


def write_offset(program: WeldProgram) -> dict[str, str]:
    """Write ``NAME.nc`` (G54 and rotation), ``NAME.SPF`` (Sinumerik) and ``NAME.H`` (Heidenhain)."""
    T = program.T_base_part
    name = safe_name(program.controller.program_name, NAMES)
    p = dict(zip("XYZ", T.t_mm.tolist(), strict=True))
    a, b, c = np.degrees(zyx_angles(T.R)).tolist()
    about = [line for each in describe(program)[:3] for line in wrap(each, 72, subsequent_indent="  ")]
    return {
        f"{name}.nc": _g54(about, p, (a, b, c)),
        f"{name}.SPF": _lines(
            [f"; {line}" for line in about],
            f"$P_UIFR[1]=CTRANS({','.join(f'{axis},{value:.4f}' for axis, value in p.items())})"
            f":CROT(X,{a:.6f},Y,{b:.6f},Z,{c:.6f}) ; MD10600 = 1",
            "G54",
            "M17",
        ),
        f"{name}.H": _lines(
            [f"BEGIN PGM {name} MM", *(f"; {line}" for line in about)],
            "CYCL DEF 7.0 DATUM SHIFT",
            *(f"CYCL DEF 7.{row} {axis}{value:+.4f}" for row, (axis, value) in enumerate(p.items(), 1)),
            f"PLANE SPATIAL SPA{a:+.6f} SPB{b:+.6f} SPC{c:+.6f} STAY",
            f"END PGM {name} MM",
        ),
    }


def _g54(about: list[str], p: dict[str, float], turn: tuple[float, float, float]) -> str:
    a, b, c = turn
    tilt = float(np.hypot(a, b))
    told = "(level: nothing is left out)"
    if tilt > LEVEL_DEG:
        off = 100.0 * np.sin(np.radians(tilt))
        told = f"(NOT LEVEL: A {a:.4f} and B {b:.4f} deg are left out; 100 mm away that is {off:.2f} mm)"
    head = [f"({line.replace('(', '[').replace(')', ']')})" for line in about]
    return _lines(
        ["%", *head, told],
        "G10 L2 P1 " + " ".join(f"{axis}{value:.4f}" for axis, value in p.items()),
        "G54",
        f"G68 X0. Y0. R{c:.6f}",
        "%",
    )


def _lines(head: list[str], *body: str) -> str:
    return "\n".join([*head, *body]) + "\n"


OFFSET = Exporter(
    "offset", "machine tools: the part's datum as G54 with rotation, Sinumerik frame, Heidenhain plane", write_offset
)
