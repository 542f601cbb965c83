"""The font of a sheet: DejaVu Sans, from the system or from matplotlib."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

from wpcal.core.errors import InputError

FONT = "DejaVuSans.ttf"
"""It has the letters of all European languages and is on nearly every Linux system. matplotlib contains a copy."""


def require_font() -> None:
    """Make the font known to the drawing library.

    Raises `InputError` when it is not installed: the library would draw boxes instead of letters.
    """
    from ezdxf.fonts import fonts

    if fonts.font_manager.has_font(FONT):
        return
    found = find_spec("matplotlib")
    if found is not None and found.origin is not None:
        fonts.font_manager.scan_folder(Path(found.origin).parent / "mpl-data" / "fonts" / "ttf")
    if not fonts.font_manager.has_font(FONT):
        raise InputError(f"the font {FONT} is not installed: install it, or wpcal[plots], which carries it")
