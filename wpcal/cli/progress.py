"""What a waiting user sees of long work: a moving line on a terminal, otherwise one line per step on stderr.

Without a terminal (in a log, in a pipe) a command that ends within `USUAL_PATIENCE_S` prints its result only. After
that it says what it is doing and since when it runs, then each new step, and every `REPEAT_S` a step that lasts.
"""

from __future__ import annotations

import os
import re
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar

import click

from wpcal.core.progress import Progress
from wpcal.core.wording import printable

USUAL_PATIENCE_S = 2.0  #: Who waits longer wants to know what for. A command that ends sooner says its result only.
REPEAT_S = 10.0
"""A step that lasts is said again after this time, with its numbers: whoever reads the log sees that it goes on."""
PATIENCE_VARIABLE = "WPCAL_PROGRESS_AFTER_S"  #: Environment variable that changes it; 0 says every step at once.
LONGEST_S = threading.TIMEOUT_MAX
_NUMBERS = re.compile(r"\d+")

CountedProgress = Callable[[str, int, int], None]
"""Takes the step, how much of it is done, and of how much."""


_TOLD: ContextVar[Progress | None] = ContextVar("told", default=None)


@contextmanager
def progress_told_to(told: Progress) -> Iterator[None]:
    """Let commands that run inside tell their steps to a function, not on stderr."""
    before = _TOLD.set(told)
    try:
        yield
    finally:
        _TOLD.reset(before)


@contextmanager
def shown_progress(start: str) -> Iterator[Progress]:
    """Yield a function that shows what is being done."""
    told = _TOLD.get()
    if told is not None:
        told(start)
        yield told
        return
    if sys.stderr.isatty():
        from rich.markup import escape

        from wpcal.cli.console import plain_console

        with plain_console(stderr=True).status(escape(printable(start))) as status:
            yield lambda text: status.update(escape(printable(text)))
        return
    lines = _Lines(start, _patience_s())
    try:
        yield lines
    finally:
        lines.end()


@contextmanager
def counted_progress(start: str) -> Iterator[CountedProgress]:
    """Yield a function that shows how much of each step is done; a bar on a terminal."""
    if sys.stderr.isatty() and _TOLD.get() is None:
        from rich.markup import escape
        from rich.progress import Progress as Bars

        from wpcal.cli.console import plain_console

        with Bars(console=plain_console(stderr=True), transient=True) as bar:
            task = bar.add_task(escape(printable(start)))
            yield lambda what, done, of: bar.update(task, description=escape(printable(what)), completed=done, total=of)
        return
    with shown_progress(start) as show:
        yield lambda what, done, of: show(f"{what}: {done} of {of}")


def _patience_s() -> float:
    try:
        return min(max(float(os.environ[PATIENCE_VARIABLE]), 0.0), LONGEST_S)
    except (KeyError, ValueError):
        return USUAL_PATIENCE_S


class _Lines:
    """Prints one line per step, and a line about a step that lasts from time to time."""

    def __init__(self, start: str, patience_s: float) -> None:
        self._text, self._said = start, ""
        self._began = self._said_at = time.monotonic()
        self._speaks = False
        self._lock = threading.Lock()
        self._ended = threading.Event()
        if not patience_s:
            self._speaks = True
            self._say()
        self._thread = threading.Thread(target=self._speak_later, args=(patience_s or REPEAT_S,), daemon=True)
        self._thread.start()

    def __call__(self, text: str) -> None:
        with self._lock:
            self._text = text
            if self._speaks and _step(text) != _step(self._said):
                self._say()

    def end(self) -> None:
        """Say nothing more."""
        self._ended.set()

    def _speak_later(self, wait_s: float) -> None:
        while not self._ended.wait(wait_s):
            with self._lock:
                wait_s = self._said_at + REPEAT_S - time.monotonic() if self._speaks else 0.0
                self._speaks = True
                if wait_s <= 0 and not self._ended.is_set():
                    self._say()
                    wait_s = REPEAT_S

    def _say(self) -> None:
        self._said = self._text
        self._said_at = time.monotonic()
        seconds = round(self._said_at - self._began)
        click.echo(f"wpcal: {' '.join(self._text.split())} … ({seconds} s)", err=True)


def _step(text: str) -> str:
    """Return a message without its numbers: the step that it is about."""
    return _NUMBERS.sub("", text)
