"""What the text of an AS file says."""

from __future__ import annotations

from wpcal.controllers.kawasaki.read import read_as
from wpcal.controllers.language.grammar import Grammar

GRAMMAR = Grammar(
    comment=r"^[ \t]*+;",
    harmless=r"(?:ACCEL|DECEL|TWAIT|W1SET|W2SET)\b.*|(?:SW|)WAIT SIG\(-?\d+\)|SWAIT -?\d+|"
    r'SIGNAL -?\d+(?:, ?-?\d+)*|PRINT "[^"]*"|PAUSE',
    read=read_as,
    poses_in=(".as",),
    touches={".as": r"\bwpto_\w+"},
    results=r"wptp_",
)
