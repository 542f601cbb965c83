"""What the text of an AS file says."""

from __future__ import annotations

from wpcal.controllers.kawasaki.read import read_as
from wpcal.controllers.language.grammar import Does, Grammar, rule

_POINT = r"\b(?:[ \t]++(?P<a>[\w.]++))?"
GRAMMAR = Grammar(
    comment=r"^[ \t]*+;",
    harmless=r'TWAIT [\d.]+|(?:SW|)WAIT SIG\(-?\d+\)|SWAIT -?\d+|SIGNAL -?\d+(?:, ?-?\d+)*|PRINT "[^"]*"|PAUSE',
    rules=(
        rule(r"^[ \t]*+(?P<kind>[LJ])WS" + _POINT, Does.ON),
        rule(r"^[ \t]*+(?P<kind>[LJ])WE" + _POINT, Does.MOVE, Does.OFF),
        rule(r"^[ \t]*+(?P<kind>[LJ])(?:MOVE|WC)" + _POINT, Does.MOVE),
        rule(r"^[ \t]*+C1(?:MOVE|WC)" + _POINT, Does.MOVE, kind="V"),
        rule(r"^[ \t]*+C2(?:MOVE|WC)" + _POINT, Does.MOVE, kind="C"),
        rule(r"^[ \t]*+HOME\b", Does.MOVE),
        rule(r"^\.END\b", Does.STOP),
    ),
    read=read_as,
    poses_in=(".as",),
    touches={".as": r"\bwpto_\w+"},
    results=r"wptp_",
)
