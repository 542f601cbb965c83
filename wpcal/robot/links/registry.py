"""The kinds of links that are installed: entry points ``wpcal.links``, each a function that opens one."""

from __future__ import annotations

from collections.abc import Callable
from importlib.metadata import EntryPoint

from wpcal.core.installed import installed
from wpcal.robot.links.reading import Address, Credentials, LinkError, RobotLink, credentials_of_environment

LINKS = "wpcal.links"  #: The entry-point group.
OpenLink = Callable[[Address, Credentials], RobotLink]


def installed_links() -> dict[str, EntryPoint]:
    """Return the kinds of links by name."""
    return {point.name: point for point in sorted(installed(LINKS), key=lambda point: point.name)}


def kind_of(text: str) -> str | None:
    """Return the kind of ``KIND:ADDRESS``; None if a text is nothing of that form."""
    kind, colon, rest = text.partition(":")
    return kind if colon and rest and kind in installed_links() else None


def link_opener(
    text: str, credentials: Credentials = credentials_of_environment
) -> tuple[Address, Callable[[], RobotLink]]:
    """Return the address and what opens the link of ``KIND:ADDRESS``.

    Raises `LinkError` when it is not of that form, or the kind cannot be loaded.
    """
    kind, _, rest = text.partition(":")
    if kind not in installed_links():
        raise LinkError(f"{text!r}: expected KIND:ADDRESS with KIND one of {', '.join(installed_links())}")
    address = Address.parse(rest)
    try:
        opened: OpenLink = installed_links()[kind].load()
    except (ImportError, AttributeError) as error:
        raise LinkError(f"{kind}: cannot be loaded: {error}") from None
    return address, lambda: opened(address, credentials)
