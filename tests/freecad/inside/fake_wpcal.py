"""A process that speaks the protocol of `wpcal rpc` and does what the tests of the client need."""

import json
import os
import sys
import time


def answer(**fields: object) -> None:
    """Write one line."""
    sys.stdout.write(json.dumps(fields) + "\n")
    sys.stdout.flush()


def main() -> None:
    """Answer until the input ends."""
    protocol = int(os.environ.get("FAKE_PROTOCOL", "1"))
    waiting = None
    for line in sys.stdin:
        request = json.loads(line)
        number, method, params = request["id"], request["method"], request["params"]
        if method == "hello":
            answer(id=number, result={"wpcal": "0.0", "protocol": protocol, "methods": []})
        elif method == "echo":
            answer(id=number, progress={"text": "half", "done": 1, "of": 2})
            answer(id=number, result=params)
        elif method == "environment":
            answer(id=number, result=dict(os.environ))
        elif method == "refuse":
            answer(id=number, error={"kind": "InputError", "message": "not so", "hint": "but so"})
        elif method == "noise":
            sys.stdout.write("no JSON\n[]\n")
            answer(id=number, result=True)
        elif method == "wait":
            waiting = number
        elif method == "cancel":
            answer(id=waiting, error={"kind": "Cancelled", "message": "cancelled"})
            answer(id=number, result={"cancelled": True})
        elif method == "crash":
            sys.stderr.write("the last words\n")
            sys.stderr.flush()
            os._exit(3)
        elif method == "slow":
            time.sleep(0.2)
            answer(id=number, result=None)


main()
