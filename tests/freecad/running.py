"""Runs tests inside FreeCAD: `freecadcmd -t` in a fresh home, with the workbench unpacked from its ZIP file."""

import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
INSIDE = Path(__file__).parent / "inside"
LONGEST_S = 180  #: A FreeCAD that hangs is ended after this time.

needs_freecad = pytest.mark.skipif(shutil.which("freecadcmd") is None, reason="FreeCAD is not installed")


def install_addon(home: Path) -> Path:
    """Build the ZIP file, unpack it into the folder `Mod` of a fresh home, and return that folder."""
    target = home / "workbench.zip"
    subprocess.run([sys.executable, "-m", "cad.freecad.build", str(target)], cwd=ROOT, check=True)
    mod = home / ".local/share/FreeCAD/Mod"
    with zipfile.ZipFile(target) as archive:
        archive.extractall(mod)
    return mod


def freecad_environment(home: Path) -> dict[str, str]:
    """Return the environment of a FreeCAD whose user has this home."""
    kept = {name: value for name, value in os.environ.items() if not name.startswith(("XDG_", "FREECAD_", "PYTHON"))}
    return {
        **kept,
        "HOME": str(home),
        "WPCAL_TEST_PYTHON": sys.executable,
        "WPCAL_TEST_FOLDER": str(home / "work"),
        "WPCAL_TEST_ROOT": str(ROOT),
        "WPCAL_CACHE": "off",
    }


def run_inside(case: str, home: Path, *options: str, **variables: str) -> str:
    """Run the tests of a module in `inside` and return what FreeCAD printed; a failure is the caller's failure."""
    (home / "work").mkdir(exist_ok=True)
    command = ["freecadcmd", "-P", str(INSIDE), *options, "-t", case]
    done = subprocess.run(
        command,
        env={**freecad_environment(home), **variables},
        cwd=home,
        stdin=subprocess.DEVNULL,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        timeout=LONGEST_S,
        check=False,
        text=True,
        errors="replace",
    )
    assert done.returncode == 0, done.stdout
    assert "Ran 0 tests" not in done.stdout, done.stdout
    return done.stdout
