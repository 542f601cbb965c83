"""What a batch leaves and what reads it: kept answers, `wpcal drift` over folders, `wpcal verify` of a request."""

import json
import shutil
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from cad.batch.compare import compare_claim
from cad.batch.inputs_now import InputsNow
from cad.batch.job_record import is_torn
from cad.cli.verify import Checked, _claim_of
from cad.workpiece.answer_cache import SUFFIX, AnswerCache, key_of
from tests.drift_jobs import simulated_jobs, write_batch
from tests.fuzz.target import FIXTURES, Target
from wpcal.cli.drift import _watched
from wpcal.core.errors import InputError
from wpcal.core.input_file import sha256_of
from wpcal.core.record_check import check_record
from wpcal.core.records import to_json
from wpcal.core.result_files import JOB_FILE
from wpcal.core.version import __version__
from wpcal.pages.drift import build_drift_page
from wpcal.study.drift import read_drift_jobs
from wpcal.study.drift.record import drift_record
from wpcal.study.drift.watch import JobsAsked

QUESTION, OF = "a question", ("a part", 1.5)
ANSWER = {"a": [1, 2.5, None], "b": "text" * 20}
NAMES = ("tee.step", "taught.csv")
DRIFTING = 9  #: Jobs of the folder: one more than `wpcal drift` needs.


class AnswerWrongError(Exception):
    """A damaged answer was taken for whole, or was not replaced."""


def kept_answer(data: bytes, path: Path) -> object:
    """Look up an answer in a folder whose file holds these bytes: it is the right one, and right in the folder then."""
    folder = path.with_suffix(".answers")
    folder.mkdir(exist_ok=True)
    file = folder / f"{key_of(QUESTION, OF)}{SUFFIX}"
    file.write_bytes(data)
    if AnswerCache(folder).answer(QUESTION, OF, lambda: ANSWER) != ANSWER:
        raise AnswerWrongError("another answer")
    if file.read_bytes() != whole_answer():
        raise AnswerWrongError("was not replaced")
    if data != whole_answer():
        raise InputError("found again")
    return ANSWER


@cache
def whole_answer() -> bytes:
    with TemporaryDirectory() as folder:
        AnswerCache(Path(folder)).answer(QUESTION, OF, lambda: ANSWER)
        [file] = Path(folder).iterdir()
        return file.read_bytes()


@cache
def drifting() -> dict[str, bytes]:
    """Return a small folder of a batch."""
    with TemporaryDirectory() as place:
        out = Path(place) / "out"
        write_batch(out, simulated_jobs(DRIFTING, seed=1, points=4), failed=1)
        return {path.relative_to(out).as_posix(): path.read_bytes() for path in out.rglob("*") if path.is_file()}


@dataclass(frozen=True, slots=True)
class Replaced:
    """A folder in which one file is replaced by the input, and what is done with it."""

    name: str
    files: Callable[[], Mapping[str, bytes]]
    then: Callable[[Path], object]

    def __call__(self, data: bytes, path: Path) -> object:
        folder = path.with_suffix(".out")
        shutil.rmtree(folder, ignore_errors=True)
        for name, content in {**self.files(), self.name: data}.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
        return self.then(folder)


def drift(folder: Path) -> object:
    """Do what `wpcal drift` does."""
    jobs, failed = read_drift_jobs([folder])
    parts, left_out = _watched(jobs, JobsAsked(first=20), failed=len(failed))
    record = json.loads(to_json(drift_record(parts, failed, left_out)))
    check_record(record, record["schema"], path="drift.json", is_complete=True)
    return build_drift_page(parts, failed, left_out).encode()


def claimed() -> dict[str, bytes]:
    """Return a folder of results with its request, and its inputs beside them."""
    files = {name: (FIXTURES / "tee" / name).read_bytes() for name in NAMES}
    made = {"seams.csv": b"seam,point\nW1,0\n", "seams.json": b'{"a": [1, {"name": "W1"}]}\n'}
    part, taught = ({"file": name, "sha256": sha256_of(data)} for name, data in files.items())
    request = {
        "schema": "wpcal/job/1",
        "wpcal": __version__,
        "inputs": {"part": part, "taught": taught, "options": ["--criterion=robust"], "files": [taught]},
        "result": RESULT,
        "files": {name: sha256_of(data) for name, data in made.items()},
    }
    return {**made, **{f"inputs/{name}": data for name, data in files.items()}, JOB_FILE: to_json(request).encode()}


RESULT: Mapping[str, Any] = {
    "verdict": "PASS",
    "worst_residual_mm": 0.1,
    "worst_point": "V1",
    "objective_mm": 0.1,
    "bound_mm": 0.1,
    "worst_seam_error_mm": None,
    "worst_seam": None,
    "pose": {"xyz_mm": [0.0, 1.0, 2.0], "rpy_deg": [0.0, 1.0, 2.0]},
    "exit_code": 0,
}


def verify(folder: Path) -> object:
    """Look up what a folder claims, and compare it with a copy of what was claimed."""
    around = {path for path in folder.parent.rglob("*") if folder not in path.parents}
    checked, copies = Checked(folder.name), folder / "copies"
    claim = _claim_of(folder, InputsNow((), (folder / "inputs",), copies), checked)
    if {path for path in folder.parent.rglob("*") if folder not in path.parents} - around:
        raise AnswerWrongError("wrote elsewhere")
    is_torn(folder)
    if claim is None:
        json.dumps(checked.to_record())
        raise InputError("is not as claimed, or cannot be checked")
    made = folder / "made"
    made.mkdir()
    for name in ("seams.csv", "seams.json", JOB_FILE):
        (made / name).write_bytes(claimed()[name])
    for each in compare_claim(folder, made, claim.record):
        raise InputError(" ".join(map(str, each.to_record().values())))
    return claim


def batch_targets() -> dict[str, Target]:
    """Return the readers of what a batch leaves, by name."""
    job = "j0003/calibration.json"
    seams = claimed()["seams.json"]
    return {
        "kept-answer": Target(kept_answer, (whole_answer(),)),
        "drift-summary": Target(Replaced("summary.jsonl", drifting, drift), (drifting()["summary.jsonl"],)),
        "drift-calibration": Target(Replaced(job, drifting, drift), (drifting()[job],)),
        "verify-job": Target(Replaced(JOB_FILE, claimed, verify), (claimed()[JOB_FILE],)),
        "verify-seams": Target(Replaced("seams.json", claimed, verify), (seams,)),
    }
