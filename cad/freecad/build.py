# SPDX-License-Identifier: MIT
"""Build the workbench: `python -m cad.freecad.build dist/wpcal-workbench.zip`.

The ZIP file holds one folder, `WpCal`, which is dropped into FreeCAD's `Mod` folder.
"""

from __future__ import annotations

import re
import sys
import zipfile
from pathlib import Path

from cad.freecad.texts import translation_file

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
FOLDER = "WpCal"
LEFT_OUT = {"__pycache__", ".ruff_cache", "build.py", "texts.py", "ruff.toml"}
TRANSLATIONS = "freecad/wpcal_wb/resources/translations/WpCal.ts"
MOMENT = (2020, 1, 1, 0, 0, 0)  #: The time of every file in the ZIP file: the same sources give the same bytes.


def addon_files() -> dict[str, bytes]:
    """Return the content of the addon by path inside its folder."""
    files = {
        path.relative_to(HERE).as_posix(): path.read_bytes()
        for path in sorted(HERE.rglob("*"))
        if path.is_file() and not LEFT_OUT & set(path.relative_to(HERE).parts)
    }
    files[TRANSLATIONS] = translation_file(HERE / "freecad").encode("utf-8")
    files["LICENSE"] = (ROOT / "LICENSE").read_bytes()
    package = files["package.xml"].decode("utf-8")
    files["package.xml"] = re.sub(r"<version>[^<]*", f"<version>{wpcal_version()}", package, count=1).encode("utf-8")
    return files


def wpcal_version() -> str:
    """Return the version of this project, which is also that of the workbench."""
    text = (ROOT / "wpcal/core/version.py").read_text(encoding="utf-8")
    found = re.search(r'^__version__ = "([^"]+)"', text, re.MULTILINE)
    if found is None:
        raise ValueError("wpcal/core/version.py has no line __version__ = …")
    return found[1]


def build(target: Path) -> None:
    """Write the ZIP file."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in sorted(addon_files().items()):
            archive.writestr(zipfile.ZipInfo(f"{FOLDER}/{name}", MOMENT), content, zipfile.ZIP_DEFLATED)


if __name__ == "__main__":
    build(Path(sys.argv[1]))
