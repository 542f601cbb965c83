"""The exit code is the result's, whatever becomes of the streams on which it is printed."""

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from tests.few import few
from tests.running import TIMEOUT_S

FIXTURES = Path(__file__).parents[2] / "fixtures"
WPCAL = Path(sys.executable).with_name("wpcal")
FULL = Path("/dev/full")
TABLE = FIXTURES / "yin2003" / "table1.csv"
LARGE = "--tolerance-mm 100"
CASES = {
    "fit, within": (f"fit {TABLE} {LARGE}", 0),
    "json, above": (f"fit {TABLE} --tolerance-mm 0.001 --json", 1),
    "no such file": ("fit none.csv", 2),
    "no such option": ("fit --none", 2),
    "help": ("--help", 0),
}
"""What each command ends with when somebody reads its output."""
SLOW = {"fit, within": ("as it is", "nobody reads", "stderr closed", "both full")}
SLOW["no such file"] = SLOW["help"] = (*SLOW["fit, within"], "all closed")
"""Of commands that load libraries only to print what a quicker one prints as well, some streams are enough."""
STREAMS = {
    "as it is": "",
    "nobody reads": "| true",
    "one line is read": "| head -n 1 >/dev/null",
    "stdout closed": ">&-",
    "stderr closed": "2>&-",
    "all closed": "<&- >&- 2>&-",
    "stdout full": ">/dev/full",
    "both full": ">/dev/full 2>&1",
    "ascii only": "| true",
}


def ended(command: str, streams: str, *, ascii_only: bool = False, cwd: Path | None = None) -> tuple[int, str]:
    before = "LC_ALL=C PYTHONUTF8=0 PYTHONCOERCECLOCALE=0 " if ascii_only else ""
    script = f"{before}{WPCAL} {command} {streams}; exit ${{PIPESTATUS[0]}}"
    words = ["bash", "-c", script]
    done = subprocess.run(words, capture_output=True, text=True, check=False, timeout=TIMEOUT_S, cwd=cwd)
    return done.returncode, done.stderr


@pytest.mark.parametrize(
    ("case", "streams"), few([(case, one) for one in STREAMS for case in CASES if one in SLOW.get(case, STREAMS)], 10)
)
def test_no_stream_changes_the_exit_code(case: str, streams: str, tmp_path: Path) -> None:
    if "full" in STREAMS[streams] and not FULL.exists():
        pytest.skip("needs /dev/full")
    command, expected = CASES[case]
    code, errors = ended(command, STREAMS[streams], ascii_only=streams == "ascii only", cwd=tmp_path)
    assert code == expected, errors
    assert "Traceback" not in errors
    assert "Error" not in errors.replace("Error: ", "")


@pytest.mark.skipif(not FULL.exists(), reason="needs /dev/full")
def test_lost_output_is_said() -> None:
    code, errors = ended(f"fit {TABLE} {LARGE} --json", ">/dev/full")
    assert (code, errors.count("\n")) == (0, 1)
    assert errors == "wpcal: standard output was not written: no space left on device; exit code 0 is the result's\n"


@pytest.mark.deep
def test_a_calibration_that_nobody_reads_keeps_its_verdict(
    tmp_path: Path, answers: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("WPCAL_CACHE", str(answers))
    part, taught = FIXTURES / "tee" / "tee.step", FIXTURES / "tee" / "taught.csv"
    code, errors = ended(f"calibrate {part} {taught} -o {tmp_path / 'out'}", "| true")
    assert (code, errors.count("\n")) == (0, 1)
    assert (tmp_path / "out" / "report.html").exists()
    again = f"calibrate {part} {taught} -o {tmp_path / 'out'} --force --tolerance-mm 0.01"
    code, _ = ended(again, ">&-")
    assert code == 1


def test_sigterm_ends_a_command_like_ctrl_c(tmp_path: Path) -> None:
    running = subprocess.Popen(
        [WPCAL, "study", str(TABLE), "--trials", "100000000", "-o", "study.json"],
        cwd=tmp_path,
        env={**os.environ, "WPCAL_PROGRESS_AFTER_S": "0"},
        stderr=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert "trials" in running.stderr.readline()
    running.send_signal(signal.SIGTERM)
    printed, errors = running.communicate(timeout=TIMEOUT_S)
    assert (running.returncode, printed) == (128 + signal.SIGTERM, "")
    assert errors.splitlines()[-1] == "wpcal: ended by SIGTERM"
    assert list(tmp_path.iterdir()) == []
