"""Lines from a client: of limited length, as they come, until the client closes its end."""

from __future__ import annotations

import os
from collections.abc import Iterator

MOST_BYTES = 16_000_000  #: Of a line: ten thousand rows of taught points and as many decisions have 4 MB.
CHUNK_BYTES = 1 << 16


class LongLine:
    """Stands for a line that is longer than allowed; its bytes were not kept."""


LONG = LongLine()


def read_lines(descriptor: int, *, most: int = MOST_BYTES) -> Iterator[bytes | LongLine]:
    """Yield lines without their end. What follows the last end of a line is yielded, too."""
    parts, size = list[bytes](), 0
    while True:
        try:
            chunk = os.read(descriptor, CHUNK_BYTES)
        except OSError:  # the terminal of the client was closed
            chunk = b""
        *ended, rest = chunk.split(b"\n")
        for piece in ended:
            whole = b"".join([*parts, piece])
            yield LONG if size + len(piece) > most else whole
            parts, size = [], 0
        size += len(rest)
        if size <= most:
            parts.append(rest)
        else:
            parts = []
        if not chunk:
            break
    if size > most:
        yield LONG
    elif size:
        yield b"".join(parts)
