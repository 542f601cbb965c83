"""Progress messages of long-running steps."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str], None]
"""Takes one message per step."""


def no_progress(_: str) -> None:
    """Discard progress messages."""
