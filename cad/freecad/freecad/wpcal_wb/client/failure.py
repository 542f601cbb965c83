# SPDX-License-Identifier: MIT
"""Why a request has no result."""

from __future__ import annotations

from types import MappingProxyType
from typing import Any, Mapping, NamedTuple


class Failure(NamedTuple):
    """The reason, as wpcal gave it or as the client found it."""

    #: As in the protocol (`InputError`, `Cancelled` and others), or of the client: `missing` (there is nothing to
    #: start), `version` (another protocol), `stopped` (the process ended before it answered).
    kind: str
    message: str  #: One line for the user.
    data: Mapping[str, Any] = MappingProxyType({})  #: The other fields of the answer: code, hint, row, column.

    @property
    def is_cancelled(self) -> bool:
        """Whether the user wanted it so."""
        return self.kind == "Cancelled"

    @property
    def text(self) -> str:
        """The message, and what to do if wpcal says so."""
        hint = self.data.get("hint")
        return f"{self.message}\n{hint}" if hint else self.message
