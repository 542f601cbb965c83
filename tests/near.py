"""`make near`: the checks that a change can reach, in about a minute.

A test is near if it imports a changed file, through any number of files. Two kinds of import are not statements: entry
points of pyproject.toml (a test names a command or a language), and texts of the form ``package.module:name``.

    python -m tests.near                 what changed since origin/main, with what is not committed
    python -m tests.near FILE...         what these files reach
    python -m tests.near --list FILE...  only name the test files
"""

import ast
import re
import subprocess
import sys
import tomllib
from collections import defaultdict
from collections.abc import Iterable
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGES = ("wpcal", "cad", "tests")
_TARGET = re.compile(r"^((?:wpcal|cad)(?:\.\w+)+)(?::\w+)?$")
WHOLE = ("test_whole_records.py", "test_values_of_fits.py")
"""What most changes of results are seen by comes with the tests that name a changed file."""
QUICK = ("unit", "laws", "golden", "lint")  #: Folders whose tests seldom run a command, the kernel or a browser.
MOST_FILES = 20
"""Test files beyond this many take longer than a minute: the nearest ones are run, and the others are counted."""


@cache
def modules() -> dict[str, Path]:
    """Return the file of every module."""
    found = {}
    for package in PACKAGES:
        for path in (ROOT / package).rglob("*.py"):
            parts = path.relative_to(ROOT).with_suffix("").parts
            found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


@cache
def entry_points() -> dict[str, set[str]]:
    """Return the modules of every name of a command, language, link, exporter and kind of part."""
    groups = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
    found = defaultdict[str, set[str]](set)
    for name, target in ((name, target) for group in groups.values() for name, target in group.items()):
        found[name].add(target.partition(":")[0])
    return found


@cache
def imports_of(path: Path) -> set[str]:
    """Return the modules that a file names: imports, texts of lazy imports, and in tests entry points."""
    known, named = modules(), set[str]()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            named.update(alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            named.update(f"{node.module}.{alias.name}" for alias in node.names)
            named.add(node.module)
        elif isinstance(node, ast.Constant) and isinstance(node.value, str):
            target = _TARGET.match(node.value)
            named.add(target[1] if target else "")
            if path.is_relative_to(ROOT / "tests"):
                named |= entry_points().get(node.value, set())
    return {name for name in named if name in known}


@cache
def users() -> dict[Path, set[Path]]:
    """Return for every file the files that name it."""
    known, found = modules(), defaultdict[Path, set[Path]](set)
    for path in known.values():
        for name in imports_of(path):
            found[known[name]].add(path)
    return found


def distances(changed: Iterable[Path]) -> dict[Path, int]:
    """Return the files that a change reaches, with the number of imports between."""
    reached = dict.fromkeys(changed, 0)
    front = list(reached)
    while front:
        path = front.pop(0)
        for user in users()[path]:
            if user not in reached:
                reached[user] = reached[path] + 1
                front.append(user)
    return reached


def changed_files() -> list[Path]:
    """Return the files that differ from origin/main."""
    base = _git("merge-base", "HEAD", "origin/main") or ["HEAD"]
    names = _git("diff", "--name-only", *base) + _git("ls-files", "--others", "--exclude-standard")
    return [ROOT / name for name in names]


def _git(*arguments: str) -> list[str]:
    return subprocess.run(["git", *arguments], cwd=ROOT, capture_output=True, text=True, check=False).stdout.split()


def source_of(path: Path) -> list[Path]:
    """Return the Python files that stand for a changed file: itself, or for data the package that holds it."""
    if path.suffix == ".py":
        return [path] if path.exists() else []
    while path != ROOT:
        path = path.parent
        if (path / "__init__.py").exists():
            return [path / "__init__.py", *path.glob("*.py")]
    return []


def near_tests(changed: Iterable[Path]) -> list[Path]:
    """Return the test files that a change reaches: nearest first; of those, quick folders; files of few imports."""
    reached = distances([source for path in changed for source in source_of(path)])
    tests = [path for path in reached if path.name.startswith("test_")]
    return sorted(
        tests,
        key=lambda path: (
            min(reached[path], 1) if path.name in WHOLE else reached[path],
            path.relative_to(ROOT).parts[1] not in QUICK,
            len(imports_of(path)),
            path,
        ),
    )


def main(arguments: list[str]) -> int:
    """Run ruff, mypy and the tests; return the first exit code that is not 0."""
    changed = [ROOT / name for name in arguments if name != "--list"] or changed_files()
    names = [str(path.relative_to(ROOT)) for path in near_tests(changed)]
    if "--list" in arguments:
        print("\n".join(names))
        return 0
    if len(names) > MOST_FILES:
        print(f"{len(names)} test files are reached; the nearest {MOST_FILES} are run. `make test` runs all.")
    tools = Path(sys.executable).parent
    python = [str(path) for path in changed if path.suffix == ".py" and path.exists()]
    steps: list[list[str]] = []
    if python:
        steps += [
            [f"{tools}/ruff", "format", "--check", *python],
            [f"{tools}/ruff", "check", *python],
            [f"{tools}/mypy"],
        ]
    if names:
        pytest = ("-m", "pytest", "-q", "-n", "2", "--dist", "loadfile", "-m", "not deep")
        steps += [[sys.executable, *pytest, *names[:MOST_FILES]]]
    codes = (subprocess.run(step, cwd=ROOT, check=False).returncode for step in steps)
    return next((code for code in codes if code), 0)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
