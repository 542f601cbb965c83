"""Pages in the browser of `tests/conftest.py`: open, wait, read pixels."""

import io
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from wpcal.core.arrays import FloatArray

WAIT_S = 60  #: The browser draws without a graphics card, and the machine may be busy.


@dataclass
class OpenPage:
    """A page under test, with its messages and requests."""

    page: Any
    said: list[str] = field(default_factory=list)  #: Messages of the console, and errors of the scripts.
    asked: list[str] = field(default_factory=list)  #: Requested addresses; the first is the page itself.

    def hear(self, message: Any) -> None:
        """Keep a message of the console, but for one about the browser's own reading of what WebGL drew."""
        if "GPU stall due to ReadPixels" not in message.text:
            self.said.append(f"{message.type}: {message.text}")

    def wait(self, condition: str) -> None:
        """Wait until a JavaScript expression is true; playwright's own way needs `eval`, which the page forbids."""
        end = time.monotonic() + WAIT_S
        while not self.page.evaluate(condition):
            assert time.monotonic() < end, f"waited {WAIT_S} s in vain: {condition}; the page said {self.said}"
            self.page.wait_for_timeout(50)

    def pixels(self, selector: str = ".stage") -> FloatArray:
        """Picture of an element, 0…255, shape (height, width, 3)."""
        from matplotlib.image import imread

        self.page.evaluate("() => window.wpcal.viewer.draw()")  # at once, not before the next frame
        image = imread(io.BytesIO(self.page.locator(selector).screenshot()))
        return np.asarray(np.rint(255.0 * image[..., :3]), dtype=np.float64)

    def project(self, p: list[float]) -> tuple[float, float]:
        """Pixel of the window in which a place (base, mm) is drawn."""
        found = self.page.evaluate("p => window.wpcal.project(p)", p)
        box = self.page.locator(".stage canvas").bounding_box()
        return box["x"] + found["x"], box["y"] + found["y"]


def _opener(browser: Any) -> Iterator[Any]:
    """Yield a function that opens a file (or an address) and waits until the page is complete."""
    contexts = []

    def opened(target: Path | str, *, width: int = 1280, height: int = 900) -> OpenPage:
        context = browser.new_context(viewport={"width": width, "height": height})
        contexts.append(context)
        found = OpenPage(context.new_page())
        found.page.on("console", found.hear)
        found.page.on("pageerror", lambda error: found.said.append(f"error: {error}"))
        found.page.on("request", lambda request: found.asked.append(request.url))
        found.page.goto(target.as_uri() if isinstance(target, Path) else target)
        found.wait("Boolean(window.wpcal && window.wpcal.ready)")
        return found

    yield opened
    for context in contexts:
        context.close()


open_page = pytest.fixture(_opener)
open_pages = pytest.fixture(_opener, scope="module")  #: Several tests look at them: opening costs more than looking.


class Picker:
    """`wpcal pick` in a process of its own."""

    def __init__(self, folder: Path, answers: Path, *arguments: str | Path) -> None:
        command = [sys.executable, "-m", "wpcal", "pick", *map(str, arguments), "--no-browser"]
        environment = {**os.environ, "WPCAL_CACHE": str(answers)}
        self.process = subprocess.Popen(
            command, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
        )
        self.said = self.process.stdout.readline()
        self.url = next((word for word in self.said.split() if word.startswith("http://")), "")
        assert self.url, f"{self.said}{self.process.communicate(timeout=60)[1]}"

    def end(self) -> tuple[int, str, str]:
        """Press Ctrl-C."""
        self.process.send_signal(signal.SIGINT)
        out, errors = self.process.communicate(timeout=60)
        return self.process.returncode, out, errors

    def kill(self) -> None:
        """End the process at once, as a power cut does."""
        self.process.kill()
        self.process.communicate(timeout=60)


@pytest.fixture
def start(tmp_path: Path, answers: Path) -> Iterator[Any]:
    """Return a function that starts a picker in `tmp_path`; pickers that still run at the end are killed."""
    running: list[Picker] = []

    def started(*arguments: str | Path) -> Picker:
        running.append(Picker(tmp_path, answers, *arguments))
        return running[-1]

    yield started
    for picker in running:
        if picker.process.poll() is None:
            picker.process.kill()
            picker.process.communicate()
