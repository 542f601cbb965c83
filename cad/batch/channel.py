"""A socket as the stream of bytes that `cad.kernel.frames` reads and writes; it reads no byte ahead."""

from __future__ import annotations

import socket


class Channel:
    """One end of a pair of sockets.

    Parameters
    ----------
    end : socket
        Of the type ``SOCK_STREAM``.
    """

    def __init__(self, end: socket.socket) -> None:
        self._end = end

    def fileno(self) -> int:
        """Return the descriptor, for `select`."""
        return self._end.fileno()

    def read(self, size: int) -> bytes:
        """Return so many bytes; fewer only if the other side closed its end."""
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
        """Send bytes.

        Raises
        ------
        OSError
            When the other side closed its end.
        """
        self._end.sendall(data)

    def flush(self) -> None:
        """Do nothing: nothing waits here."""

    def close(self) -> None:
        """Close this end."""
        self._end.close()
