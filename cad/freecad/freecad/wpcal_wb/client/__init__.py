# SPDX-License-Identifier: MIT
"""The child process `wpcal rpc` and the requests to it."""

from .executable import (
    Executable,
    command_of,
    find_executable,
    found_executables,
    how_to_install,
    preferred,
    set_preferred,
)
from .failure import Failure
from .process import Client, Request

__all__ = [
    "Client",
    "Executable",
    "Failure",
    "Request",
    "command_of",
    "find_executable",
    "found_executables",
    "how_to_install",
    "preferred",
    "set_preferred",
]
