"""What jobs on a Dask worker do in tests: work, crash, hang, or need too much memory. Their points say which."""

import os
import signal
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from cad.batch.job_record import original
from wpcal.core.errors import InputError


def open_group(part: str, words: tuple[str, ...]) -> str:
    text = Path(part).read_text()
    if text == "refused":
        raise InputError(f"{part}: this part cannot be read")
    return text


def run_job(
    opened: str, *, folder: Path, part: str, taught: str, words: tuple[str, ...], origins: Mapping[str, str], out: Path
) -> dict[str, Any]:
    folder.mkdir()
    do = Path(taught).read_text()
    if do == "crash":
        os.kill(os.getpid(), signal.SIGSEGV)
    if do == "hang":
        time.sleep(60)
    if do == "memory":
        return {"size": len(bytearray(3_000_000_000))}
    if do == "refuse":
        raise InputError(f"{taught}: this job cannot be done")
    out.mkdir()
    (out / "result.txt").write_text(f"{opened} {original(part, origins)} {original(taught, origins)}")
    return {"group": os.getppid(), "seconds": 0.0}
