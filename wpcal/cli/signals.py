"""Signals that ask a command to end: it ends as after Ctrl-C, so that nothing half done stays."""

from __future__ import annotations

import math
import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import FrameType

ENDING = tuple(getattr(signal, name) for name in ("SIGINT", "SIGTERM", "SIGHUP") if hasattr(signal, name))
"""Ctrl-C, and what a shell, a service manager or a closed terminal sends. Windows has no SIGHUP."""

SOON_S = 2.0  #: To remove what was begun takes less than this. A signal that comes later ends the removal, too.


class Stopped(KeyboardInterrupt):
    """A signal asked this process to end."""

    def __init__(self, number: int) -> None:
        super().__init__(signal.Signals(number).name)
        self.number = number


AGAIN_S = 0.05  #: A signal that comes where Python drops errors is sent again after this.


def _is_swallowed(frame: FrameType | None) -> bool:
    """Tell whether an error that is raised here is dropped: within a destructor, at any depth."""
    while frame is not None:
        if frame.f_code.co_name == "__del__":
            return True
        frame = frame.f_back
    return False


@contextmanager
def stopped_like_interrupted() -> Iterator[list[KeyboardInterrupt]]:
    """Let these signals raise `Stopped`, unless the caller of this process ignores them (`nohup`).

    A signal that comes soon after another one changes nothing: what was begun is being removed.

    Yields what was raised so far, of Ctrl-C, too. An interruption comes at any line, also within Python's import
    machinery, which may answer it with an error of its own: such an error is an interruption, not a fault.
    """
    raised = list[KeyboardInterrupt]()
    if threading.current_thread() is not threading.main_thread():
        yield raised
        return

    last_s = -math.inf

    def stop(number: int, frame: FrameType | None) -> None:
        nonlocal last_s
        if _is_swallowed(frame):
            threading.Timer(AGAIN_S, os.kill, (os.getpid(), number)).start()
            return
        now_s = time.monotonic()
        if now_s - last_s < SOON_S:
            return
        last_s = now_s
        raised.append(KeyboardInterrupt() if number == signal.SIGINT else Stopped(number))
        raise raised[-1]

    handlers = {number: signal.getsignal(number) for number in ENDING}
    taken = {n: handler for n, handler in handlers.items() if handler in (signal.SIG_DFL, signal.default_int_handler)}
    for number in taken:
        signal.signal(number, stop)
    try:
        yield raised
    finally:
        for number, handler in taken.items():
            signal.signal(number, handler)
