"""What the text of a PDL2 program says."""

from __future__ import annotations

from wpcal.controllers.comau.read import read_pdl2
from wpcal.controllers.language.grammar import Does, Grammar, rule

_TO = r"^[ \t]*+MOVE(?:FLY)?[ \t]++{}[ \t]++TO[ \t]++"
GRAMMAR = Grammar(
    comment=r"^[ \t]*+--",
    harmless=r"DELAY \d+|\$DOUT\[\d+\] := (?:TRUE|FALSE|ON|OFF)|WAIT FOR \$DIN\[\d+\]|PAUSE|"
    r"WRITE(?: LUN_CRT)? ?\('[^']*'(?:, ?NL)?\)",
    rules=(
        rule(r"^[ \t]*+arc_start\(", Does.ON),
        rule(r"^[ \t]*+arc_end\b", Does.OFF),
        rule(_TO.format("CIRCULAR") + r"(?P<b>\w++)[ \t]++VIA[ \t]++(?P<a>\w++)", Does.MOVE, kind="C"),
        rule(_TO.format("(?P<kind>JOINT|LINEAR)") + r"(?P<a>\w++)", Does.MOVE),
        rule(r"^[ \t]*+END\b", Does.STOP),
    ),
    read=read_pdl2,
    poses_in=(".pdl",),
    stated_output=r"\$DOUT\[(\d{1,9}+)\] switches the arc",
    set_output=r"^[ \t]*+\$DOUT\[{number}\][ \t]*+:=[ \t]*+{state}\b",
)
