"""What commands do with what they have read: pages, programs, the picker's answers, packets of the kernel's process.

A reader may accept what the next step cannot use. That step must then refuse it in the same clear way.
"""

import asyncio
import json
import re
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, cast

import numpy as np
from starlette.requests import Request
from starlette.routing import Route

from cad.batch.job_list import read_jobs, words_of
from cad.batch.job_record import JobInputs, is_made_of, read_job_record
from cad.batch.jobs import option_columns
from cad.batch.request import read_pose
from cad.batch.summary import NUMBERS, seconds_of
from cad.batch.summary_check import check_summary, read_summary
from cad.pick.draft import Keyed
from cad.pick.server import INTERNAL, build_app
from cad.pick.shared_seams import SharedSeams
from cad.pick.shared_table import SharedTable
from cad.session.part import PickPart
from cad.session.rows import NEW_COLUMNS
from cad.session.session import PickSession
from cad.work.plain_data import pack, unpack
from cad.work.plain_types import PlainDataError
from cad.workpiece.workpiece import Workpiece
from tests.fuzz.target import FIXTURES, Target, of_path
from wpcal.brep.graph_file import read_graph
from wpcal.controllers.program.weld_program import build_program
from wpcal.controllers.registry import exporter_named, exporter_names
from wpcal.core.errors import InputError, WpcalError
from wpcal.core.input_file import sha256_of
from wpcal.core.result_files import JOB_FILE, SUMMARY_FILE
from wpcal.core.schemas import schema_text
from wpcal.core.version import __version__
from wpcal.pages.cell import build_cell_page
from wpcal.pages.report import build_report
from wpcal.planning.cell.cell_check import cell_check_record, check_cell
from wpcal.planning.cell.cell_file import read_cell
from wpcal.planning.plan.seam_file import read_seam_path
from wpcal.results.diff import compare_folders
from wpcal.results.folder import read_finished, read_result_folder
from wpcal.robot.kinematics.arm_file import arm_record, find_arm
from wpcal.seam import SeamOptions, detect_seams
from wpcal.seam.edit import read_edits
from wpcal.taught.features import judge_features

NOT_A_NUMBER = re.compile(r"(?<![\w.])[-+]?(nan|inf(inity)?)(?![\w.])", re.IGNORECASE)
CELL = FIXTURES / "cells" / "two-mh6.json"
TOKEN = "t"


class InternalError(Exception):
    """The picker told its page of an error of ours."""


@dataclass(frozen=True, slots=True)
class ResultFolderReader:
    """Reads a result folder in which one file is replaced by the input, and does with it what `then` does."""

    name: str
    files: Mapping[str, bytes]
    then: Callable[[Path], object]

    def __call__(self, data: bytes, path: Path) -> object:
        folder = path.with_suffix(".folder")
        folder.mkdir(exist_ok=True)
        for name, content in self.files.items():
            (folder / name).write_bytes(data if name == self.name else content)
        return self.then(folder)


JOBS = b"""job,part,taught,when,criterion,weld,wrap,bodies
a,tee.step,t.csv,now,robust,b;c,yes,each
B,p.step,u.csv,,,,no,
"""
FINISHED_JOB = (
    json.dumps(
        {
            "schema": "wpcal/job/1",
            "job": "a",
            "wpcal": __version__,
            "inputs": JobInputs(("tee.step", "0" * 64), ("taught.csv", "0" * 64)).to_record(),
            "result": {
                "verdict": "PASS",
                **dict.fromkeys(NUMBERS),
                "pose": {"xyz_mm": [0.0] * 3, "rpy_deg": [0.0] * 3},
                "exit_code": 0,
            },
            "files": {},
        }
    ).encode(),
    b'{"schema": "wpcal/job-summary/1", "job": "a", "seconds": 0.25}\n{"job": "b", "seconds": null}\n',
)
"""``job.json``, and lines of a summary."""


def read_folder(folder: Path) -> object:
    with suppress(InputError):
        compare_folders(folder, folder, atol_mm=1e-6)
    found = read_finished(folder)
    assert all(np.isfinite(seam.frames.p).all() for seam in found.seams)
    return found


def report(folder: Path) -> object:
    found = read_result_folder(folder)
    return build_report(found.calibration, found.seams, found.part_glb)


def export(folder: Path) -> object:
    """Write every format: each may refuse, none may write what is not a number."""
    program = build_program(read_finished(folder).select(everything=True))
    for name in exporter_names():
        with suppress(WpcalError):
            for content in exporter_named(name).write(program).values():
                text = content if isinstance(content, str) else content.decode("utf-8", "replace")
                assert NOT_A_NUMBER.search(text.replace('"INF"', "")) is None, f"{name} writes what is no number"
    return program


def job_list(path: Path) -> object:
    """Read a list of jobs, and the options of its rows as they are typed."""
    jobs = read_jobs(path, option_columns())
    for job in jobs:
        with suppress(InputError):
            job.require_sound()
            words_of(job.cells, option_columns())
    return len(jobs)


def finished_job(data: bytes, path: Path) -> object:
    """Look in a folder of a batch whether a job is complete, and how long jobs took."""
    for name in (JOB_FILE, SUMMARY_FILE):
        (path.parent / name).write_bytes(data)
    record = read_job_record(path.parent)
    inputs = JobInputs(("tee.step", "0" * 64), ("taught.csv", "0" * 64))
    seconds = seconds_of(path.parent)
    if record is not None:
        JobInputs.from_record(record["inputs"])
    with suppress(InputError):
        list(check_summary(path.parent, read_summary(path.parent)))
    if not seconds and not (record is not None and is_made_of(record, inputs, path.parent, beside=path.parent)):
        raise InputError("the job is done again")
    return list(seconds.values()), None if record is None else record["result"]["exit_code"]


def cell(path: Path) -> object:
    found = read_cell(path)
    json.dumps(cell_check_record(found, check_cell(found)), allow_nan=False)
    return found


def seams(path: Path) -> object:
    read_edits(path)
    return read_seam_path(path, "W1", read_cell(CELL))


def cell_with_arm(data: bytes, path: Path) -> object:
    """Read a cell whose arm is in a file beside it."""
    record = json.loads(CELL.read_text(encoding="utf-8"))
    record["torch_robot"]["arm"] = "own arm.json"
    path.with_name("own arm.json").write_bytes(data)
    path.write_text(json.dumps(record), encoding="utf-8")
    return check_cell(read_cell(path))


def nominal(path: Path) -> object:
    """Read ``--nominal``: the text itself, and a file with it."""
    with suppress(InputError):
        read_pose(path.read_bytes().decode("latin-1"))
    found = read_pose(str(path))
    assert np.isfinite(found.matrix).all()
    return found


def packet(data: bytes, _: Path) -> object:
    try:
        return unpack(data)
    except PlainDataError as error:  # the parent says that the kernel's process failed
        raise InputError(str(error)[:100]) from None


@cache
def pick_part() -> PickPart:
    """Return a part of the picker from a saved graph, without the kernel."""
    graph = read_graph(FIXTURES / "graphs" / "tee.npz")
    workpiece, options = Workpiece(graph), SeamOptions()
    found = detect_seams(graph, options, trimmed=workpiece.trimmed)
    touchables = judge_features(graph, workpiece.features, trimmed=workpiece.trimmed)
    return PickPart("tee.step", "0" * 64, workpiece, touchables, found, found, options, None, ())


def request(data: bytes, path: Path) -> object:
    """Give a request to the picker: a body for one of its actions."""
    try:
        found = json.loads(data)
        action = found["do"] if found["do"] in REQUESTS else "fit"
        body = json.dumps(found["body"]).encode()
    except (ValueError, TypeError, KeyError, RecursionError):
        action, body = "fit", data
    out = path.with_suffix(".pick") / "taught.csv"
    out.parent.mkdir(exist_ok=True)
    for old in out.parent.iterdir():
        old.unlink()
    out.write_bytes(OLD_TABLE)
    session, start = PickSession(pick_part()), Keyed.from_record(TABLE)
    table = SharedTable(out, session.part, start=start, file_sha256=sha256_of(OLD_TABLE))
    app = build_app(session, table, SharedSeams(session, out.with_name("seams.json")), "", token=TOKEN)
    routes = {route.path: route for route in app.routes if isinstance(route, Route)}
    with ThreadPoolExecutor(1) as own_thread:  # where no browser of another test has an event loop
        answer = own_thread.submit(asyncio.run, _answer(routes[f"/{TOKEN}/{action}"].endpoint, body)).result()
    fault = answer.get("fault")
    if fault is not None and fault["code"] == INTERNAL:
        raise InternalError(re.sub(r"\W+", " ", fault["message"])[:80])
    if fault is not None:
        raise InputError(fault["message"])
    return answer


async def _answer(endpoint: Any, body: bytes) -> dict[str, Any]:
    async def receive() -> dict[str, Any]:
        return {"type": "http.request", "body": body, "more_body": False}

    response = await endpoint(Request({"type": "http", "method": "POST", "headers": []}, receive))
    return cast(dict[str, Any], json.loads(response.body, parse_constant=_no_constant))


def _no_constant(word: str) -> None:
    raise InternalError(f"an answer holds {word}")


NAMES = ("V1", "V2", "V3", "V4")
TABLE = {
    "columns": list(NEW_COLUMNS),
    "rows": [[name, str(10 * n), str(n * n), "3.5", name, "yes"][: len(NEW_COLUMNS)] for n, name in enumerate(NAMES)],
    "keys": list(NAMES),
}
_KEEP = {"revision": 1, "window": "a", "number": 1, "table": TABLE, "conflicts": ["V1, x_mm: 1 or 2"]}
OLD_TABLE = b"name,x_mm,y_mm,z_mm\nV1,1,2,3\n"
_GOLDEN = json.loads((FIXTURES / "tee" / "golden" / "seams.json").read_text(encoding="utf-8"))
DECISIONS = [
    {"candidate": _GOLDEN["seams"][0]["candidate"], "edit": {"accept": True, "reverse": False, "name": "a"}},
    {"candidate": _GOLDEN["seams"][1]["candidate"], "edit": {"range_mm": [0, 5], "other_side": True}},
]
REQUESTS: Mapping[str, Any] = {
    "fit": TABLE,
    "suggest": TABLE,
    "read": {"name": "taught.csv", "base64": "bmFtZSx4X21tLHlfbW0sel9tbQpWMSwxLDIsMwo=", "uframe": ""},
    "table": {"revision": 0},
    "keep": _KEEP,
    "save": {"revision": 1, "shown": 1, "window": "a", "consent": [], "name": "new.csv", "replaces": ""},
    "open": {},
    "seams": {"revision": 0},
    "decide": {"revision": 1, "decisions": DECISIONS},
}
"""A body for every action of `cad.pick.server.build_app`."""


def result_files() -> dict[str, bytes]:
    """Return a small result folder. The hashes of its files are those of other files, and no file has such a name."""
    golden = FIXTURES / "tee" / "golden"
    calibration = json.loads((golden / "calibration.json").read_text())
    calibration["files"] = {"other.step": "0" * 64}
    record = json.loads((golden / "seams.json").read_text())
    record["seams"] = record["seams"][:2]
    for one in record["seams"]:
        one["frames"] = one["frames"][:4]
    record["T_base_part"] = calibration["T_base_part"]
    return {"calibration.json": json.dumps(calibration).encode(), "seams.json": json.dumps(record).encode()}


def further_targets() -> dict[str, Target]:
    """Return what commands do with records, by name."""
    files = result_files()
    with_part = {**files, "part.glb": (FIXTURES / "tee" / "golden" / "part.glb").read_bytes()}
    arm = json.dumps(arm_record(find_arm("mh6"))).encode()
    matrix = b'{"T_nominal_part": [[1, 0, 0, 5], [0, 1, 0, 6], [0, 0, 1, 7], [0, 0, 0, 1]]}'
    example = json.loads(schema_text("wpcal/seams/1"))["examples"][0]
    sent = pack({"a": np.eye(3), "b": (1, "x", None, Path("y")), "seams": example, "c": {1, 2}, "d": b"raw"})
    requests = tuple(json.dumps({"do": action, "body": body}).encode() for action, body in REQUESTS.items())
    found = {
        "cell": Target(of_path(cell), (CELL.read_bytes(),)),
        "cell-page": Target(of_path(lambda path: build_cell_page(read_cell(path))), (CELL.read_bytes(),)),
        "cell-with-arm": Target(cell_with_arm, (arm,)),
        "seams": Target(of_path(seams), (files["seams.json"],)),
        "nominal": Target(of_path(nominal), (matrix, b"[[1,0,0,5],[0,1,0,6],[0,0,1,7],[0,0,0,1]]"), "nominal.json"),
        "packet": Target(packet, (sent,)),
        "jobs": Target(of_path(job_list), (JOBS,), "jobs.csv"),
        "finished-job": Target(finished_job, FINISHED_JOB, "job.json"),
        "picker": Target(request, requests),
    }
    for name, content in files.items():
        for what, then in (("folder", read_folder), ("report", report), ("export", export)):
            found[f"{what}-{name}"] = Target(ResultFolderReader(name, files, then), (content,), "result")
    found["folder-part.glb"] = Target(
        ResultFolderReader("part.glb", with_part, report), (with_part["part.glb"],), "result"
    )
    return found
