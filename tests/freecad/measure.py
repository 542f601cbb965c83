"""Measure the workbench in FreeCAD's window: `python -m tests.freecad.measure`.

Prints how long a person waits for the first features of a part with 300 faces, how long an edit takes until its
residuals are shown, and how many pictures per second a view with 10 000 seam frames has with software GL. The numbers
depend on the machine, so no test asserts them.
"""

import json
import os
import sys
import tempfile
from pathlib import Path

from tests.freecad.running import ROOT, install_addon
from tests.freecad.window import run_in_window

MEASURED = ("steps_features", "steps_refit", "steps_frames")
LONGEST_S = 240


def main() -> None:
    """Run each file of steps and print its facts."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = {"WPCAL_TEE": str(ROOT / "fixtures" / "tee"), "PATH": path, "WPCAL_CACHE": "off"}
    for name in MEASURED:
        with tempfile.TemporaryDirectory() as made:
            folder = Path(made)
            addon = install_addon(folder) / "WpCal"
            steps = Path(__file__).parent / "inside" / f"{name}.py"
            run = run_in_window(steps, folder, seconds=LONGEST_S, addon=addon, environment=environment)
        print(name, json.dumps(dict(run.facts), indent=1))


if __name__ == "__main__":
    main()
