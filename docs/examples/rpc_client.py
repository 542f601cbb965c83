"""A client of `wpcal rpc`: fit a part to a table of touched points, and save the result."""

import itertools
import json
import subprocess
import sys
from typing import Any

PIPES = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "encoding": "utf-8", "bufsize": 1}


class Wpcal:
    """One process of wpcal for the whole session."""

    def __init__(self, command: str = "wpcal") -> None:
        self.process = subprocess.Popen([command, "rpc"], **PIPES)
        self.ids = itertools.count(1)

    def ask(self, method: str, /, **params: Any) -> dict[str, Any]:
        """Send a request and wait for its answer."""
        print(json.dumps({"id": next(self.ids), "method": method, "params": params}), file=self.process.stdin)
        for line in self.process.stdout:
            answer = json.loads(line)
            if "progress" in answer:
                print(answer["progress"]["text"], file=sys.stderr)
            elif "error" in answer:
                raise RuntimeError(f"{answer['error']['kind']}: {answer['error']['message']}")
            else:
                return answer["result"]
        raise RuntimeError("wpcal ended")


if __name__ == "__main__":
    (step, table, out), session = sys.argv[1:], Wpcal()
    print("wpcal", session.ask("hello")["wpcal"])
    part = session.ask("open", path=step)["handle"]
    taught = {"path": table}
    print(session.ask("calibrate", handle=part, taught=taught)["record"]["verdict"])
    print(*session.ask("save", handle=part, taught=taught, out=out)["files"])
    session.ask("shutdown")
