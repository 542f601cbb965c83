# SPDX-License-Identifier: MIT
"""The child process `wpcal rpc` and the requests to it."""

from .executable import Executable, find_executable, how_to_install
from .failure import Failure
from .process import Client, Request

__all__ = ["Client", "Executable", "Failure", "Request", "find_executable", "how_to_install"]
