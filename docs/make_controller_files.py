"""Write the programs to which the how-to pages link: the files that are in the folder which a page names.

A comment on a page gives the command and the folder in docs/examples/programs:

    <!-- wpcal export fixtures/tee/golden -f krl --tool-number 3: kuka-1 -->

A new file is an empty one before the first run. Excerpts on the pages are copied by hand; a test compares them.

Usage: python docs/make_controller_files.py (`make fixtures` runs it, too).
"""

from __future__ import annotations

import contextlib
import io
import re
import shlex
import sys
import tempfile
from functools import cache
from pathlib import Path

from wpcal.cli.main import wpcal

ROOT = Path(__file__).parents[1]
PAGES = ROOT / "docs" / "how-to"
PROGRAMS = ROOT / "docs" / "examples" / "programs"
SHOWN = re.compile(r"^<!-- wpcal (?P<command>(?:export|plan) .*): (?P<folder>\S+) -->$", re.MULTILINE)


@cache
def written(command: str) -> dict[str, str]:
    """Run the command in the repository and return its files by name, with LF at the ends of lines."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(ROOT), contextlib.redirect_stdout(io.StringIO()):
        out = Path(folder) / "out"
        wpcal.main(args=[*shlex.split(command), "-o", str(out)], prog_name="wpcal", standalone_mode=False)
        files = [path for path in out.rglob("*") if path.is_file() and path.suffix not in (".html", ".glb")]
        return {path.name: path.read_bytes().decode("utf-8").replace("\r\n", "\n") for path in files}


def main() -> None:
    for page in sorted(PAGES.glob("*.md")):
        for found in SHOWN.finditer(page.read_text(encoding="utf-8")):
            for file in sorted((PROGRAMS / found["folder"]).iterdir()):
                file.write_text(written(found["command"])[file.name].rstrip() + "\n", encoding="utf-8")
            sys.stderr.write(f"{page.name}: {found['folder']}\n")


if __name__ == "__main__":
    main()
