"""The runs in FreeCAD's window fail when something in them fails: FreeCAD itself ends with code 0."""

from pathlib import Path

import pytest

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
