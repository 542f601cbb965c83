"""Audit a file or a folder: which kind each file is, and what is wrong with it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from wpcal.brep.material import TriangleMaterial
from wpcal.brep.mesh_glb import read_part_glb
from wpcal.controllers.audit.fault import AuditReport, Fault, FileAudit
from wpcal.controllers.audit.off_line import Track, planned_line
from wpcal.controllers.audit.programs import (
    Surroundings,
    arc_faults_of,
    audit_poses,
    executed,
    executed_faults,
    require_grammar,
    speed_faults,
    speeds_of,
    untimed,
)
from wpcal.controllers.audit.records import audit_record
from wpcal.controllers.audit.tables import audit_table
from wpcal.controllers.audit.touches import checked_near, executed_touch_faults, touch_faults
from wpcal.controllers.audit.two_robots import checked_in_words, swept_faults, two_robot_faults
from wpcal.controllers.judge.execute import interpreted, that_move
from wpcal.controllers.judge.in_cell import CellSweep
from wpcal.controllers.registry import Controller, grammar_of_file
from wpcal.core.errors import FormatError, InputError, WpcalError
from wpcal.core.input_file import read_bytes
from wpcal.core.progress import Progress, no_progress
from wpcal.core.records import parse_json
from wpcal.core.result_files import CALIBRATION_FILE, JOB_FILE, PART_FILE, SEAMS_FILE
from wpcal.core.robot_space import RobotSpace
from wpcal.planning.sequence.kept_plan import PLAN_FILE, PLAN_SCHEMA, read_kept_plan, shown_units
from wpcal.results.agree import changed_files
from wpcal.results.folder import FinishedCalibration, read_finished, read_record
from wpcal.robot.kinematics.urdf import read_urdf
from wpcal.robot.torch.shape import USUAL_TORCH
from wpcal.seam.judge.stations import start_mm

TABLE_SUFFIXES = (".csv", ".tsv", ".txt")
POSES_CHECKED = "poses and user frames; NOT CHECKED: what its instructions do"  #: Of what is not executed.
MOST_LEVELS = 4  #: Folders in folders: the programs of a result folder are one level below it.


def audit_path(path: Path, around: Surroundings | None = None, *, progress: Progress = no_progress) -> AuditReport:
    """Audit a file, or every file of a folder and the folders in it.

    Raises `InputError` when there is no such file, or no file of a kind that wpcal knows.

    `around`: The torch, the tool and the arm of programs. The part and its place come from the result folder that holds
    a program.
    """
    if not path.exists():
        raise InputError(f"{path}: no such file or folder")
    audit = _Audit(around or Surroundings(), path)
    paths = sorted(_files_in(path, MOST_LEVELS)) if path.is_dir() else [path]
    found = []
    for count, one in enumerate(paths, 1):
        progress(f"auditing files: {count} of {len(paths)}")
        found.append((one, audit.file(one)))
    report = AuditReport(
        tuple(file for _, file in found if file is not None), tuple(str(one) for one, file in found if file is None)
    )
    if not report.files:
        what = "holds no file" if path.is_dir() else "is not a file"
        raise InputError(f"{path}: {what} of a kind that wpcal reads or writes; nothing is audited")
    return report


def _files_in(folder: Path, levels: int) -> Iterator[Path]:
    try:
        entries = sorted(folder.iterdir())
    except OSError as error:
        raise InputError(f"{folder}: {(error.strerror or str(error)).lower()}") from None
    for path in entries:
        if path.name.startswith("."):
            continue
        if path.is_dir() and not path.is_symlink():
            if levels:
                yield from _files_in(path, levels - 1)
        else:
            yield path


def _result_folder_of(folder: Path) -> Path | None:
    """Return the folder of the result or the plan in which a folder is, or that it is itself."""
    marks = (CALIBRATION_FILE, PLAN_FILE)
    found = (one for one in (folder, *folder.absolute().parents[:2]) if any((one / mark).is_file() for mark in marks))
    return next(found, None)


class _Audit:
    """Audits files one by one, and reads each result folder once."""

    def __init__(self, around: Surroundings, root: Path) -> None:
        self.around, self.root, self.is_named = around, root, not root.is_dir()
        self.of_folder: dict[Path, Surroundings] = {}
        self.refused: dict[Path, Fault] = {}
        self.of_programs: dict[tuple[Path, str], tuple[str, dict[str, list[Fault]]]] = {}
        self.in_step: dict[tuple[Path, str], list[tuple[str, Fault]] | None] = {}

    def file(self, path: Path) -> FileAudit | None:
        """Audit one file; None for a kind that wpcal does not know."""
        try:
            found = self._found(path)
        except WpcalError as error:
            found = FileAudit(str(path), path.suffix[1:].lower() or "file", (Fault.of(error, str(path)),))
        return found

    def _found(self, path: Path) -> FileAudit | None:
        suffix = path.suffix.lower()
        if suffix == ".json":
            found = self._record(path)
        elif suffix in TABLE_SUFFIXES:
            found = audit_table(read_bytes(path), path, is_named=self.is_named)
        elif path.name == PART_FILE:
            read_part_glb(read_bytes(path), path=str(path))
            found = "triangles of the part", []
        elif suffix == ".urdf":
            read_urdf(path)
            found = "robot description", []
        else:
            return self._program(path) if grammar_of_file(path) is not None else None
        return None if found is None else FileAudit(str(path), found[0], tuple(found[1]))

    def _record(self, path: Path) -> tuple[str, list[Fault]] | None:
        """Return the kind and the faults of a record; of a sound one of a result, those of its folder."""
        record = audit_record(read_bytes(path), path)
        if record is None or record[1] or path.name not in (CALIBRATION_FILE, JOB_FILE):
            return record
        return record[0], (_faults_of_folder if path.name == CALIBRATION_FILE else _changed_files)(path.parent)

    def _program(self, path: Path) -> FileAudit:
        """Audit a program; of a file whose poses are in another, only the arc instructions."""
        raw, suffix, grammar = read_bytes(path), path.suffix.lower(), require_grammar(path)
        if grammar.is_in_step(raw, path):
            return self._two_robots(raw, path)
        if grammar.is_touch_program(raw, path):
            faults = touch_faults(raw, path) or self._touches_of(path).get(path.name, [])
            return FileAudit(str(path), f"touch program ({suffix})", tuple(faults), checked_near(path))
        result = _result_folder_of(path.parent)
        around = self._with_part(result)
        stated = around if around.lines is None else replace(around, part=None)  # poses are executed
        faults = audit_poses(raw, path, stated) if grammar.has_poses(path) else []
        checked, executed = POSES_CHECKED, None if faults else self._executed(path, around)
        if executed is not None:
            left, found = executed
            checked, faults = str(replace(around, untimed=left)), found.get(path.name, [])
        if result in self.refused and self.root.absolute() not in (result.absolute(), *result.absolute().parents):
            faults = [*faults, self.refused[result]]
        return FileAudit(str(path), f"program ({suffix})", tuple(faults), checked)

    def _two_robots(self, raw: bytes, path: Path) -> FileAudit:
        controller = interpreted(path)
        files = {path.name: raw} if controller is None else _files_beside(path, controller, in_step=True)
        faults, left = two_robot_faults(files, path, self.around.arc_output)
        swept = None if faults else self._in_step(path)
        faults += [fault for file, fault in swept or () if file == path.name]
        kind = f"program of two robots ({path.suffix.lower()})"
        return FileAudit(str(path), kind, tuple(faults), checked_in_words(left, is_swept=swept is not None))

    def _executed(self, path: Path, around: Surroundings) -> tuple[str, dict[str, list[Fault]]] | None:
        """Return which speeds are not compared, and faults by files of what is executed; None if nothing can be."""
        if (controller := interpreted(path)) is None:
            return None
        key = path.parent, controller.name
        if key not in self.of_programs:
            files = _files_beside(path, controller)
            files = {
                name: data
                for name, data in files.items()
                if not require_grammar(path).is_touch_program(data, path.parent / name)
            }
            if around.in_cell is not None and not controller.coordinates_arcs:
                around = replace(around, in_cell=replace(around.in_cell, is_carried=False))
            trace, found = executed(files, around)
            if around.lines is None:  # of others: they may be right for a controller that has more than is known here
                found.clear()
            else:
                _add(found, executed_faults(trace, around))
                idle = that_move(trace.idle, files)
                _add(found, ((place.file, Fault("NOT CHECKED: the line never runs", place.line)) for place in idle))
            _add(found, arc_faults_of(trace))
            _add(found, speed_faults(trace, stated := speeds_of(files)))
            self.of_programs[key] = untimed(trace, stated), found
        return self.of_programs[key]

    def _in_step(self, path: Path) -> list[tuple[str, Fault]] | None:
        """Return the files and faults that show when the programs of two robots beside a file are swept together."""
        if (controller := interpreted(path)) is None:
            return None
        key = path.parent, controller.name
        if key not in self.in_step:
            self.in_step[key] = swept_faults(path.parent, _files_beside(path, controller, in_step=True))
        return self.in_step[key]

    def _touches_of(self, path: Path) -> dict[str, list[Fault]]:
        """Return the faults that show when the touch programs beside a file are executed."""
        found = dict[str, list[Fault]]()
        if (controller := interpreted(path)) is not None:
            files, grammar = _files_beside(path, controller), require_grammar(path)
            stems = [Path(name).stem for name in files if grammar.is_touch_program(files[name], path.parent / name)]
            own = [name for name in files if any(Path(name).stem.startswith(stem) for stem in stems)]
            _add(found, executed_touch_faults(files, own, path))
        return found

    def _with_part(self, result: Path | None) -> Surroundings:
        """Add the part as calibrated; without it if the files of the result folder have faults."""
        if result is None or self.around.part is not None:
            return self.around
        if result not in self.of_folder:
            try:
                self.of_folder[result] = self._of(result)
            except WpcalError as error:
                self.of_folder[result], self.refused[result] = self.around, _fault_of_result(result, error)
        return self.of_folder[result]

    def _of(self, result: Path) -> Surroundings:
        if not (result / CALIBRATION_FILE).is_file():
            return self._of_plan(result)
        finished = _finished(result)
        start = max((start_mm(seam) for seam in finished.seams), default=self.around.start_mm)
        part = None
        is_corrected = RobotSpace.parse(finished.calibration["robot_space"]) is RobotSpace.IDENTIFIED
        if finished.part_glb is not None and not is_corrected:  # corrected targets are not where the torch will be
            part = TriangleMaterial.of(read_part_glb(finished.part_glb), finished.T_base_part)
        seams = () if is_corrected else finished.seams
        lines = tuple(Track.dense(each.name, each.frames.p, each.frames.R, back_mm=each.more_wire_mm) for each in seams)
        torch = self.around.torch if self.around.torch != USUAL_TORCH else finished.torch or USUAL_TORCH
        return replace(
            self.around, torch=torch, T_base_part=finished.T_base_part, part=part, start_mm=start, lines=lines
        )

    def _of_plan(self, folder: Path) -> Surroundings:
        """Add the cell of a plan with one robot."""
        if parse_json(read_bytes(folder / PLAN_FILE), path=str(folder / PLAN_FILE)).get("schema") != PLAN_SCHEMA:
            return self.around
        kept = read_kept_plan(folder)
        cell, given = kept.cell, kept.given
        states = [np.array(each).reshape(-1, len(cell.home)) / shown_units(cell) for each in kept.record["kept"]["air"]]
        along = [
            np.array(piece["states"][piece["before"] : -piece["after"] or None]) / shown_units(cell)
            for piece in kept.record["kept"]["pieces"]
        ]
        more_mm = max((each.seam.more_wire_mm for each in given.seams), default=0.0)
        in_cell = CellSweep.of(cell, given.part, states, along, more_mm)
        T_base_part, _ = given.in_base(cell)
        rows = zip(kept.record["seams"], along, strict=True)
        lines = tuple(planned_line(each["seam"], cell, q) for each, q in rows)
        return replace(self.around, T_base_part=T_base_part, in_cell=in_cell, lines=lines)


def _files_beside(path: Path, controller: Controller, *, in_step: bool = False) -> dict[str, bytes]:
    """Return the programs of one language in the folder of a file: those of one robot, or of two."""
    return {
        each.name: data
        for each in sorted(path.parent.iterdir())
        if each.suffix.lower() in controller.program_suffixes and each.is_file()
        if require_grammar(path).is_in_step(data := read_bytes(each), each) == in_step
    }


def _add(found: dict[str, list[Fault]], faults: Iterable[tuple[str, Fault]]) -> None:
    for name, fault in faults:
        found.setdefault(name, []).append(fault)


def _finished(folder: Path, *, is_compared: bool = True) -> FinishedCalibration:
    space = RobotSpace.parse(read_record(folder, SEAMS_FILE)["robot_space"])
    return read_finished(folder, space=space, is_compared=is_compared)


def _changed_files(folder: Path) -> list[Fault]:
    return [Fault(str(each), field=each.name) for each in changed_files(folder)]


def _faults_of_folder(folder: Path) -> list[Fault]:
    """Return what does not agree among the files of a result folder; changed ones are faults of ``job.json``."""
    if not (folder / SEAMS_FILE).is_file():
        return []
    try:
        _finished(folder, is_compared=not (folder / JOB_FILE).is_file())
    except WpcalError as error:
        return [_fault_of_result(folder, error)]
    return []


def _fault_of_result(folder: Path, error: WpcalError) -> Fault:
    path = error.path if isinstance(error, FormatError) and error.path else str(folder / SEAMS_FILE)
    return replace(Fault.of(error, path), field=Path(path).name)
