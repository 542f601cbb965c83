"""Lines of text for who waits: what a long step is doing now."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[str], None]
"""Gets a line for every step."""


def no_progress(_: str) -> None:
    """Say nothing: for callers whom nobody waits for."""
