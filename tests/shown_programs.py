"""The programs that the how-to pages show, and those to which they link; `docs/make_controller_files.py` writes both.

A page gives the command and the file in a comment. Below it is the file as a block, or a link to it.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

PAGES = Path(__file__).parents[1] / "docs" / "how-to"
SHOWN = re.compile(
    r"^<!-- wpcal (?P<command>(?:export|plan) [^\n]*): (?P<file>\S+) -->\n+"
    r"(?:```text\n(?P<text>.*?)^```$|\[[^\]]*\]\((?P<link>[^)]+)\))",
    re.MULTILINE | re.DOTALL,
)


@dataclass(frozen=True, slots=True)
class ShownProgram:
    """One file of one page."""

    page: str
    command: str  #: The words after `wpcal`.
    file: str
    text: str  #: With LF at the ends of lines.

    @property
    def raw(self) -> bytes:
        """The file as a controller gets it."""
        return self.text.encode("latin-1", "replace")


def shown_programs(page: str = "*.md") -> Iterator[ShownProgram]:
    """Yield the programs of the pages that fit a pattern, in their order."""
    for path in sorted(PAGES.glob(page)):
        for found in SHOWN.finditer(path.read_text(encoding="utf-8")):
            text = found["text"] or (PAGES / found["link"]).read_text(encoding="utf-8")
            yield ShownProgram(path.name, found["command"], found["file"], text)
