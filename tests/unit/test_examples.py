"""The examples in docstrings are true, and every module of `wpcal` can be imported by itself."""

import doctest
import pkgutil
from importlib import import_module
from pathlib import Path

import pytest

import wpcal

ROOT = Path(__file__).parents[2]
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
