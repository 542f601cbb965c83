"""Signals against `wpcal pick`, while it reads the part and while it serves: nothing typed is lost, nothing stays."""

import http.client
import json
import os
import random
import signal
import subprocess
from collections import Counter
from contextlib import closing, suppress
from pathlib import Path
from urllib.parse import urlsplit

from tests.attack.faults import ORPHAN_S, TIMEOUT_S, WPCAL
from tests.running import are_gone, children_of

COLUMNS = ["name", "x_mm", "y_mm", "z_mm", "feature", "use"]
TYPED = ["V2", "812.29", "-240.62", "165.80", "V2", "yes"]
CODES = {signal.SIGINT: 0, signal.SIGTERM: 143, signal.SIGHUP: 129, signal.SIGKILL: -9}
"""Of a picker that serves; Ctrl-C is its usual end. While it still reads the part, Ctrl-C ends with 130."""


def start_picker(folder: Path) -> subprocess.Popen[str]:
    """Start the picker of the sample part on a table of its own."""
    for left in folder.glob("typed.csv*"):
        left.unlink()
    return subprocess.Popen(
        [WPCAL, "pick", "tee.step", "-o", "typed.csv", "--no-browser"],
        cwd=folder,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
        preexec_fn=_heed_signals,  # noqa: PLW1509  # the tests start it from one thread
    )


def _heed_signals() -> None:
    """Undo what `nohup` does to the tests: a program that inherits an ignored SIGHUP goes on ignoring it."""
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def type_a_row(process: subprocess.Popen[str]) -> http.client.HTTPConnection:
    """Wait for the address of the page, do what the page does when a row was typed, and return its connection."""
    place = urlsplit(process.stdout.readline().split(" is at ")[1].split()[0])
    change = {"revision": 1, "window": "w", "number": 1, "conflicts": []}
    change["table"] = {"columns": COLUMNS, "rows": [TYPED], "keys": ["a"]}
    connection = http.client.HTTPConnection(place.netloc, timeout=TIMEOUT_S)
    headers = {"Origin": f"http://{place.netloc}", "Content-Type": "application/json"}
    connection.request("POST", f"{place.path}keep", json.dumps(change), headers)
    assert json.loads(connection.getresponse().read())["answer"]["revision"] == 2
    return connection


def end_while_serving(folder: Path, numbers: tuple[signal.Signals, ...]) -> Counter[str]:
    """End the picker by a signal after a row was typed, with the page still connected."""
    found: Counter[str] = Counter()
    for number in numbers:
        process = start_picker(folder)
        with closing(type_a_row(process)):
            children = children_of(process.pid)
            process.send_signal(number)
            process.communicate(timeout=TIMEOUT_S)
        draft = folder / "typed.csv.draft"
        kept = draft.is_file() and TYPED in json.loads(draft.read_text(encoding="utf-8"))["table"]["rows"]
        found["draft kept"] += kept
        found["nothing"] += not kept
        found["other exit code"] += process.returncode != CODES[number]
        _count_what_is_left(found, folder, children)
    return found


def end_while_reading(folder: Path, count: int, rng: random.Random, *, longest_s: float) -> Counter[str]:
    """End the picker by a signal at random moments before it serves."""
    found: Counter[str] = Counter()
    for row in range(count):
        number = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGKILL)[row % 4]
        process = start_picker(folder)
        with suppress(subprocess.TimeoutExpired):
            process.wait(rng.uniform(0.0, longest_s))
        children = children_of(process.pid)
        process.send_signal(number)
        process.communicate(timeout=TIMEOUT_S)
        expected = {-number, 128 + number, CODES[number]}  # before wpcal handles signals, while it reads, and after
        found["other exit code"] += process.returncode not in expected
        found["had a child"] += bool(children)
        _count_what_is_left(found, folder, children)
    return found


def _count_what_is_left(found: Counter[str], folder: Path, children: list[int]) -> None:
    found["orphan after 0.4 s"] += not are_gone(*children, within_s=ORPHAN_S)
    found["runs"] += 1
    found["MIXED"] += (folder / "typed.csv").exists()
