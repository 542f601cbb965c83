"""Languages of blocks (IF … ELSE … END): their lines as a tree, and how it runs."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import count
from typing import Any

from wpcal.controllers.language.grammar import Does
from wpcal.controllers.run.expressions import Parser, Syntax, tokens_of, without_comment
from wpcal.controllers.run.interpreter import MOST_BLOCKS, Interpreter
from wpcal.controllers.run.machine import ProgramError

Row = tuple[int, str]  #: Number of a line of the file, and its text without what ends it.


@dataclass
class Node:
    """A line, and what is in its block: each branch has its own head (IF, ELSE …)."""

    line: int
    text: str
    branches: list[tuple[str, list[Node]]] = field(default_factory=list)
    close: str = ""  #: The line that ends the block.


@dataclass(frozen=True, slots=True)
class Steps:
    """A routine of a file."""

    file: str
    parameters: Sequence[str]
    body: Sequence[Node]
    line: int = 0


class LeaveError(Exception):
    """The routine ends with this value."""

    def __init__(self, value: Any = None) -> None:
        self.value = value


class BreakError(Exception):
    """The innermost loop ends."""


class JumpError(Exception):
    """A jump to a label."""

    def __init__(self, label: str) -> None:
        self.label = label


def rows_of(text: str, mark: str, quote: str = '"', *, first: int = 1) -> list[Row]:
    """Return lines without remarks, which begin with `mark`; a line that is only a remark stays."""
    found = list[Row]()
    for number, row in enumerate(text.splitlines(), first):
        bare, remark = (part.strip() for part in without_comment(row, mark, quote))
        if bare or remark:
            found.append((number, bare or f"{mark}{remark}"))
    return found


def tree(rows: Iterable[Row], file: str, *, begins: str, turns: str, ends: str) -> list[Node]:
    """Return lines as a tree: `begins` is the pattern of heads, `turns` and `ends` are the words of ELSE and END."""
    top: list[Node] = []
    stack: list[Node] = []
    bodies = [top]
    for line, text in rows:
        word = re.split(r"[\s(:]", text, maxsplit=1)[0].upper()
        if stack and word in turns.split():
            bodies[-1] = []
            stack[-1].branches.append((text, bodies[-1]))
        elif stack and word in ends.split():
            stack.pop().close = text
            bodies.pop()
        else:
            node = Node(line, text)
            bodies[-1].append(node)
            if re.match(begins, text, re.IGNORECASE):
                node.branches.append((text, []))
                stack.append(node)
                bodies.append(node.branches[0][1])
        if len(stack) > MOST_BLOCKS:
            raise ProgramError(f"more than {MOST_BLOCKS} blocks in one another", path=file, line=line)
    if stack:
        raise ProgramError("a block has no end", path=file, line=stack[-1].line)
    return top


def text_of(nodes: Sequence[Node]) -> str:
    """Return lines with all that is in their blocks."""
    return "\n".join(
        "\n".join([node.text, *(f"{head}\n{text_of(body)}" for head, body in node.branches)]) for node in nodes
    )


class BlockInterpreter(Interpreter):
    """Runs the routines of a language of blocks."""

    words: Syntax
    PARSER = Parser  #: What reads expressions.
    COMMENT: str  #: How a remark begins.
    BREAK = "BREAK"  #: The word that ends the innermost loop.
    FOR = ("=", "TO", "STEP", "")  #: What is before the first value, the last and the step, and at the end of the line.
    FUNCTIONS: Mapping[str, Callable[..., Any]] = {}  #: Of the language, lower case; they get the interpreter first.
    RETURNS = True  #: Whether routines of the program are functions, too.
    ARCS: Mapping[str, Does] = {}  #: Routines of the user that switch the arc, where the files do not hold them.

    def __init__(self, *args: Any, **given: Any) -> None:
        self.routines: dict[str, Steps] = {}
        self.values: dict[str, Any] = {}
        self.locals: list[dict[str, Any]] = [{}]
        super().__init__(*args, **given)

    def bodies(self) -> Mapping[str, str]:
        """Return the texts of the routines that take no values, by name."""
        return {name: text_of(one.body) for name, one in self.routines.items() if not one.parameters}

    def lines(self) -> Iterator[tuple[str, int]]:
        """Yield file and number of each line that can run."""
        for one in self.steps_of():
            front = [*one.body]
            while front:
                node = front.pop()
                yield one.file, node.line
                front += [each for _, body in node.branches for each in body]

    def steps_of(self) -> Iterable[Steps]:
        """Return all that can run as routines."""
        return self.routines.values()

    def value(self, text: str | list[str]) -> Any:
        """Return the value of an expression."""
        return self.parser(tokens_of(text, self.words) if isinstance(text, str) else text).whole()

    def listed(self, text: str | list[str]) -> list[Any]:
        """Return values between commas."""
        return self.parser([*(tokens_of(text, self.words) if isinstance(text, str) else text), ")"]).values(")")

    def parser(self, tokens: list[str]) -> Parser:
        """Return what reads expressions."""
        return self.PARSER(tokens, self.words, self)

    def name(self, name: str) -> Any:
        """Return the value of a variable."""
        for values in (self.locals[-1], self.values):
            if name in values:
                return values[name]
        raise ProgramError(f"nobody knows {name}: the program gave it no value")

    def call(self, name: str, arguments: list[Any]) -> Any:
        """Return what a function of the program, or one of the language, returns; named arguments are a last dict."""
        if name in self.routines or name in self.ARCS:
            if not self.RETURNS:
                raise ProgramError(f"{name} is not a function")
            return self.routine(name, arguments)
        named = arguments.pop() if arguments and isinstance(arguments[-1], dict) else {}
        function = self.FUNCTIONS.get(name.lower())
        if function is None:
            raise ProgramError(f"not followed: {name}(…)")
        return function(self, *arguments, **named)

    def item(self, value: Any, indices: list[Any]) -> Any:
        """Return an element of an array."""
        if not isinstance(value, (list, dict)):
            raise ProgramError("not an array")
        try:
            return value[indices[0]]
        except LookupError:
            raise ProgramError(f"no element {indices[0]}") from None

    def routine(self, name: str, arguments: Sequence[Any] = ()) -> Any:
        """Run a routine to its end; return its value."""
        name = name.upper() if self.words.is_upper else name
        routine = self.routines.get(name)
        if routine is None and name in self.ARCS:
            self.machine.switch(self.ARCS[name])
            return None
        if routine is None:
            raise ProgramError(f"{name} is not there")
        if len(routine.parameters) != len(arguments):
            raise ProgramError(f"{name} takes {len(routine.parameters)} arguments")
        before, self.file = self.file, routine.file
        self.locals.append(dict(zip(routine.parameters, arguments, strict=True)))
        self.calls += 1
        try:
            self.whole(routine.body)
        except LeaveError as found:
            return found.value
        finally:
            self.machine.switch(Does.STOP)
            self.calls -= 1
            self.locals.pop()
            self.file = before
        return None

    def whole(self, body: Sequence[Node]) -> None:
        """Run the body of a routine."""
        self.block(body)

    def block(self, nodes: Sequence[Node]) -> None:
        """Run lines one after another."""
        file = self.file
        for node in nodes:
            self.step(file, node.line, partial(self.execute, node))

    def loop(self, node: Node, goes_on: Callable[[], Any]) -> None:
        """Run a block while it goes on."""
        file = self.file
        try:
            while goes_on():
                self.block(node.branches[0][1])
                self.run.step(self.calls, file, node.line)
        except BreakError:
            pass

    def give(self, name: str, value: Any) -> None:
        """Give a variable a value."""
        (self.locals[-1] if name in self.locals[-1] else self.values)[name] = value

    def counted(self, node: Node, name: str, first: Any, last: Any, step: Any = 1) -> None:
        """Run a block with a variable that counts."""
        if not step:
            raise ProgramError("a FOR with a step of 0")
        self.give(name, first - step)

        def goes_on() -> bool:
            self.give(name, self.name(name) + step)
            return bool((self.name(name) - last) * step <= 0)

        self.loop(node, goes_on)

    def count(self, node: Node, tokens: list[str]) -> None:
        """Run a block with a variable that counts: ``FOR i = a TO b STEP c``."""
        words, (equals, to, by, end) = [token.upper() for token in tokens], self.FOR
        if equals not in words or to not in words or end not in ("", words[-1]):
            raise ProgramError(f"not followed: {node.text[:40]!r}")
        begin, until, last = words.index(equals), words.index(to), len(words) - bool(end)
        step = words.index(by) if by in words else last
        values = [self.value(tokens[begin + 1 : until]), self.value(tokens[until + 1 : step])]
        self.counted(
            node, self.word(tokens[1]), *values, *([self.value(tokens[step + 1 : last])] if step < last else [])
        )

    def select(self, node: Node, tokens: list[str]) -> None:
        """Run the first branch that has the value of the head: CASE a, b; DEFAULT."""
        found = self.value(tokens[1:])
        for head, body in node.branches[1:]:
            word, *values = tokens_of(head, self.words)
            if word.upper() == "DEFAULT" or found in self.listed(_bare(values)):
                self.block(body)
                return

    def choose(self, node: Node, _: list[str]) -> None:
        """Run the first branch whose head holds: IF … THEN, ELSEIF, ELSE."""
        for head, body in node.branches:
            word, *condition = tokens_of(head, self.words)
            if word.upper() == "ELSE" or self.value(_bare(condition)):
                self.block(body)
                return

    def loop_while(self, node: Node, tokens: list[str]) -> None:
        """Run a block while what is behind its first word holds."""
        self.loop(node, lambda: self.value(_bare(tokens[1:])))

    def until(self, node: Node, _: list[str]) -> None:
        """Run a block until what its last line says holds."""
        rounds = count()
        self.loop(node, lambda: next(rounds) == 0 or not self.value(tokens_of(node.close, self.words)[1:]))

    #: What runs the blocks that a language has, by their first words.
    BLOCKS: Mapping[str, Callable[[Any, Node, list[str]], None]] = {
        "IF": choose,
        "WHILE": loop_while,
        "LOOP": lambda self, node, _: self.loop(node, lambda: True),
        **dict.fromkeys(("REPEAT", "DO"), until),
        **dict.fromkeys(("SWITCH", "TEST"), select),
        "FOR": lambda self, node, tokens: self.count(node, tokens),
    }

    def execute(self, node: Node) -> None:
        """Run one line with its blocks."""
        if node.text.startswith(self.COMMENT):
            self.remark(node.text[len(self.COMMENT) :])
            return
        tokens = tokens_of(node.text, self.words)
        word = self.word(tokens[0])
        if node.branches and word.upper() in self.BLOCKS:
            self.BLOCKS[word.upper()](self, node, tokens)
        elif word.upper() == "RETURN":
            raise LeaveError(self.value(tokens[1:]) if len(tokens) > 1 else None)
        elif word.upper() == self.BREAK:
            raise BreakError
        else:
            self.statement(word, tokens, node)

    def word(self, token: str) -> str:
        """Return a token in capitals where the language does not tell them apart."""
        return token.upper() if self.words.is_upper else token

    def statement(self, word: str, tokens: list[str], node: Node) -> None:
        """Run a line that is no block; `word` is its first."""
        raise NotImplementedError


def _bare(tokens: list[str]) -> list[str]:
    """Return the tokens of a condition without the word that ends the head of its block."""
    return tokens[:-1] if tokens and tokens[-1].upper() in {"THEN", "DO", ":"} else tokens
