"""The workbench in FreeCAD without a window."""

import os
import sys
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


def test_the_part_at_its_pose(home: Path) -> None:
    run_inside("case_placed", home)


def test_the_objects_of_a_document(home: Path) -> None:
    run_inside("case_document", home)


def test_the_whole_job(home: Path) -> None:
    run_inside("case_job", home, PATH=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")


def test_a_document_is_saved_and_opened_with_and_without_the_workbench(home: Path, tmp_path: Path) -> None:
    for step, user in (("write", home), ("with", home), ("without", tmp_path), ("with", home)):
        run_inside("case_saving", user, WPCAL_TEST_STEP=step, WPCAL_TEST_FOLDER=str(home / "work"))
