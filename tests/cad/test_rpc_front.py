"""The front of `wpcal rpc` with a worker of the test: one answer to a cancel, and one to every request at the end."""

import json
import os
import threading
from collections.abc import Callable
from queue import SimpleQueue
from typing import Any

import pytest

from cad.rpc import front as front_module
from cad.rpc.front import Front
from cad.rpc.kinds import ANSWER, BEGUN, CANCELLED, FINAL
from cad.work.child import Limits

SOON_S = 20.0
PLAN = {"cell": "cell.json", "folder": "result", "out": "plan"}


class Worker:
    """A worker that says what the test lets it say."""

    number = 0

    def __init__(self, _: Limits, heard: Callable[[Any, bytes], None]) -> None:
        self.told: SimpleQueue[dict[str, Any]] = SimpleQueue()
        self._heard, self.was_killed = heard, False

    def send(self, message: dict[str, Any]) -> None:
        self.told.put(message)

    def say(self, kind: bytes, message: dict[str, Any] | None = None) -> None:
        self._heard(self, kind + json.dumps(message).encode() + b"\n")

    def kill(self) -> None:
        self.was_killed = True
        self._heard(self, b"")

    def end(self, *, step: str = "") -> str:
        return step or "ended"


class Session:
    """A front that runs in a thread, and the two ends of a client."""

    def __init__(self) -> None:
        requests, self._in = os.pipe()
        self._out, answers = os.pipe()
        front = Front(requests, answers, Limits())

        def run() -> None:
            front.run()
            os.close(answers)

        self.thread = threading.Thread(target=run, daemon=True)
        self.thread.start()
        self._answers = os.fdopen(self._out, "rb")

    def ask(self, number: int, method: str, **params: Any) -> None:
        os.write(self._in, json.dumps({"id": number, "method": method, "params": params}).encode() + b"\n")

    def hear(self) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(self._answers.readline())
        return found

    def end_input(self) -> None:
        os.close(self._in)

    def end(self) -> None:
        self.thread.join(SOON_S)
        assert not self.thread.is_alive()
        self._answers.close()

    def close(self) -> None:
        self.end_input()
        self.end()


@pytest.fixture
def workers(monkeypatch: pytest.MonkeyPatch) -> SimpleQueue[Worker]:
    """Return the workers that were started; a cancelled one is given little time."""
    made: SimpleQueue[Worker] = SimpleQueue()

    def start(*arguments: Any) -> Worker:
        made.put(worker := Worker(*arguments))
        return worker

    monkeypatch.setattr(front_module, "WorkerProcess", start)
    monkeypatch.setattr(front_module, "GRACE_S", 0.5)
    monkeypatch.setattr(front_module, "LAST_S", 0.2)
    monkeypatch.setattr(front_module, "WATCHDOG_S", 60.0)
    return made


def begun(workers: SimpleQueue[Worker]) -> tuple[Session, Worker]:
    session = Session()
    worker = workers.get(timeout=SOON_S)
    session.ask(1, "plan", **PLAN)
    assert worker.told.get(timeout=SOON_S)["id"] == 1
    worker.say(BEGUN)
    return session, worker


RESULT = {"id": 1, "result": {}}
REFUSED = {"id": 1, "error": {"kind": "Cancelled", "code": "Cancelled", "message": "", "hint": None}}


def test_a_request_that_stops_was_cancelled_and_keeps_its_worker(workers: SimpleQueue[Worker]) -> None:
    session, worker = begun(workers)
    session.ask(2, "cancel", id=1)
    session.ask(3, "cancel", id=1)
    session.ask(4, "hello")  # is answered at once, after both were read
    assert session.hear()["id"] == 4
    assert worker.told.get(timeout=SOON_S) == {"cancel": 1}
    worker.say(CANCELLED, REFUSED)
    assert session.hear() == REFUSED
    assert [session.hear() for _ in range(2)] == [{"id": number, "result": {"cancelled": True}} for number in (2, 3)]
    assert worker.told.empty()
    assert not worker.was_killed
    session.close()


@pytest.mark.parametrize("is_final_first", [True, False])
def test_a_request_that_puts_files_in_place_was_not_cancelled(
    workers: SimpleQueue[Worker], is_final_first: bool
) -> None:
    """Also if the cancel was on its way; and it is not killed, though it takes longer than a cancelled one may."""
    session, worker = begun(workers)
    if is_final_first:
        worker.say(FINAL)
        session.ask(2, "cancel", id=1)
    else:
        session.ask(2, "cancel", id=1)
        assert worker.told.get(timeout=SOON_S) == {"cancel": 1}
        worker.say(FINAL)
    threading.Event().wait(1.5 * front_module.GRACE_S)
    session.ask(4, "hello")
    assert session.hear()["id"] == 4
    assert worker.told.empty()
    assert not worker.was_killed
    worker.say(ANSWER, RESULT)
    assert [session.hear(), session.hear()] == [RESULT, {"id": 2, "result": {"cancelled": False}}]
    session.close()


def test_a_result_that_was_on_its_way_is_not_cancelled(workers: SimpleQueue[Worker]) -> None:
    session, worker = begun(workers)
    session.ask(2, "cancel", id=1)
    worker.say(ANSWER, RESULT)
    assert {"id": 2, "result": {"cancelled": False}} in [session.hear(), session.hear()]
    session.close()


def test_a_worker_that_does_not_stop_is_killed_and_the_request_was_cancelled(workers: SimpleQueue[Worker]) -> None:
    session, worker = begun(workers)
    session.ask(2, "cancel", id=1)
    assert [session.hear()["error"]["kind"], session.hear()] == ["Cancelled", {"id": 2, "result": {"cancelled": True}}]
    assert worker.was_killed
    session.close()


@pytest.mark.parametrize("said", [CANCELLED, ANSWER, None])
def test_every_request_is_answered_when_the_input_ends(workers: SimpleQueue[Worker], said: bytes | None) -> None:
    session, worker = begun(workers)
    session.ask(2, "seams", handle="p1")
    session.end_input()
    assert worker.told.get(timeout=SOON_S) == {"cancel": 1}
    if said is not None:
        worker.say(said, RESULT if said == ANSWER else REFUSED)
    answers = [session.hear(), session.hear()]
    assert [each["id"] for each in answers] == [1, 2]
    kinds = [each.get("error", {}).get("kind") for each in answers]
    assert kinds == [None if said == ANSWER else "Cancelled", "Cancelled"]
    session.end()
