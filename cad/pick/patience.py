"""Connections that send half of a request, or send it drop by drop, are closed."""

from __future__ import annotations

import asyncio
from typing import Any

from uvicorn.protocols.http.h11_impl import H11Protocol

SECONDS_FOR_A_REQUEST = 20.0
"""From the first byte, or from the last answer, to the end of a request. 8 MB over a wireless network of 5 Mbit/s take
13 s."""


class ImpatientProtocol(H11Protocol):
    """HTTP/1.1 that waits `SECONDS_FOR_A_REQUEST` for a whole request, however slowly it comes."""

    _limit: asyncio.TimerHandle | None = None

    def connection_made(self, transport: Any) -> None:
        """Start to wait for the first request."""
        super().connection_made(transport)
        self._wait()

    def on_response_complete(self) -> None:
        """Start to wait for the next request."""
        super().on_response_complete()
        self._wait()

    def connection_lost(self, exc: Exception | None) -> None:
        """Stop waiting."""
        self._stop()
        super().connection_lost(exc)

    def _wait(self) -> None:
        self._stop()
        self._limit = self.loop.call_later(SECONDS_FOR_A_REQUEST, self._end)

    def _stop(self) -> None:
        if self._limit is not None:
            self._limit.cancel()
            self._limit = None

    def _end(self) -> None:
        """Close the connection, unless its request came completely and is being answered."""
        is_answering = self.cycle is not None and not self.cycle.response_complete and not self.cycle.more_body
        if not is_answering:
            self.transport.close()
