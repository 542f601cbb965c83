"""Arc instructions of FANUC ArcTool: ``Weld Start[procedure, schedule]``, ``Weld End[…]``, and weaves.

The schedule holds current, voltage, delays and crater; a program states its number. A weave is stated with its values,
``Weave Sine[Hz, mm, s, s]``, or by the number of its schedule. The amplitude is from the middle to one side.

References: FANUC, R-30iB ArcTool Operator's Manual (weld start, weld end, weave instructions).
"""

from __future__ import annotations

from wpcal.controllers.program import WeldPath
from wpcal.controllers.program.arc import has_weave, needed, refuse
from wpcal.weld.values import WeaveShape

PROCEDURE = 1  #: The weld procedure whose schedules are used.
SHAPES = {WeaveShape.SINE: "Sine", WeaveShape.ZIGZAG: "Sine", WeaveShape.CIRCLE: "Circle"}
"""Words of weaves; a sine is the nearest to a zigzag."""
LANGUAGE = "FANUC"


def tp_arc_on(path: WeldPath, speed_mm_s: float) -> list[str]:
    """Return the instructions that start the arc and the weave.

    Raises `InputError` when the weld data states no schedule (job), or a weave that TP does not have.
    """
    return [f"  Weld Start[{PROCEDURE},{_schedule(path)}]", *_weave(path, speed_mm_s)]


def tp_arc_off(path: WeldPath) -> list[str]:
    """Return the instructions that end the arc and the weave."""
    return [f"  Weld End[{PROCEDURE},{_schedule(path)}]", *(["  Weave End"] if has_weave(path) else [])]


def _schedule(path: WeldPath) -> int:
    return int(needed(path, "job", language=LANGUAGE, why=f"needs the number of a schedule of procedure {PROCEDURE}"))


def _weave(path: WeldPath, speed_mm_s: float) -> list[str]:
    values = path.values
    shape = WeaveShape.SINE if values.weave is None else values.weave.shape
    if values.weave_data is not None:
        if not values.weave_data.isdigit():
            raise refuse(path, "weave_data", language=LANGUAGE, why="expected the number of a weave schedule")
        return [f"  Weave {SHAPES.get(shape, 'Sine')}[{int(values.weave_data)}]"]
    if values.weave is None:
        return []
    if shape not in SHAPES:
        raise refuse(path, "weave", language=LANGUAGE, why=f"TP has no {shape.value}; state sine or circle")
    if values.weave.dwell_left_s != values.weave.dwell_right_s:
        raise refuse(path, "weave", language=LANGUAGE, why="different dwells need a schedule; state weave_data")
    dwell = f"{values.weave.dwell_left_s:.3f}s"
    hertz, amplitude = values.weave.frequency_hz(speed_mm_s), values.weave.width_mm / 2.0
    return [f"  Weave {SHAPES[shape]}[{hertz:.1f}Hz,{amplitude:.1f}mm,{dwell},{dwell}]"]
