"""Memory of large parts: how often Python looks for objects that only hold each other, and what is given back."""

from __future__ import annotations

import ctypes
import gc
import sys

NEW_OBJECTS = 100_000
"""Python's own 700 made it look a thousand times while the records of a large part were made: three quarters of that
time, and nothing was found."""
OLDER_ROUNDS = 50  #: Older objects are looked at after so many rounds of the younger ones.


def collect_rarely() -> None:
    """Look for such objects after `NEW_OBJECTS` new ones: for processes that make large results and then end."""
    gc.set_threshold(NEW_OBJECTS, OLDER_ROUNDS, OLDER_ROUNDS)


def give_memory_back() -> None:
    """Give free pages back to the system where its C library can (glibc): new arrays take other pages."""
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim is not None:  # musl has none
        trim(0)
