"""Check that docstrings of public functions give the shapes of their arrays: `python -m tests.lint.docstrings`.

A public function or method with an array among its parameters says "shape" in its docstring. The check prints every
function that does not, and then exits with 1.
"""

import ast
import sys
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
ARRAYS = ("FloatArray", "IntArray", "BoolArray", "ArrayLike", "NDArray", "ndarray")
"""Names of annotations that mean an array."""


def array_parameters(function: ast.FunctionDef) -> list[str]:
    """Return the parameters of a function whose annotation names an array type."""
    arguments = [*function.args.posonlyargs, *function.args.args, *function.args.kwonlyargs]
    return [
        argument.arg
        for argument in arguments
        if argument.annotation is not None and any(name in ast.unparse(argument.annotation) for name in ARRAYS)
    ]


def public_functions(tree: ast.Module) -> Iterator[tuple[str, ast.FunctionDef]]:
    """Yield the public functions of a module and the public methods of its public classes, with their names."""
    for node in tree.body:
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_"):
            yield node.name, node
        elif isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            for method in node.body:
                if isinstance(method, ast.FunctionDef) and not method.name.startswith("_"):
                    yield f"{node.name}.{method.name}", method


def missing_shapes(path: Path) -> list[str]:
    """Return the public functions of a file with array parameters and a docstring that gives no shape."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    return [
        f"{path.relative_to(ROOT)}:{function.lineno}: {name} gives no shape of {', '.join(arrays)}"
        for name, function in public_functions(tree)
        if (arrays := array_parameters(function)) and "shape" not in (ast.get_docstring(function) or "")
    ]


def main() -> int:
    """Print what is missing; return the exit code."""
    files = [path for package in ("wpcal", "cad") for path in sorted((ROOT / package).rglob("*.py"))]
    missing = [row for path in files for row in missing_shapes(path)]
    print("\n".join(missing))
    return 1 if missing else 0


if __name__ == "__main__":
    sys.exit(main())
