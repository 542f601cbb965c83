"""Write the whole files of the T-joint into docs/how-to: each block of a page, and each file to which it links.

The line above a block or a link gives the options of the command and the file:

    <!-- wpcal export fixtures/tee/golden -f krl --tool-number 3: WPCAL.src -->

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
SHOWN = re.compile(
    r"^<!-- wpcal (?P<command>(?:export|plan) [^\n]*): (?P<file>\S+) -->\n+"
    r"(?:```text\n(?P<text>.*?)^```$|\[[^\]]*\]\((?P<link>[^)]+)\))",
    re.MULTILINE | re.DOTALL,
)


@cache
def written(command: str) -> dict[str, str]:
    """Run the command in the repository and return its files by name, with LF at the ends of lines."""
    with tempfile.TemporaryDirectory() as folder, contextlib.chdir(ROOT), contextlib.redirect_stdout(io.StringIO()):
        out = Path(folder) / "out"
        wpcal.main(args=[*shlex.split(command), "-o", str(out)], prog_name="wpcal", standalone_mode=False)
        files = [path for path in out.rglob("*") if path.is_file() and path.suffix not in (".html", ".glb")]
        return {path.name: path.read_bytes().decode("utf-8").replace("\r\n", "\n") for path in files}


def renewed(page: str) -> str:
    """Return a page with all its blocks written anew."""

    def block(match: re.Match[str]) -> str:
        command, file = match["command"], match["file"]
        if match["link"]:
            (PAGES / match["link"]).write_text(written(command)[file].rstrip() + "\n", encoding="utf-8")
            return match[0]
        return f"<!-- wpcal {command}: {file} -->\n\n```text\n{written(command)[file].rstrip()}\n```"

    return SHOWN.sub(block, page)


def main() -> None:
    for path in sorted(PAGES.glob("*.md")):
        page = path.read_text(encoding="utf-8")
        if SHOWN.search(page):
            path.write_text(renewed(page), encoding="utf-8")
            sys.stderr.write(f"{path.name}\n")


if __name__ == "__main__":
    main()
