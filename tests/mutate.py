"""Break changed lines one at a time, and list the breaks that no near test notices: `python -m tests.mutate [PATH...]`.

Each mutant changes one comparison, operator, sign, constant or `not` of the library. It runs in a copy of the project
against the tests that reach its file (`tests.near`), the nearest first, until one fails. A mutant that survives names a
line whose value no test asserts. Mutants that change no result (`tests/equal_mutants.toml`) are not drawn.

    --most N     how many mutants (40)
    --seed N     of the draw (1)
    --files N    how many test files each one meets (24)
    --all        all lines of the files and folders, not only those that changed since origin/main
"""

import argparse
import ast
import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice
from pathlib import Path

import pytest

from tests.near import ROOT, changed_files, near_tests

COMPARISONS = {ast.Lt: "<=", ast.LtE: "<", ast.Gt: ">=", ast.GtE: ">", ast.Eq: "!=", ast.NotEq: "=="}
OPERATORS = {ast.Add: "-", ast.Sub: "+", ast.Mult: "/", ast.Div: "*", ast.MatMult: "*"}
OPERATOR = re.compile(r"[<>=!]=|[<>+*/@-]|\band\b|\bor\b")
RESHAPED = re.compile(r"reshape\((?:[^()]|\([^()]*\))*-2\b")
SIZE = re.compile(r"(?:[A-Z]+_)?(?:CHUNK|AT_ONCE) = ")
LEFT_OUT = (".git", ".venv*", ".*_cache", ".hypothesis", "out", "out-*", "node_modules", "_build")
"""Of the copy of the project; `.ci` and `outputs.py` are in it."""
PYTEST = (sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", "-m", "not deep")
FAILED = re.compile(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", re.MULTILINE)
PASSED = (pytest.ExitCode.OK, pytest.ExitCode.NO_TESTS_COLLECTED)
BATCH = 8  #: Test files that one process runs: the first few find most mutants.
LIMIT_S = 400  #: A mutant that runs longer than this is found, if the tests are done in that time without it.
EQUAL: dict[str, dict[str, str]] = tomllib.loads((ROOT / "tests/equal_mutants.toml").read_text(encoding="utf-8"))
NO_END = "no end within the limit"


@dataclass(frozen=True, slots=True)
class Mutant:
    """One changed piece of one line."""

    path: Path
    line: int
    start: int
    end: int
    text: str

    def apply(self, source: str) -> str:
        """Return the source with the change."""
        rows = source.split("\n")
        row = rows[self.line - 1].encode()
        rows[self.line - 1] = (row[: self.start] + self.text.encode() + row[self.end :]).decode()
        return "\n".join(rows)

    def is_equal(self) -> bool:
        """Whether the list of equal mutants has it, wherever its line is now; NumPy takes each negative size alike.

        How much goes into one array changes memory and time only.
        """
        changed = self.changed(self.path.read_text(encoding="utf-8"))
        return (
            RESHAPED.search(changed) is not None
            or SIZE.match(changed) is not None
            or changed in EQUAL.get(str(self.path.relative_to(ROOT)), ())
        )

    def changed(self, source: str) -> str:
        """Return the code of the line with the change."""
        return self.apply(source).split("\n")[self.line - 1].partition("  #")[0].strip()


def mutants_of(path: Path) -> Iterator[Mutant]:
    """Yield every mutant of a file; pieces that run over a line end are left out."""
    source = path.read_text(encoding="utf-8")
    rows = source.encode().split(b"\n")
    for node in ast.walk(ast.parse(source)):
        for first, last, text in _changes(node):
            if first.lineno == last.lineno == first.end_lineno:
                start, end = first.end_col_offset or 0, last.col_offset
                between = rows[first.lineno - 1][start:end].decode()
                yield Mutant(path, first.lineno, start, end, OPERATOR.sub(text, between, count=1))
        if isinstance(node, ast.Constant) and type(node.value) in (int, float) and node.lineno == node.end_lineno:
            yield Mutant(path, node.lineno, node.col_offset, node.end_col_offset or 0, repr(node.value + 1))
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub | ast.Not):
            yield Mutant(path, node.lineno, node.col_offset, node.operand.col_offset, "")


def _changes(node: ast.AST) -> Iterator[tuple[ast.expr, ast.expr, str]]:
    """Yield the expressions around each operator of a node, and the other operator."""
    if isinstance(node, ast.Compare):
        for left, operator, right in zip([node.left, *node.comparators], node.ops, node.comparators, strict=False):
            if type(operator) in COMPARISONS:
                yield left, right, COMPARISONS[type(operator)]
    elif isinstance(node, ast.BinOp) and type(node.op) in OPERATORS:
        yield node.left, node.right, OPERATORS[type(node.op)]
    elif isinstance(node, ast.BoolOp):
        other = "or" if isinstance(node.op, ast.And) else "and"
        yield from ((left, right, other) for left, right in zip(node.values, node.values[1:], strict=False))


def changed_lines(path: Path) -> set[int]:
    """Return the numbers of the lines of a file that differ from origin/main."""
    text = subprocess.run(
        ["git", "diff", "-U0", "origin/main", "--", path], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    found = set[int]()
    for row in text.splitlines():
        if row.startswith("@@"):
            first, _, count = row.split("+")[1].split()[0].partition(",")
            found.update(range(int(first), int(first) + int(count or 1)))
    return found


def is_python(source: str) -> bool:
    """Whether a text can be parsed: an operator between two lines cannot always be taken out of one."""
    try:
        ast.parse(source)
    except SyntaxError:
        return False
    return True


def survives(mutant: Mutant, copy: Path, most_files: int) -> bool:
    """Whether all near tests pass with a mutant in the copy; one that fails without the mutant, too, ends the run."""
    names = [str(path.relative_to(ROOT)) for path in near_tests([mutant.path])[:most_files]]
    target = copy / mutant.path.relative_to(ROOT)
    source = target.read_text(encoding="utf-8")
    for some in (names[first : first + BATCH] for first in range(0, len(names), BATCH)):
        target.write_text(mutant.apply(source), encoding="utf-8")
        try:
            failed = failures(some, copy)
        finally:
            target.write_text(source, encoding="utf-8")
        if failed:
            if again := failures(failed if failed != [NO_END] else some, copy):
                raise SystemExit(f"{' '.join(again)}: so without a mutant, too")
            return False
    return True


def failures(tests: list[str], copy: Path) -> list[str]:
    """Return what fails first among some tests; `NO_END` when they do not end."""
    try:
        ended = subprocess.run(
            [*PYTEST, *tests], cwd=copy, capture_output=True, timeout=LIMIT_S, check=False, text=True
        )
    except subprocess.TimeoutExpired:
        return [NO_END]
    failed = FAILED.findall(ended.stdout)
    return failed[:1] or (tests if ended.returncode not in PASSED else [])


def main() -> int:
    """Print the survivors and their share; return 1 if there are any."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("paths", nargs="*", type=Path)
    parser.add_argument("--most", type=int, default=40)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--files", type=int, default=24)
    parser.add_argument("--all", action="store_true")
    asked = parser.parse_args()
    given = [path.resolve() for path in asked.paths] or changed_files()
    paths = [each for path in given for each in (sorted(path.rglob("*.py")) if path.is_dir() else [path])]
    library = [path for path in paths if path.suffix == ".py" and path.relative_to(ROOT).parts[0] in ("wpcal", "cad")]
    mutants = [one for path in library for one in mutants_of(path) if asked.all or one.line in changed_lines(path)]
    drawn = random.Random(asked.seed).sample(mutants, len(mutants))
    parsed = (one for one in drawn if is_python(one.apply(one.path.read_text(encoding="utf-8"))) and not one.is_equal())
    chosen = list(islice(parsed, asked.most))
    with tempfile.TemporaryDirectory() as folder:
        copy = Path(folder) / "wpcal"
        os.environ["PYTHONPATH"] = str(copy)  # commands that tests start find the copy, not what is installed
        shutil.copytree(ROOT, copy, ignore=shutil.ignore_patterns(*LEFT_OUT))
        (Path(folder) / "shared").symlink_to(ROOT.parent / "shared")  # real files beside the checkout, if there are any
        alive = []
        for number, mutant in enumerate(chosen, start=1):
            if survives(mutant, copy, asked.files):
                alive.append(mutant)
                print(
                    f"{mutant.path.relative_to(ROOT)}:{mutant.line}: '{mutant.text.strip()}' is not noticed", flush=True
                )
            print(f"{number} of {len(chosen)}, {len(alive)} survived", file=sys.stderr, flush=True)
    print(f"{len(alive)} of {len(chosen)} mutants survived")
    return 1 if alive else 0


if __name__ == "__main__":
    sys.exit(main())
