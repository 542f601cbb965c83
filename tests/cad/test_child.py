from __future__ import annotations

import os
import random
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from cad.kernel.child import ChildFaultError, run_in_child
from wpcal.core.errors import FormatError, KernelError, WpcalError

LIMIT_S = 60.0
SETTLE_S = 0.5  # from the start of the child to the parent waiting for it
"""More than any of these files needs on a busy machine, so that reaching it means a hang."""


def test_a_result_comes_back(probe: str) -> None:
    assert run_in_child(f"{probe}:double", {"value": 2.5}, what="doubling") == 5.0


def test_the_parent_does_not_load_the_kernel() -> None:
    script = "import sys, cad.kernel.child; sys.exit('OCP' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0


def test_progress_arrives_and_noise_does_not(probe: str, capfd: pytest.CaptureFixture[str]) -> None:
    heard: list[str] = []
    assert run_in_child(f"{probe}:chatter", what="chatting", progress=heard.append) == 7
    assert heard == ["first", "second"]
    assert capfd.readouterr() == ("", "")


def test_our_errors_come_back_as_themselves(probe: str) -> None:
    with pytest.raises(FormatError, match=r"^part\.step, line 3: is odd$") as caught:
        run_in_child(f"{probe}:refuse", what="reading")
    assert (caught.value.path, caught.value.line) == ("part.step", 3)


def test_a_crash_is_one_line(probe: str, capfd: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(KernelError, match=r"^reading part\.step: the CAD kernel crashed \(SIGSEGV\)$"):
        run_in_child(f"{probe}:crash", what="reading part.step")
    assert capfd.readouterr() == ("", "")


def test_a_hang_is_one_line(probe: str) -> None:
    with pytest.raises(KernelError, match=r"stopped after 0\.5 s"):
        run_in_child(f"{probe}:hang", what="reading", timeout_s=0.5)


def test_an_early_end_is_one_line(probe: str) -> None:
    with pytest.raises(KernelError, match="ended with code 3"):
        run_in_child(f"{probe}:give_up", what="reading")


def test_a_defect_is_told_with_its_place(probe: str) -> None:
    with pytest.raises(ChildFaultError, match="ZeroDivisionError: nobody foresaw this") as caught:
        run_in_child(f"{probe}:defect", what="reading")
    assert "step_probe.py" in caught.value.__notes__[0]


def test_an_interrupt_ends_the_child(probe: str) -> None:
    script = (
        "import signal; from cad.kernel.child import run_in_child\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # a shell's background job ignores interrupts
        f"run_in_child('{probe}:hang', what='hanging')\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", script], stderr=subprocess.PIPE, text=True)
    children = Path(f"/proc/{parent.pid}/task/{parent.pid}/children")
    if not children.parent.exists():
        parent.kill()
        pytest.skip("needs /proc to see a child of a child")
    deadline = time.monotonic() + LIMIT_S
    while not (found := children.read_text().split()) and time.monotonic() < deadline:
        time.sleep(0.05)
    while b"cad.kernel.child" not in Path(f"/proc/{found[0]}/cmdline").read_bytes() and time.monotonic() < deadline:
        time.sleep(0.05)
    time.sleep(SETTLE_S)
    os.kill(parent.pid, signal.SIGINT)
    parent.communicate(timeout=LIMIT_S)
    assert len(found) == 1
    assert not Path(f"/proc/{found[0]}").exists()


def damaged(text: bytes, rng: random.Random) -> bytes:
    """Cut a file off, flip some of its bytes, change some of its digits, or take a piece out of it."""
    data = bytearray(text)
    kind = rng.choice(["cut", "flip", "digits", "delete"])
    if kind == "cut":
        return bytes(data[: rng.randrange(len(data))])
    if kind == "delete":
        at = rng.randrange(len(data))
        return bytes(data[:at] + data[at + rng.choice([1, 10, 200]) :])
    for _ in range(rng.choice([1, 3, 20])):
        at = rng.randrange(len(data))
        if kind == "flip":
            data[at] = rng.choice(b"0123456789#'(),;.*$ABZ \n/\\\xff\x00")
        elif chr(data[at]).isdigit():
            data[at] = rng.choice(b"0123456789")
    return bytes(data)


@pytest.mark.parametrize(
    ("name", "count"),
    [
        ("red_cube_blue_cylinder.step", 5),
        ("colored.step", 5),
        pytest.param("colored.step", 80, marks=pytest.mark.deep),
        pytest.param("as1-oc-214.stp", 80, marks=pytest.mark.deep),
    ],
)
def test_a_damaged_file_is_a_result_or_one_line(
    shared_step: Path, tmp_path: Path, probe: str, name: str, count: int
) -> None:
    # A damaged file can corrupt the kernel's memory and crash or hang it now and then; the limit is a line as well.
    text, rng = (shared_step / name).read_bytes(), random.Random(f"{name} 20")
    for _ in range(count):
        source = tmp_path / "damaged.step"
        source.write_bytes(damaged(text, rng))
        arguments = {"source": str(source), "target": str(tmp_path / "moved.step")}
        try:
            run_in_child(f"{probe}:read_and_move", arguments, what="moving", timeout_s=LIMIT_S)
        except WpcalError as error:  # anything else is a traceback, and fails this test
            line = str(error)
        else:
            continue
        assert line
        assert "\n" not in line
