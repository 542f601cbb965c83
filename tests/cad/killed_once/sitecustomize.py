"""Python imports this at its start: kills one process of a batch at the nth change of a folder by any of them.

The environment says where changes are counted (KILL_PLACE, KILL_COUNT), at which of them (KILL_MOMENT) and whom
(KILL_VICTIM). KILL_TOKEN is a file: whoever can remove it kills, so that only one is killed.
"""

import os
import signal
import sys

EVENTS = ("os.rename", "os.link", "os.remove", "os.rmdir", "os.mkdir", "os.chmod")
LOOKS_UP = "ctypes.dlsym"  #: `renameat2` is looked up by ctypes: the exchange of two folders follows that event.
_place, _moment = os.environ.get("KILL_PLACE", ""), int(os.environ.get("KILL_MOMENT", "0"))


def _kill(event: str, arguments: tuple[object, ...]) -> None:
    changes = event in EVENTS and any(_place in str(each) for each in arguments)
    if not changes and not (event == LOOKS_UP and "renameat2" in str(arguments)):
        return
    count = os.open(os.environ["KILL_COUNT"], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
    os.write(count, b".")
    size = os.fstat(count).st_size
    os.close(count)
    if size >= _moment:
        try:
            os.unlink(os.environ["KILL_TOKEN"])
        except FileNotFoundError:
            return
        os.kill(_victim(), signal.SIGKILL)


def _victim() -> int:
    """Return the process that is killed; the one that changes something if there is no such process yet."""
    asked, server = os.environ["KILL_VICTIM"], int(os.environ.get("KILL_SERVER", "0"))
    if asked == "command":
        return int(os.environ["KILL_COMMAND"])
    if asked == "server" and server:
        return server
    return os.getpgrp() if asked == "group" and server not in (0, os.getpid()) else os.getpid()


if _moment:
    if "KILL_COMMAND" not in os.environ:
        os.environ["KILL_COMMAND"] = str(os.getpid())
    elif "cad.work.server" in sys.orig_argv:
        os.environ["KILL_SERVER"] = str(os.getpid())
    sys.addaudithook(_kill)
