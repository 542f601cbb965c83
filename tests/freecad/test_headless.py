"""The workbench in FreeCAD without a window."""

from pathlib import Path

import pytest

from tests.freecad.running import install_addon, needs_freecad, run_inside

pytestmark = needs_freecad


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    home = tmp_path_factory.mktemp("freecad")
    install_addon(home)
    return home


def test_the_client(home: Path) -> None:
    run_inside("case_client", home)
