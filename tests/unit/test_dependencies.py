"""The project as a whole: bounds of dependencies, contributing, examples and skips."""

import doctest
import pkgutil
import re
import tomllib
from importlib import import_module
from pathlib import Path

import pytest

import wpcal
from tests.lint.skips import MOST_SKIPS, unexpected_skips
from tests.mutate import EQUAL, mutants_of

ROOT = Path(__file__).parents[2]
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
BOUNDED = re.compile(r"[\w-]+>=[\d.]+,<[\d.]+")


def test_every_dependency_has_a_lower_and_an_upper_bound() -> None:
    assert [one for one in PROJECT["dependencies"] if not BOUNDED.fullmatch(one)] == []


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


@pytest.mark.parametrize("name", EQUAL)
def test_every_equal_mutant_is_one_of_its_file(name):
    source = (ROOT / name).read_text(encoding="utf-8")
    assert set(EQUAL[name]) <= {one.changed(source) for one in mutants_of(ROOT / name)}
