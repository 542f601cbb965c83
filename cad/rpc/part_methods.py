"""The methods about an opened part: what is on it, what was touched, and where it is."""

from __future__ import annotations

import shlex
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from cad.batch.recorded import recording
from cad.batch.request import Request, TouchesAsked, run_arguments
from cad.batch.seams_asked import SeamsAsked
from cad.rpc.open_parts import OpenPart
from cad.rpc.options import OptionSet, words_of
from cad.session.decisions import read_decisions
from cad.session.rows import Rows, read_rows
from cad.session.session import place_points
from cad.workpiece.calibrate import WorkpieceCalibration, calibrate_files, calibrate_workpiece
from cad.workpiece.fit_taught import CalibrateOptions
from cad.workpiece.means import Means
from cad.workpiece.seams import SeamChoice
from wpcal.cli.option_groups import option_names
from wpcal.controllers.taught_program import PointsAsked
from wpcal.controllers.touch_run import TouchRun
from wpcal.controllers.user_frames import ProgramReading
from wpcal.core.errors import InputError
from wpcal.core.input_file import noted_files, read_bytes
from wpcal.core.progress import Progress
from wpcal.core.records import check_writable, write_file
from wpcal.core.result_files import SEAMS_FILE
from wpcal.core.transform import RigidTransform
from wpcal.pages.report import seam_columns
from wpcal.results.next_steps import next_steps
from wpcal.seam.record import seams_record
from wpcal.taught.features import features_record
from wpcal.taught.table import TaughtPoints, taught_csv
from wpcal.taught.table import read_taught as read_table

DECISIONS = "decisions"  #: Name of the decisions in messages.
PART_OPTIONS = OptionSet(Request, without=("details", "json", "accept_unsure", "touches", "setup"))
"""Those of `wpcal calibrate`: every method about a part takes all of them, and uses those that concern it."""
PROGRAM_NAMES = tuple(option_names(PointsAsked))
PartMethod = Callable[[OpenPart, Mapping[str, Any], Progress], dict[str, Any]]


def open_part(part: OpenPart, _: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Return what is on a part."""
    workpiece = part.workpiece
    progress(f"judging {len(workpiece.features)} features")
    ease = {item.feature.name: item.ease.word for item in part.touchables}
    record = features_record([item.feature for item in part.touchables], ease, workpiece.issues)
    return {
        "path": str(part.path),
        "unit": workpiece.file.unit,
        "size": workpiece.size,
        "solids": list(workpiece.graph.solid_names),
        "features": record["features"],
        "notes": [issue.message for issue in workpiece.issues],
    }


def seams(part: OpenPart, params: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Return the seams of a part in its own frame."""
    request = _request(params)
    options, choice = request.fitting.seams, _choice(request.choice, params)
    progress(f"finding seams: {part.workpiece.size}")
    found, workpiece = part.seams(options, choice)
    torch, notes = options.reach.torch, workpiece.member_notes
    record = seams_record(found, notes=notes, join_mm=options.most_join_mm, torch=torch)
    return {
        **{key: record[key] for key in ("frame", "judging", "members", "join_mm", "torch") if key in record},
        "seams": _with_columns(record["seams"]),
        "notes": [issue.message for issue in workpiece.issues],
    }


def _request(params: Mapping[str, Any]) -> Request:
    found: Request = PART_OPTIONS.read(params.get("options", {}))
    return found


def _with_columns(records: list[dict[str, Any]]) -> list[dict[str, Any]]:
    columns = seam_columns([seam["frames"] for seam in records])
    return [{**seam, "frames": own} for seam, own in zip(records, columns, strict=True)]


def _choice(flags: SeamsAsked, params: Mapping[str, Any]) -> SeamChoice:
    """Return the decisions of the request after those of a file."""
    choice = flags.to_choice()
    edits = read_decisions(params.get("decisions", []), path=DECISIONS)
    return replace(choice, edits=(*choice.edits, *edits))


def read_taught(part: OpenPart, params: Mapping[str, Any], _: Progress) -> dict[str, Any]:
    """Return the rows of a table, a program, or the results of a touch program."""
    request, path = _request(params), Path(params["path"])
    if "touches" in params:
        run = _touch_run(part, params, request)
        rows = read_rows(taught_csv(run.taught).encode("utf-8"), path=str(path))
        return {**rows.to_record(), "left_out": [], "notes": [issue.message for issue in run.issues]}
    raw = params["text"].encode("utf-8") if "text" in params else read_bytes(path)
    rows, left_out = part.reader(request.reading.to_reading()).read(raw, name=str(path))
    return {**rows.to_record(), "left_out": list(left_out), "notes": []}


@dataclass(frozen=True, slots=True, eq=False)
class Asked:
    """What a request wants to be calibrated."""

    options: CalibrateOptions
    nominal: RigidTransform | None
    taught: TaughtPoints
    rows: Rows | None  #: The rows of the request; None if it names a file.
    run: TouchRun | None

    @property
    def row_of(self) -> dict[str, int]:
        """The row of every point, by its name."""
        numbers = range(len(self.taught.names)) if self.rows is None else self.rows.complete()
        return dict(zip(self.taught.names, numbers, strict=True))


def _asked(part: OpenPart, request: Request, params: Mapping[str, Any]) -> Asked:
    given = params["taught"]
    rows = None if "path" in given else _rows(given)
    run = _touch_run(part, given, request) if "touches" in given else None
    options, nominal = request.options(run)
    options = replace(options, choice=_choice(request.choice, params))
    if rows is not None:
        return Asked(options, nominal, rows.to_taught(), rows, None)
    taught = request.reading.read_taught(Path(given["path"])) if run is None else run.taught
    return Asked(options, nominal, taught, None, run)


def _rows(given: Mapping[str, Any]) -> Rows:
    if {"columns", "rows"} - set(given):
        raise InputError("taught: expected columns and rows, or the path of a file")
    return Rows.from_record(given)


def _touch_run(part: OpenPart, given: Mapping[str, Any], request: Request) -> TouchRun:
    """Read what a touch program stored, with the plan and the setup of the request."""
    asked = TouchesAsked(touches=Path(given["touches"]), setup=Path(given["setup"]) if given.get("setup") else None)
    run = asked.read(part.path, Path(given["path"]), request.fitting, request.reading)
    assert run is not None  # `touches` is given
    return run


def calibrate(part: OpenPart, params: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Fit the part to taught rows; nothing is written."""
    asked = _asked(part, _request(params), params)
    found = calibrate_workpiece(
        part.workpiece,
        asked.taught,
        T_nominal_part=asked.nominal,
        options=asked.options,
        silent=None if asked.run is None else asked.run.silent,
        means=Means(find_seams=lambda _, options, choice: part.seams(options, choice)),
        progress=progress,
    )
    record = found.to_record(() if asked.run is None else asked.run.issues)
    points = [dict(point) for point in record["points"]]
    place_points(points, asked.row_of, found.T_base_part)
    return {
        "record": record,
        "T_base_part": found.T_base_part.matrix.tolist(),
        "points": points,
        "features": _features(asked, found),
        "u95_mm": [
            {
                "seam": seam.name,
                "accepted": seam.accepted,
                "max_mm": float(np.max(errors)) if len(errors) else None,
                "frames_mm": np.round(errors, 6).tolist(),
            }
            for seam, errors in zip(found.candidates, found.candidate_u95_mm, strict=True)
        ],
        "seams": _with_columns(found.seams_record()["seams"]) if params.get("frames") else None,
        "notes": [issue["message"] for issue in record["issues"]],
        "steps": next_steps(record),
    }


def _features(asked: Asked, found: WorkpieceCalibration) -> dict[str, str]:
    """Return the feature of every row, found or given, by the number of the row."""
    row_of = asked.row_of
    return {
        str(row_of[name]): feature
        for name, feature in zip(found.taught.names, found.taught.features, strict=True)
        if feature
    }


def suggest(part: OpenPart, params: Mapping[str, Any], _: Progress) -> dict[str, Any]:
    """Return the features to touch next."""
    request = _request(params)
    options = replace(request.fitting, choice=_choice(request.choice, params))
    return part.session(options, request.moving).suggest(_rows(params["taught"]))


def touch_at(part: OpenPart, params: Mapping[str, Any], _: Progress) -> dict[str, Any]:
    """Return what a click on the part touches."""
    point, normal = (np.array(params[name], dtype=np.float64) for name in ("p_mm", "normal"))
    return part.reader(ProgramReading()).touch(point, normal)


def save(part: OpenPart, params: Mapping[str, Any], progress: Progress) -> dict[str, Any]:
    """Write the result folder of a calibration, as `wpcal calibrate` does."""
    with noted_files() as read:
        request = _request(params)
        asked, output, out = _asked(part, request, params), request.output, Path(params["out"])
        holding, taught = request.holder.read(), asked.taught
    check_writable(out, overwrite=output.force)
    if asked.rows is not None:
        taught = _write_table(asked.rows, params.get("table"), overwrite=output.force)
    words, table = _words(params, has_rows=asked.rows is not None), _table(params, has_rows=asked.rows is not None)
    if params.get("decisions"):  # those of a file are with them in the seams.json that is written
        read.pop(str(request.choice.seams_file), None)
        read[str(out / SEAMS_FILE)] = ""
    means = recording(words, part.path, Path(table), taught.sha256 or "", read)
    written = calibrate_files(
        part.workpiece,
        taught,
        out,
        overwrite=output.force,
        means=means,
        T_nominal_part=asked.nominal,
        options=asked.options,
        mark_seams=output.mark_seams,
        bake=output.bake,
        holding=holding,
        **run_arguments(asked.run),
        progress=progress,
    )
    return {
        "record": written.record,
        "files": [str(out / file) for file in written.files],
        "notes": [issue.message for issue in written.notes],
        "command": shlex.join(["wpcal", "calibrate", str(part.path), table, *words, "-o", params["out"]]),
    }


def _write_table(rows: Rows, table: str | None, *, overwrite: bool) -> TaughtPoints:
    """Write the rows that are complete as a table, and read it again as `wpcal calibrate` does."""
    if table is None:
        raise InputError("table: expected the file in which the rows are written before they are calibrated")
    path, text = Path(table), rows.to_csv()
    if not (path.is_file() and path.read_bytes() == text.encode("utf-8")):
        write_file(path, text, overwrite=overwrite)
    return read_table(path)


def _words(params: Mapping[str, Any], *, has_rows: bool) -> list[str]:
    """Return the options of the command that writes the same; decisions are in the seams.json that was written."""
    values = {key: value for key, value in params.get("options", {}).items() if not (has_rows and key in PROGRAM_NAMES)}
    words = words_of(PART_OPTIONS.options, values)
    words += ["--touches", params["taught"]["touches"]] if "touches" in params["taught"] else []
    words += ["--setup", params["taught"]["setup"]] if params["taught"].get("setup") else []
    return words + (["--seams", str(Path(params["out"]) / SEAMS_FILE)] if params.get("decisions") else [])


def _table(params: Mapping[str, Any], *, has_rows: bool) -> str:
    found: str = params["table"] if has_rows else params["taught"]["path"]
    return found


METHODS: Mapping[str, PartMethod] = {
    "open": open_part,
    "seams": seams,
    "read_taught": read_taught,
    "calibrate": calibrate,
    "suggest": suggest,
    "touch_at": touch_at,
    "save": save,
}
