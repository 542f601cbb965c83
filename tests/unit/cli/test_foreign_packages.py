"""A package of another project that has the name of one of ours is told in one line."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.running import TIMEOUT_S


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
