"""How a script switches the arc: by a digital output, or by two functions that the user has (`arc_start`, `arc_end`).

URScript has no arc instructions of its own; the power source's URCap or interface decides what happens.

References
----------
Universal Robots, The URScript Programming Language (set_standard_digital_out, sleep).
"""

from __future__ import annotations

from wpcal.controllers.arc_settings import ArcSettings
from wpcal.controllers.arc_values import end_time_s, require_no_weave
from wpcal.controllers.program import WeldPath

LANGUAGE = "URScript"


def how(arc: ArcSettings) -> str:
    """Say in the header how the arc is switched."""
    if arc.output is not None:
        return f"standard digital output {arc.output} switches the arc"
    return "arc_start(job) and arc_end() are functions that you load before this program"


def start_lines(path: WeldPath, arc: ArcSettings) -> list[str]:
    """Return the lines that start the arc.

    Raises
    ------
    InputError
        When the weld data states a weave, which a script cannot carry out.
    """
    require_no_weave(path, language=LANGUAGE)
    switch = f"arc_start({path.values.job or 0})" if arc.output is None else _output(arc.output, is_on=True)
    return [f"  {switch}", *_sleep(path.values.start_delay_s or 0.0)]


def end_lines(path: WeldPath, arc: ArcSettings) -> list[str]:
    """Return the lines that end the arc."""
    switch = "arc_end()" if arc.output is None else _output(arc.output, is_on=False)
    return [*_sleep(end_time_s(path)), f"  {switch}"]


def _output(number: int, *, is_on: bool) -> str:
    return f"set_standard_digital_out({number}, {is_on})"


def _sleep(seconds: float) -> list[str]:
    return [f"  sleep({seconds:g})"] if seconds > 0.0 else []
