"""Write the whole files of the T-joint into docs/how-to: each block of a page is what `wpcal export` writes.

The line above a block gives the options of the command and the file:

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
from pathlib import Path

from wpcal.cli.main import wpcal

ROOT = Path(__file__).parents[1]
PAGES = ROOT / "docs" / "how-to"
BLOCK = re.compile(
    r"^<!-- wpcal export (?P<folder>\S+) (?P<options>[^\n]*): (?P<file>\S+) -->\n+```text\n(?P<text>.*?)^```$",
    re.MULTILINE | re.DOTALL,
)


def exported(folder: str, options: str, file: str) -> str:
    """Run the command and return one of its files, with LF at the ends of lines."""
    with tempfile.TemporaryDirectory() as out:
        arguments = ["export", str(ROOT / folder), *shlex.split(options), "-o", out]
        with contextlib.redirect_stdout(io.StringIO()):
            wpcal.main(args=arguments, prog_name="wpcal", standalone_mode=False)
        (path,) = Path(out).rglob(file)
        return path.read_bytes().decode("utf-8").replace("\r\n", "\n")


def renewed(page: str) -> str:
    """Return a page with all its blocks written anew."""

    def block(match: re.Match[str]) -> str:
        folder, options, file = match["folder"], match["options"], match["file"]
        text = exported(folder, options, file)
        return f"<!-- wpcal export {folder} {options}: {file} -->\n\n```text\n{text.rstrip()}\n```"

    return BLOCK.sub(block, page)


def main() -> None:
    for path in sorted(PAGES.glob("*.md")):
        page = path.read_text(encoding="utf-8")
        if BLOCK.search(page):
            path.write_text(renewed(page), encoding="utf-8")
            sys.stderr.write(f"{path.name}\n")


if __name__ == "__main__":
    main()
