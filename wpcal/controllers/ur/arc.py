"""How a script switches the arc: by a digital output, or by two functions that the user has (`arc_start`, `arc_end`).

URScript has no arc instructions of its own; the power source's URCap or interface decides what happens.

References
----------
Universal Robots, The URScript Programming Language (set_standard_digital_out, sleep).
"""

from __future__ import annotations

from wpcal.controllers.program.arc import ArcSettings, ArcSwitch

SWITCH = ArcSwitch(
    language="URScript",
    start="arc_start({job})",
    end="arc_end()",
    on="set_standard_digital_out({output}, True)",
    off="set_standard_digital_out({output}, False)",
    wait="sleep({seconds})",
)


def how(arc: ArcSettings) -> str:
    """Say in the header how the arc is switched."""
    if arc.output is not None:
        return f"standard digital output {arc.output} switches the arc"
    return "arc_start(job) and arc_end() are functions that you load before this program"
