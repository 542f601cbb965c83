"""The workbench without a window: its smoke test and its job."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.freecad.running import LONGEST_S, freecad_environment, install_addon, needs_freecad, run_inside

pytestmark = needs_freecad


@pytest.fixture(scope="module")
def home(tmp_path_factory: pytest.TempPathFactory) -> Path:
    home = tmp_path_factory.mktemp("freecad")
    install_addon(home)
    return home


@pytest.mark.parametrize("case", ["client", "placed", "document", "job"])
def test_the_workbench(case: str, home: Path) -> None:
    run_inside(f"case_{case}", home, PATH=f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}")


def test_a_document_is_saved_and_opened_with_and_without_the_workbench(home: Path, tmp_path: Path) -> None:
    for step, user in (("write", home), ("with", home), ("without", tmp_path), ("with", home)):
        run_inside("case_saving", user, WPCAL_TEST_STEP=step, WPCAL_TEST_FOLDER=str(home / "work"))


@pytest.mark.deep
def test_the_smoke_test_works_without_a_window(tmp_path: Path) -> None:
    mod = install_addon(tmp_path)
    environment = freecad_environment(tmp_path)
    environment["PATH"] = f"{Path(sys.executable).parent}{os.pathsep}{environment['PATH']}"
    done = subprocess.run(
        ["freecadcmd", str(mod / "WpCal" / "smoke.py")],
        env=environment,
        cwd=tmp_path,
        stdin=subprocess.DEVNULL,
        capture_output=True,
        timeout=LONGEST_S,
        check=False,
        text=True,
        errors="replace",
    )
    assert "wpcal smoke test: everything worked" in done.stdout, done.stdout + done.stderr
    assert "FAILED" not in done.stdout
