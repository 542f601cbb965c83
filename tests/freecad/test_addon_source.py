"""The workbench's source: what it imports, which Python it needs, and what the ZIP file holds."""

import ast
import importlib.util
import json
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
import zipfile
from pathlib import Path
from types import ModuleType

import pytest

ROOT = Path(__file__).parents[2]
ADDON = ROOT / "cad/freecad"
PACKAGE = ADDON / "freecad/wpcal_wb"
SOURCES = sorted(PACKAGE.rglob("*.py"))
FREECADS = {"FreeCAD", "FreeCADGui", "Part", "Import", "PySide", "pivy"}  #: Modules that every FreeCAD brings.
OLDEST_PYTHON = (3, 8)


def imported(tree: ast.AST) -> set[str]:
    """Return the first names of all modules that are imported absolutely, anywhere in a file."""
    names = [alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names]
    names += [node.module or "" for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and not node.level]
    return {name.split(".")[0] for name in names}


def newer_types(tree: ast.AST) -> list[str]:
    """Return where `list[int]` or `int | None` is computed, not only annotated: Python 3.8 has neither."""
    annotations = [
        getattr(node, name)
        for node in ast.walk(tree)
        for name in ("annotation", "returns")
        if getattr(node, name, None) is not None
    ]
    annotated = {id(part) for one in annotations for part in ast.walk(one)}
    generic = {"dict", "list", "tuple", "set", "frozenset", "type"}
    return [
        ast.unparse(node)
        for node in ast.walk(tree)
        if id(node) not in annotated
        and (
            (isinstance(node, ast.Subscript) and isinstance(node.value, ast.Name) and node.value.id in generic)
            or (
                isinstance(node, ast.BinOp)
                and isinstance(node.op, ast.BitOr)
                and isinstance(node.right, ast.Constant)
                and node.right.value is None
            )
        )
    ]


@pytest.mark.parametrize("path", SOURCES, ids=lambda path: path.relative_to(PACKAGE).as_posix())
def test_only_freecad_qt_and_the_standard_library_are_imported(path: Path) -> None:
    tree = ast.parse(path.read_text(encoding="utf-8"), feature_version=OLDEST_PYTHON)
    assert imported(tree) <= FREECADS | set(sys.stdlib_module_names)
    assert not newer_types(tree)
    assert path.read_text(encoding="utf-8").startswith("# SPDX-License-Identifier: MIT\n")


def test_the_zip_file_is_one_folder_with_all_that_freecad_reads(tmp_path: Path) -> None:
    target = tmp_path / "dist" / "workbench.zip"
    subprocess.run([sys.executable, "-m", "cad.freecad.build", str(target)], cwd=ROOT, check=True)
    with zipfile.ZipFile(target) as archive:
        names = archive.namelist()
        package = ET.fromstring(archive.read("WpCal/package.xml"))
        texts = ET.fromstring(archive.read("WpCal/freecad/wpcal_wb/resources/translations/WpCal.ts"))
    assert all(name.startswith("WpCal/") for name in names)
    assert {f"WpCal/{path.relative_to(ADDON).as_posix()}" for path in SOURCES} <= set(names)
    assert "WpCal/freecad/__init__.py" not in names, "FreeCAD's own package would be hidden"
    assert {"Features and seams", "Suggest next", "weld", "Cancelled."} <= {one.text for one in texts.iter("source")}
    space = {"p": "https://wiki.freecad.org/Package_Metadata"}
    for icon in package.iterfind(".//p:icon", space):
        assert f"WpCal/{icon.text}" in names
    version = re.search(r'__version__ = "(.+)"', (ROOT / "wpcal/core/version.py").read_text(encoding="utf-8"))
    assert package.findtext("p:version", namespaces=space) == version[1]
    license_file = package.find("p:license", space)
    assert f"WpCal/{license_file.get('file')}" in names


def test_the_published_tree_has_an_address_and_a_maintainer(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "cad.freecad.build", str(tmp_path / "tree")]
    who = ["https://host.example/owner/repository", "Anna & Co <anna@host.example>"]
    subprocess.run([*command, *who], cwd=ROOT, check=True)
    package = ET.parse(tmp_path / "tree" / "package.xml").getroot()
    space = {"p": "https://wiki.freecad.org/Package_Metadata"}
    urls = {one.get("type"): (one.text, one.get("branch")) for one in package.iterfind("p:url", space)}
    assert urls["repository"] == (who[0], "main")
    assert urls["bugtracker"] == (f"{who[0]}/issues", None)
    maintainer = package.find("p:maintainer", space)
    assert (maintainer.text, maintainer.get("email")) == ("Anna & Co", "anna@host.example")
    assert (tmp_path / "tree" / "freecad" / "wpcal_wb" / "init_gui.py").is_file()
    for wrong in (["http://host.example/a", who[1]], [who[0], "nobody"]):
        assert subprocess.run([*command, *wrong], cwd=ROOT, check=False, capture_output=True).returncode == 1


HALF_STEP = 0.5 / 255  #: The pages round to whole numbers from 0 to 255.


@pytest.fixture(scope="module")
def colours() -> ModuleType:
    path = ROOT / "cad/freecad/freecad/wpcal_wb/view/colours.py"
    spec = importlib.util.spec_from_file_location("workbench_colours", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_scale_is_that_of_the_pages(colours: ModuleType) -> None:
    source = (ROOT / "wpcal/pages/source/src/colours.js").read_text(encoding="utf-8")
    stops = re.search(r"STOPS = (\[.*?\]);", source, re.DOTALL)
    beyond = re.search(r'BEYOND = "#(\w{6})"', source)
    listed = json.loads(re.sub(r",(\s*\])", r"\1", stops[1]))
    assert listed == [[share, list(colour)] for share, colour in colours.STOPS]
    assert bytes.fromhex(beyond[1]) == bytes(colours.BEYOND)


def test_errors_on_above_and_beside_the_scale(colours: ModuleType) -> None:
    for share, colour in colours.STOPS:
        assert colours.colour_of(share) == pytest.approx([value / 255 for value in colour], abs=HALF_STEP)
    between = colours.colour_of(0.15)
    assert between == pytest.approx([40 / 255, 144.5 / 255, 130.5 / 255], abs=HALF_STEP)
    assert colours.colour_of(1.01) == colours.unit(colours.BEYOND)
    assert colours.colour_of(None) == colours.colour_of(float("nan")) == colours.unit(colours.UNKNOWN)
