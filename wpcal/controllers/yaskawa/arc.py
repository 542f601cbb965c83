"""Arc instructions of INFORM: ``ARCON``, ``ARCOF``, ``WVON``, ``WVOF``.

With a job, the files of conditions of that number are used (``ASF#``, ``AEF#``). Without one the values are stated:
``ARCON AC=current AV=voltage T=delay``. A weave is always a file (``WEV#``): its plane depends on the wall.

References: Yaskawa, YRC1000 Operator's Manual for Arc Welding, and INFORM Language (ARCON, ARCOF, WVON, WVOF).
"""

from __future__ import annotations

from wpcal.controllers.program import WeldPath
from wpcal.controllers.program.arc import end_time_s, needed, refuse

LANGUAGE = "INFORM"
LEAST_S = 0.01  #: Of a timer; less is none.
VALUES = "without a job the values are written"


def inform_arc_on(path: WeldPath) -> list[str]:
    """Return the instructions that start the arc and the weave.

    Raises `InputError` when the weld data states neither a job nor current and voltage, or a weave without the number
    of its file.
    """
    values = path.values
    if values.job is not None:
        arc = f"ARCON ASF#({values.job})"
    else:
        current = needed(path, "current_a", language=LANGUAGE, why=VALUES)
        voltage = needed(path, "voltage_v", language=LANGUAGE, why=VALUES)
        arc = f"ARCON AC={current:.0f} AV={voltage:.1f}{_timer(values.start_delay_s or 0.0)}"
    return [arc, *_weave(path)]


def inform_arc_off(path: WeldPath) -> list[str]:
    """Return the instructions that end the arc and the weave."""
    values, crater = path.values, path.values.crater
    if values.job is not None:
        arc = f"ARCOF AEF#({values.job})"
    elif end_time_s(path) >= LEAST_S:
        current = needed(path, "current_a", language=LANGUAGE, why=VALUES)
        voltage = needed(path, "voltage_v", language=LANGUAGE, why=VALUES)
        if crater is not None:
            current, voltage = crater.current_a or current, crater.voltage_v or voltage
        arc = f"ARCOF AC={current:.0f} AV={voltage:.1f}{_timer(end_time_s(path))}"
    else:
        arc = "ARCOF"
    return [arc, *(["WVOF"] if _weave(path) else [])]


def _timer(seconds: float) -> str:
    return f" T={seconds:.2f}" if seconds >= LEAST_S else ""


def _weave(path: WeldPath) -> list[str]:
    values = path.values
    if values.weave_data is None:
        if values.weave is not None:
            raise refuse(path, "weave", language=LANGUAGE, why="state weave_data, the number of its file (WEV#)")
        return []
    if not values.weave_data.isdigit():
        raise refuse(path, "weave_data", language=LANGUAGE, why="expected the number of a file (WEV#)")
    return [f"WVON WEV#({int(values.weave_data)})"]
