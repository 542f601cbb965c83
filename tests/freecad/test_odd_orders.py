"""Odd orders in FreeCAD's window: one run of `inside/steps_odd.py`."""

import os
import sys
from pathlib import Path

import pytest

from tests.freecad.running import install_addon
from tests.freecad.window import missing_tools, run_in_window

STEPS = Path(__file__).parent / "inside" / "steps_odd.py"
LONGEST_S = 120


@pytest.mark.deep
def test_every_odd_order_has_a_clear_end(tmp_path: Path) -> None:
    if missing_tools():
        pytest.skip(f"not installed: {', '.join(missing_tools())}")
    environment = {"PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}", "WPCAL_CACHE": "off"}
    addon = install_addon(tmp_path) / "WpCal"
    facts = run_in_window(STEPS, tmp_path, seconds=LONGEST_S, addon=addon, environment=environment).facts
    assert facts["empty"] == "no solid in the visible objects of the document"
    assert facts["closed with its document"]
    assert facts["missing"].startswith("/nowhere/wpcal (preferences) cannot be started.")
    assert "install" in facts["missing"]
    assert facts["clicked"] == ["W2"]
    assert facts["changed"] == "The part has changed: what was decided about W2 does not fit any more."
    assert facts["start in the part"] == [25, 56, 10]
    assert facts["no number"].endswith("expected a number, got abc")
    assert facts["corner"] == [200, 0, 10]
