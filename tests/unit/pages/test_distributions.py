"""What is in the wheel and in the source distribution: users get the bundles, only developers get their source."""

import re
import tarfile
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
SOURCE = "wpcal/pages/source/"
BUNDLES = {f"wpcal/pages/bundles/{file.name}" for file in (ROOT / "wpcal" / "pages" / "bundles").iterdir()}
NEEDED_OUTSIDE = ("README.md", "CONTRIBUTING.md", "LICENSE", "CHANGELOG.md", "Makefile", "docs/images/report.png")
NO_HATCHLING = "hatchling is not installed; `make demo` installs it with the other tools of a developer"


def test_the_wheel_has_the_bundles_and_not_their_source(tmp_path: Path) -> None:
    wheel = pytest.importorskip("hatchling.builders.wheel", reason=NO_HATCHLING)
    (built,) = wheel.WheelBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"])
    with zipfile.ZipFile(built) as archive:
        names = set(archive.namelist())
    assert names >= BUNDLES | {"wpcal/pages/html.py", "cad/__init__.py"}
    assert [name for name in names if name.startswith(SOURCE) or "node_modules" in name] == []


def test_the_source_distribution_has_what_a_reader_needs_without_installed_packages(tmp_path: Path) -> None:
    sdist = pytest.importorskip("hatchling.builders.sdist", reason=NO_HATCHLING)
    (built,) = sdist.SdistBuilder(str(ROOT)).build(directory=str(tmp_path), versions=["standard"])
    with tarfile.open(built) as archive:
        names = {name.partition("/")[2] for name in archive.getnames()}
    kept = {"build.mjs", "package.json", "package-lock.json", "biome.json", "src/viewer.js", "test/rows.test.js"}
    pictures = set(re.findall(r"\]\((docs/images/[^)]+)\)", (ROOT / "README.md").read_text(encoding="utf-8")))
    assert names >= BUNDLES | {SOURCE + name for name in kept} | {*NEEDED_OUTSIDE, *pictures, ".ci/run"}
    assert [name for name in names if "node_modules" in name] == []
