"""How commands start: threads, and packages of others beside them."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.running import TIMEOUT_S

SHOWN = """
import os, sys
from wpcal.cli import main
print("numpy" in sys.modules)
main.wpcal.main = lambda **_: print(os.environ["OPENBLAS_NUM_THREADS"], os.environ["OMP_NUM_THREADS"])
main.run([])
"""


def test_a_command_computes_with_one_thread() -> None:
    many = {"OPENBLAS_NUM_THREADS": "8", "OMP_NUM_THREADS": "8"}
    done = subprocess.run(
        [sys.executable, "-c", SHOWN], env={**os.environ, **many}, capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["False", "1", "1"]


@pytest.mark.parametrize("file", ["cad/__init__.py", "cad.py"])
def test_a_foreign_cad_is_named(tmp_path: Path, file: str) -> None:
    foreign = tmp_path / "other project" / file
    foreign.parent.mkdir(parents=True)
    foreign.write_text("")
    (tmp_path / "empty").mkdir()
    done = subprocess.run(
        [Path(sys.executable).with_name("wpcal"), "features", "part.step"],
        env={**os.environ, "PYTHONPATH": str(tmp_path / "other project")},
        cwd=tmp_path / "empty",
        capture_output=True,
        text=True,
        check=False,
        timeout=TIMEOUT_S,
    )
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "another package is called cad and hides the one of wpcal" in done.stderr
    assert str(foreign if file == "cad.py" else foreign.parent) in done.stderr
