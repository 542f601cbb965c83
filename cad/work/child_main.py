"""The child's side of `cad.work.child`; not meant to be run by hand.

``python -P -m cad.work.child_main PARENT`` takes one request from standard input, calls the function, and sends
frames over what was standard output. It ends when the process PARENT ends. That is arranged before anything large is
imported, so this module imports only the standard library.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Mapping
from types import FrameType
from typing import IO, Any

from cad.work.own_process import (
    end_at_end_of,
    end_with_parent,
    function_named,
    has_death_signal,
    limit_memory,
    outcome_of,
    private_output,
    told_fault,
)

_ALARM_GRACE_S = 30  #: The child ends itself this long after its time limit, in case its parent cannot.


class _AskedToEndError(BaseException):
    """The parent was interrupted: what was begun is removed."""


def main() -> None:
    """Take one request from standard input, run it, and send frames over what was standard output."""
    end_with_parent(int(sys.argv[1]))
    signal.signal(signal.SIGTERM, _raise_asked_to_end)
    from cad.work.frames import read_packet
    from cad.work.plain_data import unpack

    request = read_packet(sys.stdin.buffer)
    if request is None:
        os._exit(0)  # the parent ended
    if not has_death_signal():
        end_at_end_of(sys.stdin.fileno())
    channel = private_output()
    target, arguments, wants_progress, time_s, memory_gb = unpack(request)
    _limit_time(time_s)
    limit_memory(memory_gb)
    try:
        _answer(channel, target, arguments, wants_progress=wants_progress)
    except _AskedToEndError:
        os._exit(128 + signal.SIGTERM)
    os._exit(0)  # the kernel's own shutdown can crash after all work is done


def _raise_asked_to_end(_number: int, _frame: FrameType | None) -> None:
    raise _AskedToEndError


def _limit_time(time_s: float) -> None:
    if hasattr(signal, "alarm"):
        signal.alarm(int(time_s) + _ALARM_GRACE_S)


def _answer(channel: IO[bytes], target: str, arguments: Mapping[str, Any], *, wants_progress: bool) -> None:
    """Call the function and send its result, its error, or a defect as one frame."""
    from cad.work.frames import write_frame
    from cad.work.system_libraries import libgl_explained
    from wpcal.core.process import collect_rarely

    collect_rarely()
    progress = {"progress": lambda text: write_frame(channel, "progress", text)} if wants_progress else {}

    def work() -> Any:
        with libgl_explained():
            return function_named(target)(**arguments, **progress)

    kind, value = outcome_of(work)
    if kind == "result":  # what cannot be sent is told as well
        kind, value = outcome_of(lambda: write_frame(channel, kind, value))
    if kind != "result":
        write_frame(channel, kind, told_fault(value) if kind == "fault" else value)


if __name__ == "__main__":
    main()
