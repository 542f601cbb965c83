# SPDX-License-Identifier: MIT
"""Which `wpcal` is started: the one of the preferences, else the first that is found."""

from __future__ import annotations

import os
import shlex
import shutil
from pathlib import Path
from typing import Iterator, NamedTuple

import FreeCAD

from .. import PREFERENCES
from ..words import translate

PREFERENCE = "Executable"  #: The name of the preference: a path, or a command line such as `python3 -m wpcal`.
NAME = "wpcal.exe" if os.name == "nt" else "wpcal"
FOLDER = "Scripts" if os.name == "nt" else "bin"


class Executable(NamedTuple):
    """A command that may be wpcal."""

    command: tuple[str, ...]  #: The program and its first arguments.
    origin: str  #: Where it was found, for the user.


def preferred() -> str:
    """Return what the preferences say; empty if they say nothing."""
    return str(FreeCAD.ParamGet(PREFERENCES).GetString(PREFERENCE, "")).strip()


def set_preferred(text: str) -> None:
    """Write the preference."""
    FreeCAD.ParamGet(PREFERENCES).SetString(PREFERENCE, text.strip())


def find_executable() -> Executable | None:
    """Return the command of the preferences, else the first `wpcal` that is found; None without any.

    A command of the preferences is returned even if it does not exist: the user shall see that it is wrong.
    """
    text = preferred()
    if text:
        return Executable(command_of(text), translate("preferences"))
    return next(found_executables(), None)


def found_executables() -> Iterator[Executable]:
    """Yield every `wpcal` on PATH, in the usual environments of Python, pipx and uv."""
    seen = set()
    on_path = shutil.which("wpcal")
    places = [(Path(on_path), "PATH")] if on_path else []
    places += [(folder / NAME, str(folder)) for folder in _usual_folders()]
    for path, origin in places:
        if path.is_file() and os.access(str(path), os.X_OK) and path.resolve() not in seen:
            seen.add(path.resolve())
            yield Executable((str(path),), origin)


def how_to_install() -> str:
    """Return what to do when there is no wpcal."""
    return translate(
        "wpcal was not found. Install it outside FreeCAD, with Python 3.11 or later, in a folder with its source:\n"
        "    pipx install .\n"
        "or in an environment of its own:\n"
        "    python3 -m venv ~/wpcal && ~/wpcal/bin/pip install .\n"
        "Then name the executable in Edit > Preferences > wpcal, or press Find there."
    )


def command_of(text: str) -> tuple[str, ...]:
    """Split a preference into program and arguments; a path with spaces that exists is one program."""
    if Path(text).expanduser().exists():
        return (str(Path(text).expanduser()),)
    try:
        words = shlex.split(text, posix=os.name != "nt")
    except ValueError:  # a quote that is not closed
        words = [text]
    return tuple(os.path.expanduser(word) for word in words)


def _usual_folders() -> Iterator[Path]:
    home = Path.home()
    yield home / ".local" / "bin"  # pipx, uv, pip --user
    for environment in ("wpcal", ".wpcal", ".venv", "venv"):
        yield home / environment / FOLDER
    if os.environ.get("VIRTUAL_ENV"):
        yield Path(os.environ["VIRTUAL_ENV"]) / FOLDER
    for folder in ("/usr/local/bin", "/opt/homebrew/bin", "/opt/wpcal/bin"):
        yield Path(folder)
