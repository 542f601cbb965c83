"""The frames between a command and the kernel's process: each is a packet of plain data with its length before it."""

from __future__ import annotations

import socket
import struct
from collections.abc import Iterator
from typing import Any, Protocol

from cad.work.plain_data import pack, unpack
from cad.work.plain_types import PlainDataError

LAST_FRAMES = ("result", "error", "fault", "no memory")
"""Kinds of frames after which none follows: what the function returned or raised, a defect, or no memory left."""
_LENGTH = struct.Struct("<Q")


class Reads(Protocol):
    """What packets are read from: a pipe, or one end of a pair of sockets."""

    def read(self, size: int, /) -> bytes:
        """Return this many bytes; fewer at the end of the stream."""


class Writes(Protocol):
    """What packets are written to."""

    def write(self, data: bytes, /) -> object:
        """Write all bytes."""

    def flush(self) -> None:
        """Send what is still held back."""


def write_packet(pipe: Writes, packet: bytes) -> None:
    """Write a packet with its length before it."""
    pipe.write(_LENGTH.pack(len(packet)) + packet)
    pipe.flush()


def write_frame(pipe: Writes, kind: str, value: object) -> None:
    """Write a frame: its kind, and a value of plain data."""
    write_packet(pipe, pack((kind, value)))


def read_packet(pipe: Reads) -> bytes | None:
    """Read a packet; None if the stream ends before it does."""
    head = pipe.read(_LENGTH.size)
    if len(head) < _LENGTH.size:
        return None
    (length,) = _LENGTH.unpack(head)
    packet = pipe.read(length)
    return packet if len(packet) == length else None


def read_frames(pipe: Reads | None) -> Iterator[tuple[str, Any]]:
    """Yield kinds and values until the stream ends. An incomplete frame is ignored.

    Raises `PlainDataError` when a frame cannot be read.
    """
    while pipe is not None and (packet := read_packet(pipe)) is not None:
        frame = unpack(packet)
        if not (isinstance(frame, tuple) and len(frame) == 2 and isinstance(frame[0], str)):
            raise PlainDataError("a frame without a kind")
        yield frame[0], frame[1]


class Channel:
    """One end of a pair of sockets as a stream of bytes; it reads no byte ahead."""

    def __init__(self, end: socket.socket) -> None:
        self._end = end

    def fileno(self) -> int:
        """Return the descriptor, for `select`."""
        return self._end.fileno()

    def read(self, size: int) -> bytes:
        """Return this many bytes; fewer only if the other side closed its end."""
        parts, missing = [], size
        while missing:
            try:
                part = self._end.recv(missing)
            except ConnectionResetError:
                break
            if not part:
                break
            parts.append(part)
            missing -= len(part)
        return b"".join(parts)

    def write(self, data: bytes) -> None:
        """Send bytes. Raises `OSError` when the other side closed its end."""
        self._end.sendall(data)

    def flush(self) -> None:
        """Do nothing: nothing waits here."""

    def close(self) -> None:
        """Close this end."""
        self._end.close()
