"""FreeCAD with its window, on a display of its own: Xvfb, openbox and software GL.

`run_in_window` starts FreeCAD with `inside/driver.py`, which plays a file of steps and writes what came of them. The
steps talk to FreeCAD from its own event loop and click with xdotool, so the window gets what a person's mouse sends.

FreeCAD ends with code 0 although a script raised. The result file of the driver and what FreeCAD said are what counts.
The names of files travel in the environment: FreeCAD opens every argument that is a file.
"""

from __future__ import annotations

import contextlib
import json
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

WINDOW_PX = (1280, 800)
TOOLS = ("freecad", "Xvfb", "openbox", "xdotool", "import")
DRIVER = Path(__file__).parent / "inside" / "driver.py"

GRACE_S = 5.0  #: So long a process has after the request to end. Then it is killed.

SETTINGS = """<?xml version="1.0" encoding="UTF-8" standalone="no" ?>
<FCParameters>
<FCParamGroup Name="Root"><FCParamGroup Name="BaseApp"><FCParamGroup Name="Preferences">
  <FCParamGroup Name="General"><FCText Name="AutoloadModule">{workbench}</FCText></FCParamGroup>
  <FCParamGroup Name="View">
    <FCBool Name="Simple" Value="1"/><FCBool Name="Gradient" Value="0"/><FCBool Name="RadialGradient" Value="0"/>
    <FCUInt Name="BackgroundColor" Value="4244635647"/><FCBool Name="UseNavigationAnimations" Value="0"/>
  </FCParamGroup>
  <FCParamGroup Name="OutputWindow">
    <FCBool Name="checkShowReportViewOnWarning" Value="0"/><FCBool Name="checkShowReportViewOnError" Value="0"/>
  </FCParamGroup>
</FCParamGroup></FCParamGroup></FCParamGroup>
</FCParameters>
"""
"""No start page (it loads a browser), and a plain background: pictures of it are small files."""


class WindowRunError(AssertionError):
    """The steps did not come to their end; the message says where, and what FreeCAD said."""


@dataclass(frozen=True, slots=True)
class WindowRun:
    """What a run of steps left: the facts that the steps noted, and how long FreeCAD ran."""

    facts: Mapping[str, Any]
    seconds: float


def missing_tools() -> list[str]:
    """Return the programs that a run needs and that are not on this machine."""
    return [tool for tool in TOOLS if shutil.which(tool) is None]


@contextlib.contextmanager
def own_display(folder: Path) -> Iterator[dict[str, str]]:
    """Start Xvfb and openbox; yield the environment of programs that are to be shown there."""
    home = folder / "home"
    (home / "freecad").mkdir(parents=True, exist_ok=True)
    for_display, from_xvfb = os.pipe()
    size = "x".join(map(str, WINDOW_PX))
    arguments = ["Xvfb", "-displayfd", str(from_xvfb), "-screen", "0", f"{size}x24", "-dpi", "96", "-nolisten", "tcp"]
    server = subprocess.Popen(arguments, pass_fds=[from_xvfb], **_quiet())
    os.close(from_xvfb)
    try:
        with os.fdopen(for_display) as reader:
            display = f":{reader.readline().strip()}"  # Xvfb writes it when it is ready
        environment = {
            name: value for name, value in os.environ.items() if not name.startswith(("QT_", "PYTHON", "XDG_"))
        }
        environment |= {
            "DISPLAY": display,
            "HOME": str(home),
            "FREECAD_USER_HOME": str(home / "freecad"),
            "LIBGL_ALWAYS_SOFTWARE": "1",
            "QTWEBENGINE_DISABLE_SANDBOX": "1",  # FreeCAD loads QtWebEngine, and tests run as root in containers
            "QT_QPA_PLATFORM": "xcb",  # `offscreen` has no GL context: the 3-D view crashes
        }
        manager = subprocess.Popen(["openbox"], env=environment, **_quiet())
        try:
            yield environment
        finally:
            _end(manager)
    finally:
        _end(server)


def run_in_window(
    steps: Path,
    folder: Path,
    *,
    seconds: float,
    workbench: str = "PartWorkbench",
    addon: Path | None = None,
    environment: Mapping[str, str] | None = None,
) -> WindowRun:
    """Run a file of steps in FreeCAD's window.

    `steps`: A Python file with a generator function `steps(window)`; see `inside/driver.py`.
    `folder`: For FreeCAD's settings, what it said, and the pictures.
    `seconds`: FreeCAD is ended after this time.
    `workbench`: Which workbench is active at the start.
    `addon`: A folder of an addon; it is put into `Mod/`.
    `environment`: More variables for FreeCAD.

    Raises `WindowRunError` if a step raised or waited in vain, FreeCAD reported an exception, crashed, or ran out of
    time.
    """
    result, output_file = folder / "result.json", folder / "output.txt"
    start = time.monotonic()
    with own_display(folder) as shown:
        settings = Path(shown["FREECAD_USER_HOME"])
        (settings / "user.cfg").write_text(SETTINGS.format(workbench=workbench), encoding="utf-8")
        if addon is not None:
            (settings / "Mod").mkdir(exist_ok=True)
            (settings / "Mod" / addon.name).symlink_to(addon, target_is_directory=True)
        asked = {"WPCAL_STEPS": str(steps), "WPCAL_STEPS_FOLDER": str(folder), "WPCAL_STEPS_RESULT": str(result)}
        with output_file.open("wb") as output:
            process = subprocess.Popen(
                ["freecad", str(DRIVER)],
                env={**shown, **(environment or {}), **asked},
                stdin=subprocess.DEVNULL,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
            try:
                code: int | None = process.wait(seconds)
            except subprocess.TimeoutExpired:
                code = None
            finally:
                _end(process)
    return WindowRun(_judged(result, code, seconds, output_file), time.monotonic() - start)


def _judged(result: Path, code: int | None, seconds: float, log: Path) -> dict[str, Any]:
    text = log.read_text(encoding="utf-8", errors="replace")
    found = json.loads(result.read_text(encoding="utf-8")) if result.is_file() else {}
    fault = found.get("fault")
    if not fault and code is None:
        fault = f"FreeCAD did not end within {seconds:g} s"
    if not fault and not found:
        fault = f"FreeCAD ended with code {code}, and no step reported"
    if not fault and code:
        fault = f"the steps are done, and FreeCAD ended with code {code}"
    if not fault and "Traceback (most recent call last)" in text:
        fault = "FreeCAD reported an exception"
    if fault:
        raise WindowRunError(f"{fault}\n--- FreeCAD said:\n{text[-6000:]}")
    facts: dict[str, Any] = found["facts"]
    return facts


def _quiet() -> dict[str, Any]:
    return {"stdin": subprocess.DEVNULL, "stdout": subprocess.DEVNULL, "stderr": subprocess.DEVNULL}


def _end(process: subprocess.Popen[bytes]) -> None:
    """End a process, with what it started if it leads a session of its own."""
    leads = os.getpgid(process.pid) == process.pid if process.poll() is None else False
    with contextlib.suppress(ProcessLookupError):
        for number in (signal.SIGTERM, signal.SIGKILL):
            if process.poll() is not None:
                break
            os.killpg(process.pid, number) if leads else process.send_signal(number)
            with contextlib.suppress(subprocess.TimeoutExpired):
                process.wait(GRACE_S)
