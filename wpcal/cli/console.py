"""The console on which the commands print their tables."""

from rich.console import Console


def plain_console() -> Console:
    """Return a console on stdout that prints names as they are: ``[b]`` in a solid's name is no markup."""
    return Console(markup=False, emoji=False)
