import os
import pickle
import random
import signal
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cad.work.child import MEMORY_VARIABLE, TIME_VARIABLE, ChildFaultError, Limits, run_in_child
from cad.work.plain_data import pack, unpack
from cad.work.plain_types import PlainDataError
from tests.few import few
from tests.running import are_gone, needs_proc
from wpcal.core.errors import ErrorCode, FormatError, KernelError, WpcalError
from wpcal.core.issue import Issue
from wpcal.seam import SeamOptions
from wpcal.seam.seam import Finding, FlareGroove, JointType, Seam, SeamPieces, WeldType

LIMIT_S = 60.0  #: More than any of these files needs on a busy machine, so that reaching it means a hang.
SETTLE_S = 10.0  #: A child that waits for the kernel's end would need 60 s; `make attack` measures the time itself.


def test_the_parent_does_not_load_the_kernel() -> None:
    script = "import sys, cad.work.child; sys.exit('OCP' in sys.modules)"
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
    with pytest.raises(
        KernelError, match=r"^reading part\.step: the CAD kernel cannot read this file: it crashed \(SIGSEGV\)$"
    ):
        run_in_child(f"{probe}:crash", what="reading part.step")
    assert capfd.readouterr() == ("", "")


def test_a_hang_is_one_line(probe: str) -> None:
    with pytest.raises(KernelError, match=r"stopped after 0\.5 s"):
        run_in_child(f"{probe}:hang", what="reading", limits=Limits(time_s=0.5))


def test_an_early_end_is_one_line(probe: str) -> None:
    with pytest.raises(KernelError, match="ended with code 3"):
        run_in_child(f"{probe}:give_up", what="reading")


def test_an_exception_of_the_kernel_is_no_defect_of_ours(probe: str) -> None:
    with pytest.raises(KernelError, match=r"the CAD kernel failed \(Standard_OutOfRange: nobody caught this\)"):
        run_in_child(f"{probe}:kernel_exception", what="reading")


def test_a_defect_is_told_with_its_place(probe: str) -> None:
    with pytest.raises(ChildFaultError, match="ZeroDivisionError: nobody foresaw this") as caught:
        run_in_child(f"{probe}:defect", what="reading")
    assert "step_probe.py" in caught.value.__notes__[0]


@pytest.mark.parametrize(
    ("variable", "value", "what", "says"),
    few(
        [
            (
                TIME_VARIABLE,
                "0.5",
                "hang",
                r"stopped after 0\.5 s, its time limit; set WPCAL_KERNEL_TIME_S to allow more",
            ),
            (TIME_VARIABLE, "soon", "hang", r"^WPCAL_KERNEL_TIME_S: expected a positive number, got 'soon'$"),
            (MEMORY_VARIABLE, "-1", "fill", r"^WPCAL_KERNEL_MEMORY_GB: expected a positive number, got '-1'$"),
            (MEMORY_VARIABLE, "nan", "fill", r"^WPCAL_KERNEL_MEMORY_GB: expected a positive number"),
            (
                MEMORY_VARIABLE,
                "2",
                "fill",
                r"needs more than its limit of 2 GB of memory; set WPCAL_KERNEL_MEMORY_GB to",
            ),
        ],
        4,
    ),
)
def test_the_limits_are_those_of_the_environment(
    probe: str, monkeypatch: pytest.MonkeyPatch, variable: str, value: str, what: str, says: str
) -> None:
    if what == "fill" and value == "2" and sys.platform != "linux":
        pytest.skip("only Linux limits the memory of a process")
    monkeypatch.setenv(variable, value)
    with pytest.raises(WpcalError, match=says) as stopped:
        run_in_child(f"{probe}:{what}", what="reading part.step")
    assert stopped.value.exit_code == 2


def test_a_crash_says_at_which_step(probe: str) -> None:
    with pytest.raises(KernelError, match=r"cannot work with this file: it crashed \(SIGSEGV\) at the step: fitting$"):
        run_in_child(f"{probe}:crash_later", what="calibrating part.step", progress=lambda _: None)


def hanging_parent(probe: str, function: str, *, death_signal: bool = True) -> tuple[subprocess.Popen[str], int]:
    """Start a process that waits for its child, and return both."""
    script = (
        "import signal, subprocess; from cad.work import child\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # a shell's background job ignores interrupts
        "start = subprocess.Popen\n"
        f"other = {None if death_signal else 'no_death_signal'!r}\n"
        "child.subprocess.Popen = lambda command, **more: start(\n"
        "    [other if other and word.endswith('child_main') else word for word in command], **more)\n"
        f"child.run_in_child('{probe}:{function}', what='hanging', progress=lambda text: print(text, flush=True))\n"
    )
    parent = subprocess.Popen([sys.executable, "-c", script], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    return parent, int(parent.stdout.readline())


@needs_proc
@pytest.mark.parametrize(
    ("number", "function", "death_signal"),
    few(
        [
            (signal.SIGINT, "hang", True),
            (signal.SIGKILL, "hang_in_compiled_code", True),
            (signal.SIGKILL, "hang_in_compiled_code", False),
            *((number, "hang", False) for number in (signal.SIGINT, signal.SIGKILL)),
            *((signal.SIGINT, "hang_in_compiled_code", signalled) for signalled in (True, False)),
            (signal.SIGKILL, "hang", True),
        ],
        1,
    ),
)
def test_the_child_ends_with_its_parent(probe: str, number: int, function: str, death_signal: bool) -> None:
    parent, child = hanging_parent(probe, function, death_signal=death_signal)
    os.kill(parent.pid, number)
    parent.communicate(timeout=LIMIT_S)
    assert are_gone(child, within_s=SETTLE_S)


@pytest.mark.parametrize(
    "value",
    [
        {"a": [1, 2.5, None, True, "\udc80ä"], 2: (float("inf"), b"\0x", Path("/a b"))},
        (np.arange(6.0).reshape(2, 3), np.asfortranarray(np.eye(3)[:, :2]), np.zeros((0, 3)), np.float32(1.5)),
        [np.array(["a", "bc"]), np.array([True]), {1, 2}, frozenset({"x"})],
        SeamOptions(),
        ErrorCode.KERNEL,
    ],
)
def test_plain_data_comes_back_as_it_was(value: object) -> None:
    found = unpack(pack(value))
    assert pickle.dumps(found) == pickle.dumps(unpack(pack(found)))
    assert repr(found) == repr(value)
    assert type(found) is type(value)


def test_an_object_that_occurs_twice_is_one_object() -> None:
    issue = Issue("odd", "is odd")
    first, second = unpack(pack([issue, (issue,)]))
    assert second[0] is first


def test_many_objects_of_one_class_are_few_arrays() -> None:
    n = np.arange(3)
    pieces = [SeamPieces(n[:k], n[:k] / 2, n[:k] / 3, n[:k], n[:k], np.ones((k, 3))) for k in (1, 3, 2, 0, 1)]
    seams = tuple(
        Seam(f"W{k}", joint, WeldType.FILLET, ("ä",) * k, own, k > 1, k / 3, True, False, ("r", "")[:k])
        for k, (joint, own) in enumerate(zip(JointType, pieces, strict=False))
    )
    findings = (Finding("bolt", 0.5, "a bolt", "S1"), Finding("short", 0.25, "short"))
    seams = (*seams[:3], replace(seams[3], lean_rad=np.eye(2), findings=findings, groove=FlareGroove(1.0, 2.0, 3.0)))
    packet = pack((seams, seams[0].pieces))
    found, _ = unpack(packet)
    assert repr(found) == repr(seams)
    assert packet.count(b"wpcal.seam.seam:SeamPieces") == 2  # of all seams once, and of the one beside them
    assert not found[1].pieces.t0.flags.writeable
    assert found[3].lean_rad.shape == (2, 2)
    with pytest.raises(PlainDataError):  # a column that ends too early
        unpack(packet.replace(b"[1, 3, 2, 0]", b"[1, 3, 9, 0]"))


class Touched:
    """Makes a file when it is unpickled."""

    def __reduce__(self) -> tuple[object, tuple[str]]:
        return (Path.touch, (Path("touched"),))  # type: ignore[return-value]


@pytest.mark.parametrize("value", [Touched(), np.array([Touched()], dtype=object), print, Path, {1: Touched()}])
def test_what_is_not_plain_data_is_refused(value: object) -> None:
    with pytest.raises(PlainDataError, match="is not plain data"):
        pack(value)


@pytest.mark.parametrize("seed", range(40))
def test_a_damaged_packet_is_an_error_of_ours_or_plain_data(seed: int) -> None:
    rng = random.Random(seed)
    packet = pack({"seams": [SeamOptions(), np.arange(5.0)], "issues": (Issue("a", "b", ("c",)),)})
    for _ in range(50):
        try:
            value = unpack(damaged(packet, rng))
        except PlainDataError:
            continue
        assert pack(value)  # anything but plain data is refused


@pytest.mark.parametrize(
    "tree",
    [
        '{"data": ["subprocess:Popen", []]}',
        '{"enum": ["os:system", "x"]}',
        '{"error": ["builtins:ValueError", {"tuple": []}, {"dict": []}]}',
        '{"data": ["wpcal.core.records:write_file", []]}',
        '{"data": ["wpcal.core.errors:InputError", []]}',
        '{"error": ["wpcal.core.issue:Issue", {"tuple": []}, {"dict": []}]}',
        '{"array": ["O", [1], "C", 0]}',
        '{"rows": {"rows": ["subprocess:Popen", []]}}',
        '{"rows": {"enums": ["os:system", ["x"]]}}',
        '{"rows": {"arrays": ["O", [], [0], 0]}}',
    ],
)
def test_a_packet_makes_nothing_but_data_of_ours(tree: str) -> None:
    text = f'{{"value": {tree}, "sizes": []}}'.encode()
    with pytest.raises(PlainDataError):
        unpack(len(text).to_bytes(8, "little") + text)


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
