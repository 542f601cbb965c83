"""A client of `wpcal rpc` for tests: it checks every line against its schema, and can see the worker's process."""

import itertools
import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import jsonschema

from cad.rpc.protocol import ANSWER, schema_of
from tests.running import children_of

GONE_S = 2.0  #: So long after its client, no process of wpcal is left.


class RpcClient:
    """One `wpcal rpc`."""

    def __init__(self, cwd: Path | None = None, environment: dict[str, str] | None = None) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", "wpcal", "rpc"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            cwd=cwd,
            env={**os.environ, **(environment or {})},
        )
        self._ids = itertools.count(1)
        self._answer = jsonschema.Draft202012Validator(schema_of(ANSWER))
        self.progress: list[dict[str, Any]] = []
        """Of the last answer."""

    def write(self, line: bytes) -> None:
        """Send a line as it is."""
        self.process.stdin.write(line + b"\n")
        self.process.stdin.flush()

    def send(self, method: str, /, **params: Any) -> int:
        """Send a request and return its id."""
        number = next(self._ids)
        self.write(json.dumps({"id": number, "method": method, "params": params}).encode())
        return number

    def hear(self) -> dict[str, Any]:
        """Return the next line, which must follow its schema."""
        line = self.process.stdout.readline()
        assert line, self.process.communicate()[1].decode()
        message: dict[str, Any] = json.loads(line)
        self._answer.validate(message)
        return message

    def answer(self) -> dict[str, Any]:
        """Return the next line that answers a request."""
        self.progress = []
        while "progress" in (message := self.hear()):
            self.progress.append(message["progress"])
        return message

    def ask(self, method: str, /, **params: Any) -> dict[str, Any]:
        """Return the result of a request, which must follow the schema of its method."""
        schema = schema_of(method)["properties"]
        jsonschema.validate(params, schema["params"])
        number = self.send(method, **params)
        answer = self.answer()
        assert answer["id"] == number
        assert "result" in answer, answer
        jsonschema.validate(answer["result"], schema["result"])
        found: dict[str, Any] = answer["result"]
        return found

    def refused(self, method: str, /, **params: Any) -> dict[str, Any]:
        """Return the error of a request."""
        number = self.send(method, **params)
        answer = self.answer()
        assert answer["id"] == number
        assert "error" in answer, answer
        error: dict[str, Any] = answer["error"]
        assert "\n" not in error["message"]
        return error

    def worker(self) -> int:
        """Return the process number of the worker."""
        [worker] = children_of(self.process.pid)
        return worker

    def close(self) -> int:
        """Close standard input and wait for the end."""
        self.process.stdin.close()
        code = self.process.wait(GONE_S + 3.0)
        self.process.stdout.close()
        self.process.stderr.close()
        return code
