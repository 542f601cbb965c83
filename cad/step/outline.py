"""The text of a STEP file with one face of every shell: enough to see where the kernel places each solid.

A file that was moved by appending to its text holds the same bytes for all geometry. What has to be read again is what
the kernel makes of the new entities. In an outline, every shell is cut to its first face, and what only the other faces
need is left out. Everything else stays: products, placements, names, colours, layers and annotations.
"""

import re

import numpy as np

from cad.step.part21 import Part21File, reference_numbers
from wpcal.brep.strips import items_of
from wpcal.core.arrays import BoolArray, IntArray

_SHELL = re.compile(
    rb"#[0-9]+\s*=\s*(?:CLOSED|OPEN)_SHELL\s*\(\s*(?:'(?:[^']|'')*'|\$)\s*,\s*\(\s*#[0-9]+(?=\s*[,)])", re.IGNORECASE
)
"""A shell up to its first face."""


def outline(file: Part21File) -> bytes:
    """Return the text of a file with one face of every shell.

    Raises `FormatError` when a reference has too many digits.
    """
    order = np.argsort(file.starts, kind="stable")
    starts, ends, ids = file.starts[order], file.ends[order], file.ids[order]
    heads = _shells(file, starts, ends)
    place, number = reference_numbers(file)
    owner = np.searchsorted(starts, place, side="right") - 1
    by_id = np.searchsorted(file.ids, number)
    known = (owner >= 0) & (place > starts[owner]) & (place < ends[owner])
    known &= file.ids[np.minimum(by_id, len(ids) - 1)] == number
    place, owner, to = place[known], owner[known], order.argsort()[by_id[known]]
    is_top = np.ones(len(ids), dtype=bool)
    is_top[to] = False
    until = ends.copy()
    until[list(heads)] = list(heads.values())
    used = place < until[owner]
    kept = _needed(is_top, owner[used], to[used])
    clean, newline = file.clean, file.newline
    lines = [
        clean[starts[row] : heads[row]] + b"));" if row in heads else clean[starts[row] : ends[row] + 1]
        for row in np.flatnonzero(kept).tolist()
    ]
    begin = int(starts[0]) if len(starts) else file.data_end
    return clean[:begin] + newline.join(lines) + newline + clean[file.data_end :]


def _shells(file: Part21File, starts: IntArray, ends: IntArray) -> dict[int, int]:
    """Return the rows of the shells, and where their first face ends in the text."""
    found = {}
    for match in _SHELL.finditer(file.clean):
        row = int(np.searchsorted(starts, match.start(), side="right")) - 1
        if row >= 0 and starts[row] == match.start() and match.end() < ends[row]:
            found[row] = match.end()
    return found


def _needed(is_top: BoolArray, owner: IntArray, to: IntArray) -> BoolArray:
    """Return which of n rows are reached from those at the top, shape (n,), by references from `owner` to `to`."""
    sort = np.argsort(owner, kind="stable")
    start, to = np.searchsorted(owner[sort], np.arange(len(is_top) + 1)), to[sort]
    needed, fresh = is_top.copy(), np.flatnonzero(is_top)
    while len(fresh):
        reached = np.unique(to[items_of(start, fresh)[1]])
        fresh = reached[~needed[reached]]
        needed[fresh] = True
    return needed
