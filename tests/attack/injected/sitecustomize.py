"""Python imports this at its start: kills the process at its nth change of a folder, if the environment asks for it."""

import itertools
import os
import signal
import sys

EVENTS = ("os.rename", "os.link", "os.remove", "os.rmdir", "os.mkdir", "os.chmod")
LOOKS_UP = "ctypes.dlsym"  #: `renameat2` is looked up by ctypes: the exchange of two folders follows that event.
_place, _moment = os.environ.get("ATTACK_PLACE", ""), int(os.environ.get("ATTACK_MOMENT", "0"))
_count = itertools.count(1)


def _kill(event: str, arguments: tuple[object, ...]) -> None:
    changes = event in EVENTS and any(_place in str(each) for each in arguments)
    exchanges = event == LOOKS_UP and "rename" in str(arguments)
    if (changes or exchanges) and next(_count) == _moment:
        os.kill(os.getpid(), signal.SIGKILL)


if _moment:
    sys.addaudithook(_kill)
