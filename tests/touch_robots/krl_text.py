"""KRL source: routines as statements with their blocks, and data lists."""

from __future__ import annotations

import re
from dataclasses import dataclass, field

from tests.touch_robots.robot import ProgramError

END = {"IF": "ENDIF", "FOR": "ENDFOR", "WHILE": "ENDWHILE", "SWITCH": "ENDSWITCH", "LOOP": "ENDLOOP"}


@dataclass
class Statement:
    """One instruction: its word, the rest of its tokens, and what belongs to it."""

    word: str
    tokens: list[str]
    parts: list[list[str]] = field(default_factory=list)
    blocks: list[list[Statement]] = field(default_factory=list)


@dataclass
class Routine:
    parameters: list[str]
    body: list[Statement]


def lines_of(text: str, token: re.Pattern[str]) -> list[list[str]]:
    """Return the tokens of every line that is not empty: comments, folds and file attributes are left out."""
    found = []
    for line in text.splitlines():
        bare = re.sub(r'^((?:[^";]|"[^"]*")*);.*', r"\1", line).strip()
        if not bare or bare.startswith("&"):
            continue
        tokens = [match[0] for match in token.finditer(bare)]
        if "".join(tokens) != re.sub(r'("[^"]*")|\s+', lambda m: m[1] or "", bare):
            raise ProgramError(f"cannot be read: {bare!r}")
        found.append(tokens)
    return found


def read_data(text: str, token: re.Pattern[str]) -> list[tuple[str, str, list[str]]]:
    """Return type, name and value of each variable of a data list."""
    lines = lines_of(text, token)
    if lines[0][0].upper() != "DEFDAT" or lines[-1][0].upper() != "ENDDAT":
        raise ProgramError("a data list begins with DEFDAT and ends with ENDDAT")
    found: dict[str, tuple[str, str, list[str]]] = {}
    for tokens in lines[1:-1]:
        words = [one.upper() for one in tokens]
        if words[0] == "EXT":
            continue
        if words[0] == "DECL":
            words, rest = [w for w in words if w != "GLOBAL"], [t for t in tokens if t.upper() != "GLOBAL"]
            kind, name = words[1], words[2]
            if name in found:
                raise ProgramError(f"{name} is declared twice")
            if len(name) > 24:
                raise ProgramError(f"{name} has more than 24 characters")
            value = rest[rest.index("=") + 1 :] if "=" in rest else []
            found[name] = (kind, name, value)
        elif words[1:4] == ["[", "]", "="] and words[0] in found:
            found[words[0]] = (found[words[0]][0], words[0], tokens[4:])
        else:
            raise ProgramError(f"{' '.join(tokens)} is no declaration")
    return list(found.values())


def read_source(text: str, token: re.Pattern[str]) -> dict[str, Routine]:
    """Return the routines of a source file by name."""
    lines, routines, at = lines_of(text, token), {}, 0
    while at < len(lines):
        tokens = lines[at]
        words = [one.upper() for one in tokens]
        is_global = words[0] == "GLOBAL"
        if words[is_global] != "DEF":
            raise ProgramError(f"{' '.join(tokens)} is outside a routine")
        name = words[is_global + 1]
        inside = [w for w in words[is_global + 3 : -1] if w not in {",", ":", "IN", "OUT"}]
        body, at = _block(lines, at + 1, {"END"})
        routines[name] = Routine(inside, body)
        at += 1
    return routines


def _block(lines: list[list[str]], at: int, ends: set[str]) -> tuple[list[Statement], int]:
    found = []
    while lines[at][0].upper() not in ends:
        statement, at = _statement(lines, at)
        found.append(statement)
        if at >= len(lines):
            raise ProgramError(f"expected {sorted(ends)} at the end of the file")
    return found, at


def _statement(lines: list[list[str]], at: int) -> tuple[Statement, int]:
    tokens = lines[at]
    word = tokens[0].upper()
    if word == "GLOBAL" and tokens[1].upper() == "INTERRUPT":
        return Statement("INTERRUPT", tokens), at + 1
    if word == "INTERRUPT":
        return Statement("INTERRUPT", tokens), at + 1
    if word == "DECL":
        return Statement("DECL", tokens[1:2], [[t for t in tokens[2:] if t != ","]]), at + 1
    if word == "IF":
        if tokens[-1].upper() != "THEN":
            raise ProgramError("IF without THEN")
        yes, at = _block(lines, at + 1, {"ELSE", "ENDIF"})
        no: list[Statement] = []
        if lines[at][0].upper() == "ELSE":
            no, at = _block(lines, at + 1, {"ENDIF"})
        return Statement("IF", tokens[1:-1], [], [yes, no]), at + 1
    if word == "FOR":
        equals, to = tokens.index("="), [t.upper() for t in tokens].index("TO")
        body, at = _block(lines, at + 1, {"ENDFOR"})
        return Statement("FOR", [], [tokens[1:equals], tokens[equals + 1 : to], tokens[to + 1 :]], [body]), at + 1
    if word == "WHILE":
        body, at = _block(lines, at + 1, {"ENDWHILE"})
        return Statement("WHILE", tokens[1:], [], [body]), at + 1
    if word == "SWITCH":
        return _switch(lines, at)
    if "=" in tokens and word not in {"WAIT", "PTP", "LIN"}:
        equals = tokens.index("=")
        return Statement("ASSIGN", [], [tokens[:equals], tokens[equals + 1 :]]), at + 1
    if len(tokens) > 1 and tokens[1] == "(" and tokens[-1] == ")" and word not in {"WAIT"}:
        return Statement("CALL", [tokens[0]], [tokens[2:-1]]), at + 1
    return Statement(word, tokens[1:]), at + 1


def _switch(lines: list[list[str]], at: int) -> tuple[Statement, int]:
    statement = Statement("SWITCH", lines[at][1:])
    at += 1
    while lines[at][0].upper() != "ENDSWITCH":
        if lines[at][0].upper() not in {"CASE", "DEFAULT"}:
            raise ProgramError("SWITCH without CASE")
        statement.parts.append(lines[at][1:])
        body, at = _block(lines, at + 1, {"CASE", "DEFAULT", "ENDSWITCH"})
        statement.blocks.append(body)
    return statement, at + 1
