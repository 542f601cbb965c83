"""How an application switches the arc: by a digital output of the user (``doArc``), or by two of the user's programs.

VAL3 has no arc instructions of its own. ``doArc`` or the programs ``arcStart(nJob)`` and ``arcEnd()`` are added to the
application by the user, as the tool is.

References
----------
Staubli, VAL3 Reference Manual (dio, call, delay, waitEndMove).
"""

from __future__ import annotations

from wpcal.controllers.arc_settings import ArcSettings
from wpcal.controllers.arc_values import end_time_s, require_no_weave
from wpcal.controllers.program import WeldPath

LANGUAGE = "VAL3"


def how(arc: ArcSettings | None) -> str:
    """Say in the header how the arc is switched."""
    if arc is None:
        return "the arc burns from ARC ON to ARC OFF"
    if arc.output is not None:
        return f"and the dio doArc, linked to output {arc.output}, which switches the arc"
    return "and the programs arcStart(nJob) and arcEnd()"


def start_lines(path: WeldPath, arc: ArcSettings) -> list[str]:
    """Return the lines that start the arc.

    Raises
    ------
    InputError
        When the weld data states a weave, which an application cannot carry out.
    """
    require_no_weave(path, language=LANGUAGE)
    switch = f"call arcStart({path.values.job or 0})" if arc.output is None else "doArc=true"
    return [f"  {switch}", *_delay(path.values.start_delay_s or 0.0)]


def end_lines(path: WeldPath, arc: ArcSettings) -> list[str]:
    """Return the lines that end the arc."""
    switch = "call arcEnd()" if arc.output is None else "doArc=false"
    return [*_delay(end_time_s(path)), f"  {switch}"]


def _delay(seconds: float) -> list[str]:
    return [f"  delay({seconds:g})"] if seconds > 0.0 else []
