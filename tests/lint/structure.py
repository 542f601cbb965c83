"""Measure the house: `python -m tests.lint.structure`. Each figure has a limit that may fall and not rise.

Rooms are the folders and files directly in `wpcal`, and `cad`. An arrow is one room that imports another. `--names`
names what has one name and what is not declared, `--large` the large functions.
"""

import ast
import re
import sys
import tomllib
from collections import defaultdict
from functools import cache
from importlib.metadata import packages_distributions
from pathlib import Path

ROOT = Path(__file__).parents[2]
LIMITS = {
    "lines of wpcal and cad": 122_386,
    "lines of tests": 63_795,
    "rooms": 18,
    "arrows between rooms": 80,
    "imported packages that pyproject.toml does not declare": 0,
    "functions and classes of one name in several files": 7,
    "functions of more than 60 lines": 0,
    "functions with more than 6 parameters": 40,
    "functions with more than 10 branches, per thousand": 20,
}
COMES_WITH = {"mpl_toolkits": "matplotlib", "anyio": "starlette", "h11": "uvicorn", "dask": "distributed"}
"""Part of another package, or used only through it."""
OFTEN = ("main", "run", "Interpreter")  #: Names that every process, command and robot language has.
BRANCHES = (ast.If, ast.For, ast.While, ast.IfExp, ast.ExceptHandler, ast.comprehension, ast.Assert, ast.match_case)


def files(*folders: str) -> list[Path]:
    """Return every file of Python."""
    return [path for folder in folders for path in sorted((ROOT / folder).rglob("*.py"))]


@cache
def nodes() -> dict[Path, list[ast.AST]]:
    """Return the syntax of every file of the product, its whole first."""
    return {path: list(ast.walk(ast.parse(path.read_text(encoding="utf-8")))) for path in files("wpcal", "cad")}


def lines(*folders: str) -> int:
    """Return the number of raw lines."""
    return sum(len(path.read_text(encoding="utf-8").splitlines()) for path in files(*folders))


def room(module: str) -> str:
    """Return the room of a module."""
    parts = module.split(".")
    return parts[0] if parts[0] == "cad" else ".".join(parts[:2])


def arrows() -> set[tuple[str, str]]:
    """Return which room imports which; the faces ``__init__.py`` of both packages hand names on and do not count."""
    known = {".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__") for path in nodes()}
    found = set()
    for path, every in nodes().items():
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__")
        for node in every:
            if isinstance(node, ast.ImportFrom) and node.module and module not in ("wpcal", "cad"):
                for alias in node.names:
                    target = f"{node.module}.{alias.name}"
                    target = target if target in known else node.module
                    if target in known and room(target) != room(module):
                        found.add((room(module), room(target)))
    return found


def undeclared() -> list[str]:
    """Return what the two packages import and no list of dependencies names; the workbench has FreeCAD's own Python."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    lists = [project["dependencies"], *project["optional-dependencies"].values()]
    declared = {_normal(re.split(r"[\[>=<]", one)[0]) for each in lists for one in each}
    names = set()
    for path, every in nodes().items():
        if not path.is_relative_to(ROOT / "cad" / "freecad"):
            for node in every:
                if isinstance(node, ast.Import):
                    names |= {alias.name.partition(".")[0] for alias in node.names}
                elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                    names.add(node.module.partition(".")[0])
    homes = packages_distributions()
    others = names - set(sys.stdlib_module_names) - {"wpcal", "cad"}
    of = {name: [COMES_WITH[name]] if name in COMES_WITH else homes.get(name, [name]) for name in others}
    return sorted(name for name, packages in of.items() if not declared & {_normal(one) for one in packages})


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def functions() -> list[ast.FunctionDef]:
    """Return every function and method."""
    return [node for every in nodes().values() for node in every if isinstance(node, ast.FunctionDef)]


def branches(function: ast.FunctionDef) -> int:
    """Return the cyclomatic complexity of a function, without that of functions in it."""
    own, left = list[ast.AST](), list(ast.iter_child_nodes(function))
    while left:
        node = left.pop()
        if not isinstance(node, ast.FunctionDef | ast.Lambda):
            own.append(node)
            left.extend(ast.iter_child_nodes(node))
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
    for path, (tree, *_) in nodes().items():
        if path.is_relative_to(ROOT / "cad" / "freecad") or path.parent.name in ("cli", "rpc", "record_types"):
            continue
        for node in tree.body:
            is_named = isinstance(node, ast.FunctionDef | ast.ClassDef) and node.name not in OFTEN
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
        "imported packages that pyproject.toml does not declare": len(undeclared()),
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
        print("not declared:", *undeclared())
        for name, paths in sorted(homes_of_names().items()):
            print(name, *(str(path.relative_to(ROOT)) for path in paths))
    if "--large" in sys.argv:
        for path, every in nodes().items():
            for node in every:
                if isinstance(node, ast.FunctionDef):
                    sizes = parameters(node), branches(node), body_lines(node)
                    if sizes[0] > 6 or sizes[1] > 10 or sizes[2] > 60:
                        where = f"{path.relative_to(ROOT)}:{node.lineno} {node.name}"
                        print(where, "(parameters, branches, lines)", *sizes)
    return int(any(value > LIMITS[name] for name, value in found.items()))


if __name__ == "__main__":
    sys.exit(main())
