"""What the processes of a batch do in tests: jobs that work, crash, hang, or are killed."""

import os
import signal
import time
from pathlib import Path
from typing import Any

from wpcal.core.errors import InputError


def open_group(name: str) -> str:
    if name == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if name == "refused":
        raise InputError("this part cannot be read")
    if name == "late":
        time.sleep(60)
    return name


def run_job(opened: str, *, folder: Path, do: str, marks: Path) -> dict[str, Any]:
    folder.mkdir()
    (folder / "begun").write_text("half")
    times = len(list(marks.iterdir()))
    (marks / f"{times}-{os.getpid()}").touch()
    if do == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if do == "hang":
        time.sleep(60)
    if do == "memory":
        return {"size": len(bytearray(3_000_000_000))}
    if do == "refuse":
        raise InputError("this job cannot be done")
    if do == "fault":
        raise RuntimeError("a defect")
    if do == "full":
        raise OSError(28, "No space left on device", str(folder))
    if do in ("kill me", "kill my group") and not (marks / "killed").exists():
        (marks / "killed").touch()
        os.kill(os.getppid() if do == "kill my group" else os.getpid(), signal.SIGKILL)
        time.sleep(60)
    return {"group": opened, "process": os.getpid(), "parent": os.getppid()}
