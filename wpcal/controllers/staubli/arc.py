"""How an application switches the arc: by a digital output of the user (``doArc``), or by two of the user's programs.

VAL3 has no arc instructions of its own. ``doArc`` or the programs ``arcStart(nJob)`` and ``arcEnd()`` are added to the
application by the user, as the tool is.

References
----------
Staubli, VAL3 Reference Manual (dio, call, delay, waitEndMove).
"""

from __future__ import annotations

from wpcal.controllers.program.arc import ArcSettings, ArcSwitch

SWITCH = ArcSwitch(
    language="VAL3",
    start="call arcStart({job})",
    end="call arcEnd()",
    on="doArc=true",
    off="doArc=false",
    wait="delay({seconds})",
)


def how(arc: ArcSettings | None) -> str:
    """Say in the header how the arc is switched."""
    if arc is None:
        return "the arc burns from ARC ON to ARC OFF"
    if arc.output is not None:
        return f"and the dio doArc, linked to output {arc.output}, which switches the arc"
    return "and the programs arcStart(nJob) and arcEnd()"
