"""The script with which a user of any FreeCAD tries the workbench."""

import os
import subprocess
import sys
from pathlib import Path

from tests.freecad.running import LONGEST_S, freecad_environment, install_addon, needs_freecad


@needs_freecad
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
