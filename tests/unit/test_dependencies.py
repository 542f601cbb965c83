"""The project as a whole: dependencies, contributing, examples and skips."""

import ast
import doctest
import pkgutil
import re
import subprocess
import sys
import tarfile
import tomllib
from importlib import import_module
from importlib.metadata import packages_distributions
from pathlib import Path

import pytest

import wpcal
from tests.lint.skips import MOST_SKIPS, unexpected_skips

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
BOUNDED = re.compile(r"[\w-]+>=[\d.]+,<[\d.]+")
COMES_WITH = {"mpl_toolkits": "matplotlib", "anyio": "starlette", "h11": "uvicorn", "dask": "distributed"}
"""Part of another package, or used only through it."""
NEEDED_OUTSIDE = ("README.md", "CONTRIBUTING.md", "LICENSE", "CHANGELOG.md", "Makefile", "docs/images/report.png")


def normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()


def declared() -> set[str]:
    lists = [PROJECT["dependencies"], *PROJECT["optional-dependencies"].values()]
    return {normal(re.split(r"[\[>=<]", one)[0]) for each in lists for one in each}


def imported() -> set[str]:
    """Return the first names of all imports in the two packages; the workbench runs in FreeCAD's own Python."""
    names: set[str] = set()
    paths = (path for package in ("wpcal", "cad") for path in (ROOT / package).rglob("*.py"))
    for path in (path for path in paths if not path.is_relative_to(ROOT / "cad" / "freecad")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Import):
                names |= {alias.name.partition(".")[0] for alias in node.names}
            elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
                names.add(node.module.partition(".")[0])
    return names - set(sys.stdlib_module_names) - {"wpcal", "cad"}


def test_what_is_imported_is_declared() -> None:
    homes = packages_distributions()
    for name in imported():
        home = COMES_WITH.get(name)
        assert declared() & {normal(one) for one in ([home] if home else homes.get(name, [name]))}, name


def test_every_dependency_has_a_lower_and_an_upper_bound() -> None:
    assert [one for one in PROJECT["dependencies"] if not BOUNDED.fullmatch(one)] == []


def test_the_source_distribution_has_what_a_reader_needs(tmp_path: Path) -> None:
    subprocess.run(
        [sys.executable, "-m", "hatchling", "build", "-t", "sdist", "-d", str(tmp_path)],
        cwd=ROOT,
        check=True,
        capture_output=True,
        timeout=300,
    )
    (archive,) = tmp_path.glob("*.tar.gz")
    with tarfile.open(archive) as packed:
        names = {name.partition("/")[2] for name in packed.getnames()}
    pictures = set(re.findall(r"\]\((docs/images/[^)]+)\)", (ROOT / "README.md").read_text(encoding="utf-8")))
    assert {*NEEDED_OUTSIDE, *pictures, ".ci/run"} <= names
    assert not any("node_modules" in name for name in names)


ROWS = [line for line in (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").splitlines() if line.startswith("| ")]


@pytest.mark.parametrize("row", ROWS)
def test_the_places_exist_and_hold_the_names(row):
    words = re.findall(r"`([^`]+)`", row.split("|")[2])
    places = [ROOT / word.removesuffix("/<brand>") for word in words if "/" in word]
    assert all(place.exists() for place in places), row
    texts = [place.read_text(encoding="utf-8") for place in places if place.is_file()]
    names = [word for word in words if re.fullmatch(r"[A-Za-z_]+", word) and not (ROOT / word).exists()]
    assert all(any(name in text for text in texts) for name in names), row


def test_allowed_skips_pass_and_others_are_listed():
    reason, most = next(iter(MOST_SKIPS.items()))
    assert unexpected_skips([reason] * most) == []
    assert unexpected_skips([reason] * (most + 1)) == [f"{most + 1} tests skipped, {most} allowed: {reason}"]
    assert unexpected_skips(["chromium is not here"]) == ["1 tests skipped, 0 allowed: chromium is not here"]


WITH_EXAMPLES = sorted(
    ".".join(path.relative_to(ROOT).with_suffix("").parts)
    for package in ("wpcal", "cad")
    for path in (ROOT / package).rglob("*.py")
    if ">>> " in path.read_text(encoding="utf-8")
)


@pytest.mark.parametrize("name", WITH_EXAMPLES)
def test_the_examples_of_a_module_are_true(name):
    found = doctest.testmod(import_module(name.removesuffix(".__init__")))
    assert found.attempted
    assert not found.failed


def test_every_module_can_be_imported():
    for module in pkgutil.walk_packages(wpcal.__path__, "wpcal."):
        if not module.name.endswith("__main__"):
            import_module(module.name)
