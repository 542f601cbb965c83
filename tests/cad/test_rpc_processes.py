"""`wpcal rpc`: a crash or a cancel costs one request, and no process stays behind."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.few import few
from tests.rpc_client import GONE_S, RpcClient
from tests.running import are_gone, needs_proc

TEE = Path(__file__).parents[2] / "fixtures" / "tee"
GRACE_S = 1.0  #: A request that is cancelled in the middle of the kernel ends after this time.

pytestmark = needs_proc


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copy(TEE / "tee.step", tmp_path)
    shutil.copy(TEE / "taught.csv", tmp_path)
    return tmp_path


@pytest.fixture(scope="module")
def client() -> Iterator[RpcClient]:
    client = RpcClient()
    yield client
    assert client.close() == 0


def test_a_worker_that_died_between_two_requests_costs_none(client: RpcClient, folder: Path) -> None:
    handle = client.ask("open", path=str(folder / "tee.step"))["handle"]
    os.kill(client.worker(), signal.SIGKILL)
    assert client.ask("seams", handle=handle)["seams"]


def test_a_cancelled_request_ends_and_leaves_nothing(client: RpcClient, folder: Path) -> None:
    handle, there = client.ask("open", path=str(folder / "tee.step"))["handle"], set(folder.iterdir())
    running = client.send("touches", handle=handle, out=str(folder / "out"), options={"touches": 12})
    waiting = client.send("seams", handle=handle)
    while "progress" not in client.hear():
        pass
    asked = [client.send("cancel", id=waiting), client.send("cancel", id=running), client.send("cancel", id=running)]
    answers = {message["id"]: message for message in (client.answer() for _ in range(5))}
    assert [answers[number]["result"] for number in asked] == [{"cancelled": True}] * 3
    assert [answers[number]["error"]["kind"] for number in (running, waiting)] == ["Cancelled"] * 2
    assert client.ask("cancel", id=running) == {"cancelled": False}
    assert client.ask("seams", handle=handle)["seams"]
    assert set(folder.iterdir()) == there


@pytest.mark.parametrize("step", few(["writing the moved part", "fitting"], 1))
@pytest.mark.parametrize("later_s", few([0.0, 0.1, 0.01, 0.05, 0.3], 1))
def test_cancelled_is_said_of_a_save_exactly_if_nothing_is_written(
    client: RpcClient, folder: Path, step: str, later_s: float
) -> None:
    handle, there = client.ask("open", path=str(folder / "tee.step"))["handle"], set(folder.iterdir())
    running = client.send("save", handle=handle, taught={"path": str(folder / "taught.csv")}, out=str(folder / "out"))
    while not (message := client.hear()).get("progress", {"text": step})["text"].startswith(step):
        pass
    time.sleep(later_s)
    asked = client.send("cancel", id=running)
    answers = {each["id"]: each for each in [message] if "progress" not in each}
    while len(answers) < 2:
        message = client.answer()
        answers[message["id"]] = message
    assert answers[asked]["result"]["cancelled"] is ("error" in answers[running])
    if "error" in answers[running]:
        assert answers[running]["error"]["kind"] == "Cancelled"
        assert set(folder.iterdir()) == there
    else:
        assert set(folder.iterdir()) == {*there, folder / "out"}
        assert (folder / "out" / "job.json").is_file()


def test_a_save_that_is_killed_leaves_nothing_and_the_handle_stays(client: RpcClient, folder: Path) -> None:
    handle, there = client.ask("open", path=str(folder / "tee.step"))["handle"], set(folder.iterdir())
    before, worker = client.ask("seams", handle=handle)["seams"], client.worker()
    client.send("save", handle=handle, taught={"path": str(folder / "taught.csv")}, out=str(folder / "out"))
    while not client.hear().get("progress", {"text": ""})["text"].startswith("writing the moved part"):
        pass
    assert set(folder.iterdir()) > there
    os.kill(worker, signal.SIGSEGV)
    error = client.answer()["error"]
    assert (error["kind"], "SIGSEGV" in error["message"]) == ("KernelCrash", True)
    assert set(folder.iterdir()) == there
    assert client.ask("seams", handle=handle)["seams"] == before
    assert client.worker() != worker


@pytest.mark.deep
def test_a_request_that_cannot_be_interrupted_is_cancelled_by_a_new_worker(client: RpcClient, folder: Path) -> None:
    handle = client.ask("open", path=str(folder / "tee.step"))["handle"]
    worker = client.worker()
    os.kill(worker, signal.SIGSTOP)
    running = client.send("seams", handle=handle)
    begin = time.monotonic()
    client.send("cancel", id=running)
    answers = {message["id"]: message for message in (client.answer() for _ in range(2))}
    assert answers[running]["error"]["kind"] == "Cancelled"
    assert GRACE_S / 2 < time.monotonic() - begin < GRACE_S + 1.0
    assert client.ask("seams", handle=handle)["seams"]
    assert client.worker() != worker


@pytest.mark.deep
def test_nothing_stays_when_the_client_closes_its_end_during_a_request(folder: Path) -> None:
    client = RpcClient()
    handle = client.ask("open", path=str(folder / "tee.step"))["handle"]
    worker = client.worker()
    os.kill(worker, signal.SIGSTOP)
    client.send("seams", handle=handle)
    begin = time.monotonic()
    assert client.close() == 0
    assert are_gone(worker, within_s=GONE_S)
    assert time.monotonic() - begin < GONE_S


def test_nothing_stays_when_the_front_is_killed() -> None:
    client = RpcClient()
    client.ask("hello")
    worker = client.worker()
    client.process.kill()
    assert are_gone(worker, within_s=GONE_S)
    client.close()


def test_nothing_stays_when_the_client_is_killed_and_nobody_reads(folder: Path) -> None:
    """The front is in the middle of a long answer that nobody takes."""
    script = (
        "import os, signal, subprocess, sys, time\n"
        "p = subprocess.Popen([sys.executable, '-m', 'wpcal', 'rpc'], stdin=subprocess.PIPE, stdout=subprocess.PIPE)\n"
        "for i in range(3000):\n"
        '    p.stdin.write(b\'{"id": %d, "method": "hello"}\\n\' % i)\n'
        "p.stdin.flush()\n"
        "print(p.pid, flush=True)\n"
        "time.sleep(60)\n"
    )
    killed = subprocess.Popen([sys.executable, "-c", script], cwd=folder, stdout=subprocess.PIPE)
    front = int(killed.stdout.readline())
    time.sleep(0.5)
    killed.kill()
    assert are_gone(front, within_s=GONE_S)
    killed.communicate()


def test_requests_in_a_file_are_all_answered(folder: Path) -> None:
    lines = (
        '{"id":1,"method":"open","params":{"path":"tee.step"}}\n{"id":2,"method":"seams","params":{"handle":"p1"}}\n'
    )
    (folder / "requests").write_text(lines)
    with (folder / "requests").open("rb") as requests:
        done = subprocess.run(
            [sys.executable, "-m", "wpcal", "rpc"], stdin=requests, cwd=folder, capture_output=True, check=True
        )
    assert done.stdout.splitlines()[-1].startswith(b'{"id":2,"result":')
