"""`import wpcal` and `import cad` show what the documentation uses, and load nothing before it is used."""

import ast
import re
import subprocess
import sys
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
PACKAGES = ("wpcal", "cad")
DOCUMENTS = [
    ROOT / "README.md",
    *sorted((ROOT / "docs").rglob("*.md")),
    *sorted((ROOT / "docs" / "examples").glob("*.py")),
]
HEAVY = ("numpy", "scipy", "OCP", "build123d", "click")


def names_in_imports(package: str) -> set[str]:
    """What type checkers see: the names imported under ``if TYPE_CHECKING``."""
    tree = ast.parse((ROOT / package / "__init__.py").read_text(encoding="utf-8"))
    blocks = [node for node in tree.body if isinstance(node, ast.If)]
    imports = [node for block in blocks for node in block.body if isinstance(node, ast.ImportFrom)]
    return {alias.asname or alias.name for node in imports for alias in node.names}


def modules_of(package: str) -> set[str]:
    """The names of the package's own modules and packages."""
    return {path.stem for path in (ROOT / package).iterdir() if path.is_dir() or path.suffix == ".py"}


def names_in_documents(package: str) -> set[str]:
    """The names that the documentation uses as ``wpcal.name``, without modules, groups of entry points and the file."""
    text = "\n".join(path.read_text(encoding="utf-8") for path in DOCUMENTS)
    return (
        set(re.findall(rf"(?<![\w./\"-]){package}\.(?!toml\b)([A-Za-z_]+)\b", text))
        - modules_of(package)
        - groups_of(package)
    )


def groups_of(package: str) -> set[str]:
    """The groups of entry points that the package defines."""
    groups = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
    return {group.removeprefix(f"{package}.") for group in groups}


@pytest.mark.parametrize("package", PACKAGES)
def test_python_type_checkers_and_documents_see_the_same_names(package: str) -> None:
    module = import_module(package)
    assert len(set(module.__all__)) == len(module.__all__)
    assert set(dir(module)) == set(module.__all__) == names_in_imports(package) == names_in_documents(package)


@pytest.mark.parametrize("package", PACKAGES)
def test_the_reference_lists_every_name(package: str) -> None:
    text = (ROOT / "docs" / "reference" / "library.md").read_text(encoding="utf-8")
    listed = re.findall(rf"^\| `{package}\.(\w+)` \|", text, flags=re.MULTILINE)
    assert listed == import_module(package).__all__


@pytest.mark.parametrize("package", PACKAGES)
def test_no_name_is_that_of_a_package(package: str) -> None:
    assert not set(import_module(package).__all__) & modules_of(package)


@pytest.mark.parametrize("package", PACKAGES)
def test_every_name_is_there_in_any_order_of_imports(package: str) -> None:
    module = import_module(package)
    for name in reversed(module.__all__):
        assert callable(getattr(module, name))
    assert module.__all__ == sorted(module.__all__, key=lambda name: (name.islower(), name))
    with pytest.raises(AttributeError, match=f"module '{package}' has no attribute 'nothing'"):
        module.nothing  # noqa: B018 (the access is the test)


def test_importing_loads_no_library_until_a_name_is_used() -> None:
    code = (
        f"import sys, wpcal, cad; print([name for name in {HEAVY} if name in sys.modules]); "
        "wpcal.PointPairs; print('numpy' in sys.modules)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.split("\n")[:2] == ["[]", "True"]
