"""Jobs of an earlier export in the same folder: without care they are copied to the controller, too."""

from __future__ import annotations

import re
from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from wpcal.controllers.language.grammar import ENCODING
from wpcal.controllers.registry import grammar_of_file
from wpcal.core.input_file import read_bytes

OURS = re.compile(r"written by wpcal\b")
MOST_BYTES = 10_000_000  #: Of a program that calls others; a larger file is not looked into.


@dataclass(frozen=True, slots=True)
class EarlierJobs:
    """Files of a folder that a new export does not write."""

    #: Jobs that the program of an earlier export calls: it is replaced, and nothing calls them any more.
    ours: tuple[str, ...]
    others: tuple[str, ...]  #: Other files of the same kinds. Whose they are is not known.


def find_earlier_jobs(folder: Path, written: Collection[str]) -> EarlierJobs:
    """Find the files of an earlier export."""
    if not folder.is_dir():
        return EarlierJobs((), ())
    suffixes = {Path(name).suffix.lower() for name in written}
    there = {path.name for path in folder.iterdir() if path.is_file() and not path.is_symlink()}
    kept = {name for name in there.difference(written) if Path(name).suffix.lower() in suffixes}
    called = {name for one in there.intersection(written) for name in _called_by(folder / one)}
    return EarlierJobs(tuple(sorted(kept & called)), tuple(sorted(kept - called)))


def _called_by(path: Path) -> set[str]:
    """Return the files of the jobs that a program of an earlier export calls."""
    grammar = grammar_of_file(path)
    if grammar is None or not grammar.calls or path.stat().st_size > MOST_BYTES:
        return set()
    text = read_bytes(path).decode(ENCODING)
    calls = re.finditer(grammar.calls, text, re.MULTILINE) if OURS.search(text) else ()
    return {f"{match['name']}{path.suffix}" for match in calls}
