"""What installed packages bring to wpcal: commands, controllers, formats."""

from __future__ import annotations

import sys
from functools import cache
from importlib.metadata import EntryPoint, entry_points


def installed(group: str) -> tuple[EntryPoint, ...]:
    """Return the entry points of a group.

    All installed packages are searched for them, which takes 4 ms for 150 packages. The answer is kept until the
    path of imports changes: every command asks four times for the commands, `wpcal audit` twice for every program.
    """
    return _installed(group, tuple(sys.path))


@cache
def _installed(group: str, _path: tuple[str, ...]) -> tuple[EntryPoint, ...]:
    return tuple(entry_points(group=group))
