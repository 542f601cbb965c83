"""What the text of a PDL2 program says."""

from __future__ import annotations

from wpcal.controllers.comau.read import read_pdl2
from wpcal.controllers.language.grammar import Grammar

GRAMMAR = Grammar(
    comment=r"^[ \t]*+--",
    harmless=r"DELAY \d+|\$DOUT\[\d+\] := (?:TRUE|FALSE|ON|OFF)|WAIT FOR \$DIN\[\d+\]|PAUSE|"
    r"WRITE(?: LUN_CRT)? ?\('[^']*'(?:, ?NL)?\)",
    read=read_pdl2,
    poses_in=(".pdl",),
    stated_output=r"\$DOUT\[(\d{1,9}+)\] switches the arc",
)
