"""KRL source: routines as statements with their blocks, and data lists."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

from wpcal.controllers.kuka.values import GRAMMAR
from wpcal.controllers.language.grammar import mark_of
from wpcal.controllers.run.expressions import tokens_of, without_comment
from wpcal.controllers.run.program import ProgramError

BLOCKS = {"FOR": "ENDFOR", "WHILE": "ENDWHILE", "LOOP": "ENDLOOP", "REPEAT": "UNTIL"}
PLAIN = {"WAIT", "PTP", "LIN", "CIRC", "SPTP", "SLIN", "SCIRC", "TRIGGER", "PTP_REL", "LIN_REL", "CIRC_REL"}
"""Words whose line may hold ``=`` and is no assignment."""
MARK = "MARK"  #: The word of a comment that marks a seam.
MOST_NAME = 24  #: Characters of a name.
MOST_BLOCKS = 30  #: In one another.


class SourceLine(NamedTuple):
    """One line that is not empty."""

    number: int
    tokens: list[str]
    text: str

    @property
    def word(self) -> str:
        """The first token."""
        return self.tokens[0].upper()


@dataclass
class KrlStatement:
    """One instruction: its word, the rest of its tokens, and what belongs to it."""

    word: str
    line: SourceLine
    tokens: list[str]
    parts: list[list[str]] = field(default_factory=list)
    blocks: list[list[KrlStatement]] = field(default_factory=list)


@dataclass
class KrlRoutine:
    """A subprogram."""

    file: str
    parameters: list[str]
    body: list[KrlStatement]


def lines_of(text: str, file: str) -> list[SourceLine]:
    """Return the lines with tokens: without comments, folds and file attributes, but for the marks of seams."""
    found = []
    for number, line in enumerate(text.splitlines(), 1):
        bare, comment = (part.strip() for part in without_comment(line, ";"))
        if not bare and mark_of(comment) is not None:
            found.append(SourceLine(number, [MARK, comment], line))
        elif bare and not bare.startswith("&"):
            try:
                found.append(SourceLine(number, tokens_of(bare, GRAMMAR), bare))
            except ProgramError as error:
                raise ProgramError(error.what, path=file, line=number) from None
    return found


def read_data(text: str, file: str) -> list[tuple[str, str, SourceLine, list[str]]]:
    """Return type, name, line and value of each variable of a data list."""
    lines = [line for line in lines_of(text, file) if line.word != MARK]
    if not lines or lines[0].word != "DEFDAT" or lines[-1].word != "ENDDAT":
        raise ProgramError("a data list begins with DEFDAT and ends with ENDDAT", path=file)
    found: dict[str, tuple[str, str, SourceLine, list[str]]] = {}
    for line in lines[1:-1]:
        tokens = [one for one in line.tokens if one.upper() not in {"GLOBAL", "CONST"}]
        words = [one.upper() for one in tokens]
        if words[0] in {"EXT", "EXTFCT", "SIGNAL", "ENUM", "STRUC"}:
            continue
        if words[0] == "DECL" and len(words) > 2:
            kind, name = words[1], words[2]
            if name in found:
                raise ProgramError(f"{name} is declared twice", path=file, line=line.number)
            if len(name) > MOST_NAME:
                raise ProgramError(f"{name} has more than {MOST_NAME} characters", path=file, line=line.number)
            found[name] = (kind, name, line, tokens[tokens.index("=") + 1 :] if "=" in tokens else [])
        elif words[1:4] == ["[", "]", "="] and words[0] in found:
            found[words[0]] = (found[words[0]][0], words[0], line, tokens[4:])
        else:
            raise ProgramError(f"{line.text[:40]!r} is no declaration", path=file, line=line.number)
    return list(found.values())


def read_source(text: str, file: str) -> dict[str, KrlRoutine]:
    """Return the routines of a source file by name."""
    return _Source(text, file).routines()


class _Source:
    """Reads one source file."""

    def __init__(self, text: str, file: str) -> None:
        self.file, self.lines, self.at, self.depth = file, lines_of(text, file), 0, 0

    def routines(self) -> dict[str, KrlRoutine]:
        found: dict[str, KrlRoutine] = {}
        while self.at < len(self.lines):
            line = self.take()
            if line.word == MARK:
                continue
            words = [one.upper() for one in line.tokens if one.upper() != "GLOBAL"]
            if words[0] != "DEF" or len(words) < 2:
                raise self.fault(line, "is outside a routine")
            inside = [word for word in words[3:-1] if word not in {",", ":", "IN", "OUT"}]
            found[words[1]] = KrlRoutine(self.file, inside, self.block({"END"}))
            self.take()
        return found

    def fault(self, line: SourceLine, what: str) -> ProgramError:
        return ProgramError(f"{line.text[:40]!r} {what}", path=self.file, line=line.number)

    def take(self) -> SourceLine:
        if self.at >= len(self.lines):
            last = self.lines[-1].number if self.lines else 1
            raise ProgramError("ends within a block", path=self.file, line=last)
        self.at += 1
        return self.lines[self.at - 1]

    def word(self) -> str:
        return self.lines[self.at].word if self.at < len(self.lines) else ""

    def block(self, ends: set[str]) -> list[KrlStatement]:
        """Take statements up to one of the words, and leave this."""
        self.depth += 1
        if self.depth > MOST_BLOCKS:
            raise ProgramError(f"more than {MOST_BLOCKS} blocks in one another", path=self.file)
        found = []
        while self.word() not in ends:
            line = self.take()
            found.append(self.compound(line) or simple(line))
        self.depth -= 1
        return found

    def compound(self, line: SourceLine) -> KrlStatement | None:
        """Return a statement with blocks; None for another."""
        tokens, word = line.tokens, line.word
        words = [one.upper() for one in tokens]
        if word == "IF":
            if words[-1] != "THEN":
                raise self.fault(line, "has no THEN")
            yes, no = self.block({"ELSE", "ENDIF"}), list[KrlStatement]()
            if self.take().word == "ELSE":
                no = self.block({"ENDIF"})
                self.take()
            return KrlStatement("IF", line, tokens[1:-1], [], [yes, no])
        if word == "SWITCH":
            return self.switch(line)
        if word not in BLOCKS:
            return None
        body = self.block({BLOCKS[word]})
        end = self.take()
        if word != "FOR":
            return KrlStatement(word, line, (end if word == "REPEAT" else line).tokens[1:], [], [body])
        if "=" not in words or "TO" not in words:
            raise self.fault(line, "is no FOR")
        equals, to = words.index("="), words.index("TO")
        step = words.index("STEP") if "STEP" in words else len(words)
        parts = [tokens[1:equals], tokens[equals + 1 : to], tokens[to + 1 : step], tokens[step + 1 :]]
        return KrlStatement("FOR", line, [], parts, [body])

    def switch(self, line: SourceLine) -> KrlStatement:
        statement = KrlStatement("SWITCH", line, line.tokens[1:])
        case = self.take()
        while case.word != "ENDSWITCH":
            if case.word not in {"CASE", "DEFAULT"}:
                raise self.fault(case, "is no CASE")
            statement.parts.append(case.tokens[1:])
            statement.blocks.append(self.block({"CASE", "DEFAULT", "ENDSWITCH"}))
            case = self.take()
        return statement


def simple(line: SourceLine) -> KrlStatement:
    """Return the statement of one line."""
    tokens, word = line.tokens, line.word
    if word in {"GLOBAL", "INTERRUPT"}:
        return KrlStatement("INTERRUPT", line, tokens)
    if word == "DECL":
        return KrlStatement("DECL", line, tokens[1:2], [[token for token in tokens[2:] if token != ","]])
    if "=" in tokens and word not in PLAIN:
        equals = tokens.index("=")
        return KrlStatement("ASSIGN", line, [], [tokens[:equals], tokens[equals + 1 :]])
    if tokens[1:2] == ["("] and tokens[-1] == ")" and word != "WAIT":
        return KrlStatement("CALL", line, [tokens[0]], [tokens[2:-1]])
    return KrlStatement(word, line, tokens[1:])


def called_in(statements: Sequence[KrlStatement]) -> Iterator[str]:
    """Yield the names of subprograms that statements call, and their interrupts."""
    for each in statements:
        if each.word == "CALL":
            yield each.tokens[0].upper()
        elif each.word == "INTERRUPT":
            yield from (token.upper() for token in each.tokens)
        for body in each.blocks:
            yield from called_in(body)
