"""How commands start: threads, packages of others beside them; and what they say after a signal to end."""

import signal
import sys
import threading
import time
from pathlib import Path

import pytest

from tests.running import TIMEOUT_S, run_command
from wpcal.cli import main
from wpcal.cli.main import EXIT_INTERRUPTED, EXIT_OUR_FAULT

CODES = {signal.SIGINT: EXIT_INTERRUPTED, signal.SIGTERM: 143, signal.SIGHUP: 129}


@pytest.fixture
def command(monkeypatch):
    """Let a function be the whole command line, with the signals as a shell sets them."""

    def become(act):
        monkeypatch.setattr(main.wpcal, "main", lambda **_: act())
        return main._run([])

    kept = {number: signal.getsignal(number) for number in CODES}
    for number in CODES:  # also where this run was started with nohup
        signal.signal(number, signal.default_int_handler if number == signal.SIGINT else signal.SIG_DFL)
    yield become
    for number, handler in kept.items():
        signal.signal(number, handler)


@pytest.mark.parametrize(("number", "code"), CODES.items())
def test_an_error_that_an_interruption_caused_is_an_interruption(command, capsys, number, code):
    """Python's import machinery answers an interruption between two of its lines so."""

    def interrupted_import():
        try:
            signal.raise_signal(number)
        except KeyboardInterrupt:
            threading.RLock().release()

    assert command(interrupted_import) == code
    assert "internal error" not in capsys.readouterr().err


def test_a_signal_within_a_destructor_is_not_lost(command, capsys):
    """Python drops what is raised there, and the command would go on."""

    class Ends:
        def __del__(self):
            signal.raise_signal(signal.SIGINT)

    def dropped():
        Ends()
        threading.Event().wait(TIMEOUT_S)

    begun = time.monotonic()
    assert command(dropped) == EXIT_INTERRUPTED
    assert time.monotonic() - begun < TIMEOUT_S
    assert "Exception ignored" not in capsys.readouterr().err


def test_a_second_signal_does_not_disturb_the_end_of_the_first(command, capsys):
    ended = []

    def twice():
        try:
            signal.raise_signal(signal.SIGTERM)
        finally:
            signal.raise_signal(signal.SIGINT)
            ended.append("all removed")

    assert command(twice) == CODES[signal.SIGTERM]
    assert ended == ["all removed"]
    assert capsys.readouterr().err == "wpcal: ended by SIGTERM\n"


def test_the_same_error_without_an_interruption_is_our_fault(command, capsys):
    assert command(lambda: threading.RLock().release()) == EXIT_OUR_FAULT
    assert "cannot release un-acquired lock" in capsys.readouterr().err


@pytest.mark.parametrize(("number", "code"), CODES.items())
def test_an_interruption_beside_the_command_is_one_line(command, capsys, number, code):
    assert command(lambda: signal.raise_signal(number)) == code
    assert capsys.readouterr().err.count("\n") == 1


def test_handlers_are_put_back(command):
    before = {number: signal.getsignal(number) for number in CODES}
    command(lambda: 0)
    assert {number: signal.getsignal(number) for number in CODES} == before


SHOWN = """
import os, sys
from wpcal.cli import main
print("numpy" in sys.modules)
main.wpcal.main = lambda **_: print(os.environ["OPENBLAS_NUM_THREADS"], os.environ["OMP_NUM_THREADS"])
main.run([])
"""


def test_a_command_computes_with_one_thread() -> None:
    done = run_command(sys.executable, "-c", SHOWN, OPENBLAS_NUM_THREADS="8", OMP_NUM_THREADS="8")
    assert done.stdout.split() == ["False", "1", "1"]


@pytest.mark.parametrize("file", ["cad/__init__.py", "cad.py"])
def test_a_foreign_cad_is_named(tmp_path: Path, file: str) -> None:
    foreign = tmp_path / "other project" / file
    foreign.parent.mkdir(parents=True)
    foreign.write_text("")
    (tmp_path / "empty").mkdir()
    wpcal, path = Path(sys.executable).with_name("wpcal"), str(tmp_path / "other project")
    done = run_command(wpcal, "features", "part.step", cwd=tmp_path / "empty", PYTHONPATH=path)
    assert (done.returncode, done.stdout, done.stderr.count("\n")) == (2, "", 1)
    assert "another package is called cad and hides the one of wpcal" in done.stderr
    assert str(foreign if file == "cad.py" else foreign.parent) in done.stderr
