"""The tool centre point that a program of a controller states."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from wpcal.controllers.language.grammar import ENCODING
from wpcal.controllers.registry import grammars
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import read_bytes
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import listed

MOST_TOOL_MM = 10_000.0  #: No torch is 10 m from its flange: such a number is a typing error, or in another unit.


def read_tool_data(path: Path, name: str | None = None) -> RigidTransform:
    """Read the tool centre point from a program. ``T_flange_tool``.

    Raises `InputError` when the file cannot be opened, has no tool, or `name` is not one of several.
    Raises `FormatError` when the numbers are not a pose.
    """
    text, known = read_bytes(path).decode(ENCODING), grammars()
    try:
        found = {name: tool for each in known if each.tools for name, tool in each.tools(text).items()}
    except InputError as error:
        raise FormatError(str(error), path=str(path)) from None
    if not found:
        *words, last = [each.tools_in_words for each in known if each.tools]
        raise InputError(f"{path}: no tool data: expected {', '.join(words)}, or {last}")
    wanted = "" if name is None else name.lower().replace(" ", "")
    for key, tool in found.items():
        is_only = name is None and len(found) == 1
        if is_only or wanted in (key.lower(), key.lower().rpartition("[")[2].removesuffix("]")):
            return _usable(tool, key, path)
    which = "several tools: name one" if name is None else f"no tool {name!r}"
    raise InputError(f"{path}: {which}; the file has {listed(found)}")


def _usable(tool: RigidTransform | str, name: str, path: Path) -> RigidTransform:
    if isinstance(tool, str):
        raise FormatError(f"{name}: {tool}", path=str(path))
    if np.abs(tool.t_mm).max() > MOST_TOOL_MM:
        raise FormatError(f"{name}: expected x, y, z of at most {MOST_TOOL_MM:g} mm", path=str(path))
    return tool
