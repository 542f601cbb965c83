"""Photograph the FreeCAD workbench for docs/how-to/freecad.md: `make shots`, or this script.

Needs FreeCAD, Xvfb, openbox, xdotool and ImageMagick (`sh .ci/freecad`). The pictures are those of the test of the
whole job (`tests/freecad/inside/steps_job.py`).
"""

import os
import shutil
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tests.freecad.running import install_addon  # noqa: E402  # the tests are not installed
from tests.freecad.window import run_in_window  # noqa: E402

STEPS = ROOT / "tests" / "freecad" / "inside" / "steps_job.py"
LONGEST_S = 180


def main() -> None:
    """Run the job in a window and keep its pictures."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        addon = install_addon(folder) / "WpCal"
        environment = {"WPCAL_TEE": str(ROOT / "fixtures" / "tee"), "PATH": path}
        run_in_window(STEPS, folder, seconds=LONGEST_S, addon=addon, environment=environment)
        for picture in sorted(folder.glob("freecad-*.png")):
            shutil.copy(picture, ROOT / "docs" / "images" / picture.name)
            print(f"{picture.name}: {picture.stat().st_size} bytes")


if __name__ == "__main__":
    main()
