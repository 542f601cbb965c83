# SPDX-License-Identifier: MIT
"""Build the workbench: `python -m cad.freecad.build dist/wpcal-workbench.zip`.

The ZIP file holds one folder, `WpCal`, which is dropped into FreeCAD's `Mod` folder. A name without `.zip` is a folder:
the tree that is pushed to the workbench's own repository, from which the Addon Manager takes it. The Addon Manager asks
for the address of that repository and for a maintainer who answers:

    python -m cad.freecad.build dist/addon https://HOST/OWNER/REPOSITORY "Name <name@host>"
"""

from __future__ import annotations

import re
import sys
import zipfile
from pathlib import Path
from xml.sax.saxutils import escape, quoteattr

from cad.freecad.texts import translation_file

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
FOLDER = "WpCal"
LEFT_OUT = {"__pycache__", ".ruff_cache", "build.py", "texts.py", "ruff.toml"}
TRANSLATIONS = "freecad/wpcal_wb/resources/translations/WpCal.ts"
MOMENT = (2020, 1, 1, 0, 0, 0)  #: The time of every file in the ZIP file: the same sources give the same bytes.


def addon_files(repository: str = "", maintainer: str = "") -> dict[str, bytes]:
    """Return the content of the addon by path inside its folder.

    `repository`: Address of the workbench's own repository, https.
    `maintainer`: As ``Name <name@host>``.
    """
    files = {
        path.relative_to(HERE).as_posix(): path.read_bytes()
        for path in sorted(HERE.rglob("*"))
        if path.is_file() and not LEFT_OUT & set(path.relative_to(HERE).parts)
    }
    files[TRANSLATIONS] = translation_file(HERE / "freecad").encode("utf-8")
    files["LICENSE"] = (ROOT / "LICENSE").read_bytes()
    package = re.sub(r"<version>[^<]*", f"<version>{wpcal_version()}", files["package.xml"].decode("utf-8"), count=1)
    if repository:
        package = _published(package, repository, maintainer)
    files["package.xml"] = package.encode("utf-8")
    return files


def _published(package: str, repository: str, maintainer: str) -> str:
    """Return package.xml with what the Addon Manager asks for."""
    who = re.fullmatch(r"\s*([^<>]+?)\s*<([^<>@\s]+@[^<>@\s]+)>\s*", maintainer)
    if who is None or not repository.startswith("https://"):
        raise ValueError(f"expected https://… and 'Name <name@host>', got {repository!r} and {maintainer!r}")
    places = {"repository": "", "readme": "/blob/main/README.md", "bugtracker": "/issues"}
    urls = [f"  <url type={quoteattr(kind)}>{escape(repository + end)}</url>\n" for kind, end in places.items()]
    urls[0] = urls[0].replace("<url ", '<url branch="main" ')
    line = f"<maintainer email={quoteattr(who[2])}>{escape(who[1])}</maintainer>"
    package = re.sub(r"<maintainer[^>]*>[^<]*</maintainer>", lambda _: line, package, count=1)
    return package.replace("  <icon>", f"{''.join(urls)}  <icon>", 1)


def wpcal_version() -> str:
    """Return the version of this project, which is also that of the workbench."""
    text = (ROOT / "wpcal/core/version.py").read_text(encoding="utf-8")
    found = re.search(r'^__version__ = "([^"]+)"', text, re.MULTILINE)
    if found is None:
        raise ValueError("wpcal/core/version.py has no line __version__ = …")
    return found[1]


def build(target: Path, repository: str = "", maintainer: str = "") -> None:
    """Write the ZIP file, or the folder."""
    files = addon_files(repository, maintainer)
    if target.suffix != ".zip":
        for name, content in files.items():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            (target / name).write_bytes(content)
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, content in sorted(files.items()):
            archive.writestr(zipfile.ZipInfo(f"{FOLDER}/{name}", MOMENT), content, zipfile.ZIP_DEFLATED)


if __name__ == "__main__":
    build(Path(sys.argv[1]), *sys.argv[2:])
