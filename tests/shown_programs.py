"""The programs to which the how-to pages link: a comment on the page gives command and folder."""

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

PAGES = Path(__file__).parents[1] / "docs" / "how-to"
PROGRAMS = PAGES.parent / "examples" / "programs"
SHOWN = re.compile(r"^<!-- wpcal (?P<command>(?:export|plan) .*): (?P<folder>\S+) -->$", re.MULTILINE)
EXCERPT = re.compile(r"^```text\n(.*?)^```$", re.MULTILINE | re.DOTALL)


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
            for file in sorted((PROGRAMS / found["folder"]).iterdir()):
                yield ShownProgram(path.name, found["command"], file.name, file.read_text(encoding="utf-8"))


def lines_shown(page: str) -> set[str]:
    """Return the lines of the excerpts on a page."""
    blocks = EXCERPT.findall((PAGES / page).read_text(encoding="utf-8"))
    return {line for block in blocks for line in block.splitlines()} - {"…"}
