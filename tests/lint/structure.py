"""Measure the house: `python -m tests.lint.structure`. Each figure has a limit that may fall and not rise.

Rooms are the folders and files directly in `wpcal`, and `cad`. An arrow is one room that imports another.
"""

from __future__ import annotations

import ast
import sys
from collections import defaultdict
from functools import cache
from pathlib import Path

ROOT = Path(__file__).parents[2]
LIMITS = {
    "lines of wpcal and cad": 122_065,
    "lines of tests": 63_595,
    "rooms": 21,
    "arrows between rooms": 107,
    "functions and classes of one name in several files": 8,
    "functions of more than 60 lines": 1,
    "functions with more than 6 parameters": 53,
    "functions with more than 10 branches, per thousand": 25,
}
BRANCHES = (ast.If, ast.For, ast.While, ast.IfExp, ast.ExceptHandler, ast.comprehension, ast.Assert, ast.match_case)


@cache
def trees(*folders: str) -> dict[Path, ast.Module]:
    """Return the syntax of every file."""
    files = [path for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]
    return {path: ast.parse(path.read_text(encoding="utf-8")) for path in files}


def lines(*folders: str) -> int:
    """Return the number of raw lines."""
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in trees(*folders))


def room(module: str) -> str:
    """Return the room of a module."""
    parts = module.split(".")
    return parts[0] if parts[0] == "cad" else ".".join(parts[:2])


def arrows() -> set[tuple[str, str]]:
    """Return which room imports which; the faces ``__init__.py`` of both packages hand names on and do not count."""
    known = {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for path in trees("wpcal", "cad")
    }
    found = set()
    for path, tree in trees("wpcal", "cad").items():
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module and module not in ("wpcal", "cad"):
                for alias in node.names:
                    target = f"{node.module}.{alias.name}"
                    target = target if target in known else node.module
                    if target in known and room(target) != room(module):
                        found.add((room(module), room(target)))
    return found


def functions() -> list[ast.FunctionDef]:
    """Return every function and method."""
    return [
        node for tree in trees("wpcal", "cad").values() for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)
    ]


def branches(function: ast.FunctionDef) -> int:
    """Return the cyclomatic complexity of a function, without that of functions in it."""
    inner = {
        id(n)
        for f in ast.walk(function)
        if isinstance(f, ast.FunctionDef | ast.Lambda) and f is not function
        for n in ast.walk(f)
    }
    own = [node for node in ast.walk(function) if id(node) not in inner]
    return (
        1 + sum(isinstance(n, BRANCHES) for n in own) + sum(len(n.values) - 1 for n in own if isinstance(n, ast.BoolOp))
    )


def homes_of_names() -> dict[str, list[Path]]:
    """Return public functions and classes that several files define.

    A command, and a method of the machine interface, has the name of what it calls; every process has its `main`, and
    every robot language its `Interpreter`; and the workbench is a program of its own, in another Python. The type of a
    record is called as what it describes.
    """
    found = defaultdict(list)
    for path, tree in trees("wpcal", "cad").items():
        if path.is_relative_to(ROOT / "cad" / "freecad") or path.parent.name in ("cli", "rpc", "records"):
            continue
        for node in tree.body:
            is_named = isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name not in (
                "main",
                "run",
                "Interpreter",
            )
            if is_named and not node.name.startswith("_"):
                found[node.name].append(path)
    return {name: paths for name, paths in found.items() if len(paths) > 1}


def parameters(function: ast.FunctionDef) -> int:
    """Return the number of parameters without `self` and `cls`."""
    given = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    return sum(each.arg not in ("self", "cls") for each in given)


def body_lines(function: ast.FunctionDef) -> int:
    """Return the lines of a function without its docstring."""
    body = function.body[1:] if ast.get_docstring(function) and len(function.body) > 1 else function.body
    return (function.end_lineno or 0) - body[0].lineno + 1


def measured() -> dict[str, int]:
    """Return every figure."""
    own, every = arrows(), functions()
    return {
        "lines of wpcal and cad": lines("wpcal", "cad"),
        "lines of tests": lines("tests"),
        "rooms": len({end for arrow in own for end in arrow}),
        "arrows between rooms": len(own),
        "functions and classes of one name in several files": len(homes_of_names()),
        "functions of more than 60 lines": sum(body_lines(each) > 60 for each in every),
        "functions with more than 6 parameters": sum(parameters(each) > 6 for each in every),
        "functions with more than 10 branches, per thousand": round(
            1000 * sum(branches(each) > 10 for each in every) / len(every)
        ),
    }


def main() -> int:
    """Print the figures; return 1 if one is above its limit."""
    found = measured()
    for name, value in found.items():
        print(f"{value:7d}  (at most {LIMITS[name]})  {name}")
    if "--names" in sys.argv:
        for name, paths in sorted(homes_of_names().items()):
            print(name, *(str(path.relative_to(ROOT)) for path in paths))
    if "--large" in sys.argv:
        for path, tree in trees("wpcal", "cad").items():
            for node in ast.walk(tree):
                if isinstance(node, ast.FunctionDef):
                    sizes = parameters(node), branches(node), body_lines(node)
                    if sizes[0] > 6 or sizes[1] > 10 or sizes[2] > 60:
                        where = f"{path.relative_to(ROOT)}:{node.lineno} {node.name}"
                        print(where, "(parameters, branches, lines)", *sizes)
    return int(any(value > LIMITS[name] for name, value in found.items()))


if __name__ == "__main__":
    sys.exit(main())
