"""The front process."""

from __future__ import annotations

import os

from cad.rpc.client_lines import LongLine, read_lines
from cad.rpc.messages import PROTOCOL, MessageFaultError, error_line, read_request, result_line
from wpcal import __version__


class Front:
    """Answers a client."""

    def run(self) -> int:
        """Answer until the client closes standard input."""
        for line in read_lines(0):
            if isinstance(line, LongLine):
                continue
            try:
                request = read_request(line)
            except MessageFaultError as fault:
                os.write(1, error_line(fault.id, fault.kind, str(fault)))
                continue
            if request.method == "hello":
                answer = {"wpcal": __version__, "protocol": PROTOCOL, "methods": ["hello", "shutdown"]}
                os.write(1, result_line(request.id, answer))
            elif request.method == "shutdown":
                os.write(1, result_line(request.id, {}))
                return 0
            else:
                os.write(1, error_line(request.id, "UnknownMethod", f"{request.method}: no such method"))
        return 0
