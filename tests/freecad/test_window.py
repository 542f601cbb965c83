"""The workbench in FreeCAD's window, also in odd orders."""

import os
import sys
from pathlib import Path

import pytest

from tests.freecad.running import install_addon
from tests.freecad.window import WindowRunError, missing_tools, run_in_window

FAULTS = {
    "raise ValueError('in a step')": "in the step 'first': .*in a step",
    "QtCore.QTimer.singleShot(1, lambda: 1 / 0); yield 1": "in the step 'first': .*ZeroDivisionError",
    "FreeCAD.Console.PrintError('Traceback (most recent call last):'); yield 0": "FreeCAD reported an exception",
    "os.abort()": "ended with code -6",
    "time.sleep(100)": "did not end within 8 s",
}


@pytest.mark.deep
@pytest.mark.parametrize("line", FAULTS)
def test_a_fault_in_a_step_fails_the_run(line: str, tmp_path: Path) -> None:
    if missing_tools():
        pytest.skip(f"not installed: {', '.join(missing_tools())}")
    steps = tmp_path / "steps.py"
    head = (
        "import os, time\nimport FreeCAD\nfrom PySide import QtCore\n\n\ndef steps(window):\n    window.say('first')\n"
    )
    steps.write_text(f"{head}    yield 0\n    {line}\n", encoding="utf-8")
    with pytest.raises(WindowRunError, match=f"(?s){FAULTS[line]}"):
        run_in_window(steps, tmp_path, seconds=8)


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
