"""The main job as one function: STEP and taught points in, calibrated seams out.

The steps: `cad.workpiece.workpiece` reads the part, `cad.workpiece.fit_taught` names and fits the taught points,
`cad.workpiece.seams` finds the seams, and `cad.step.write` writes the moved part. Each step takes and returns plain
values.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cad.workpiece.answer_cache import NO_CACHE, AnswerCache
from cad.workpiece.fit_part import fit_part
from cad.workpiece.fit_taught import CalibrateOptions, name_taught, prepare_fit
from cad.workpiece.means import USUAL_MEANS, Means
from cad.workpiece.step_file import draw_part
from cad.workpiece.workpiece import Openable, Workpiece, open_workpiece
from wpcal.calibrate import CalibrationResult
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import blamed_on
from wpcal.core.input_file import sha256_of_own
from wpcal.core.issue import Issue
from wpcal.core.process import give_memory_back
from wpcal.core.progress import Progress, no_progress
from wpcal.core.records import json_parts, new_directory, to_json
from wpcal.core.result_files import CALIBRATION_FILE, PAGE_FILE, PART_FILE, SEAMS_FILE, TABLE_FILE
from wpcal.core.transform import RigidTransform
from wpcal.core.wording import counted
from wpcal.results.folder import files_of_run
from wpcal.robot.torch.shape import USUAL_TORCH, TorchShape
from wpcal.seam import Seam, SeamOptions
from wpcal.seam.record import seams_csv, seams_record
from wpcal.taught.match import Match, MatchOptions, match_points
from wpcal.taught.programs import names_as_features
from wpcal.taught.table import Taught, TaughtPoints, taught_points
from wpcal.touch.touch_results import SilentRows

if TYPE_CHECKING:
    from cad.workpiece.moved_bodies import MovedWorkpiece
    from wpcal.touch.grasp import Holding

SEAM_RGB = (0.9, 0.2, 0.1)  #: Colour of seams that are written as edges into the moved STEP file (sRGB).


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class WorkpieceCalibration:
    """A calibrated workpiece. Printed, it is a summary; in a notebook, the page with the part in three dimensions."""

    workpiece: Workpiece
    result: CalibrationResult
    candidates: tuple[Seam, ...]  #: All that could be welds, with frames in `part`.
    candidate_u95_mm: tuple[FloatArray, ...]  #: shape (frames,). 95 % error at every frame of each candidate, mm.
    taught: TaughtPoints  #: With the features that were found for points without one.
    found_names: bool = False  #: Whether features were found for points without one.
    #: A decision may join seams whose ends are at most this far from each other, mm.
    join_mm: float = SeamOptions().most_join_mm
    torch: TorchShape = USUAL_TORCH  #: The torch with which reach was judged.
    #: The motions of the bodies, if they were fitted; `candidates` are then those of the moved bodies.
    moved: MovedWorkpiece | None = None

    @property
    def seams(self) -> tuple[Seam, ...]:
        """The accepted seams: what is welded. Frames in `part`."""
        return tuple(seam for seam in self.candidates if seam.accepted)

    @property
    def u95_mm(self) -> tuple[FloatArray, ...]:
        """95 % error at every frame of each accepted seam, mm."""
        pairs = zip(self.candidates, self.candidate_u95_mm, strict=True)
        return tuple(u95 for seam, u95 in pairs if seam.accepted)

    def __repr__(self) -> str:
        """Say verdict, pose and worst seam in a few lines."""
        x, y, z = self.T_base_part.t_mm
        worst_mm = worst_seam_error_mm(self)
        lines = [
            f"{self.result.verdict}: {self.workpiece.size}, {counted(len(self.taught.names), 'point')}",
            f"origin of the part in base: {x:.3f}, {y:.3f}, {z:.3f} mm",
            f"largest residual {self.result.largest_mm:.3f} mm",
            f"{counted(len(self.seams), 'seam')} of {counted(len(self.candidates), 'candidate')}",
        ]
        if worst_mm is not None:
            lines.append(f"worst seam {self.result.judgement.seam}: {worst_mm:.3f} mm with 95 %")
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        """Return the report as a notebook shows it."""
        from wpcal.pages.report import build_report

        source = self.workpiece.source
        part_glb = None if source is None else draw_part(source)[0]
        page = build_report(self.to_record(), self.seams_record(), part_glb)
        return f'<iframe style="width:100%;height:640px;border:0" srcdoc="{escape(page)}"></iframe>'

    @property
    def T_base_part(self) -> RigidTransform:
        """Pose of the real part in the robot's base."""
        return self.result.T_base_part

    def moved_shapes(self) -> list[Any]:
        """Return the part's shapes in `base`, each body where it is; see `cad.workpiece.moved_shapes`."""
        from cad.workpiece.moved_shapes import moved_shapes

        T_part_moved = None if self.moved is None else self.moved.solid_motions(self.workpiece.graph)[0]
        return moved_shapes(self.workpiece, self.T_base_part, T_part_moved)

    def seams_record(self) -> dict[str, Any]:
        """Return the record of ``seams.json``, frames in `base`."""
        notes, space = self.workpiece.member_notes, self.result.pairs.space
        return seams_record(
            self.candidates,
            self.T_base_part,
            self.candidate_u95_mm,
            space=space,
            notes=notes,
            torch=self.torch,
            join_mm=self.join_mm,
            columns=None if self.moved is None else self.moved.columns(),
        )

    def to_record(self, issues: Sequence[Issue] = ()) -> dict[str, Any]:
        """Return the record of ``calibration.json``. `issues` are those found while writing."""
        record = self.result.to_record()
        source = self.workpiece.source
        inputs = {"taught": {"file": Path(self.taught.path).name, "sha256": self.taught.sha256}}
        if source is not None:
            inputs["part"] = {"file": source.file_name, "sha256": source.sha256, "unit": source.unit}
        if self.moved is not None and self.moved.source is not None:
            inputs["bodies"] = asdict(self.moved.source)
        found = [issue.to_record() for issue in (*self.workpiece.issues, *issues)]
        head: dict[str, Any] = {"schema": record.pop("schema"), "inputs": inputs}
        if self.found_names:
            head["features"] = {n: f for n, f in zip(self.taught.names, self.taught.features, strict=True) if f}
        left_out = [n for n, use in zip(self.taught.names, self.taught.use, strict=True) if use == "no"]
        if left_out:
            head["left_out"] = left_out
        if self.moved is not None:
            from cad.workpiece.moved_record import bodies_record

            record["bodies"] = bodies_record(self.moved, self.workpiece.graph)
        return {**head, **record, "issues": [*record["issues"], *found]}


def calibrate_workpiece(
    step: Openable,
    taught: Taught,
    *,
    T_nominal_part: RigidTransform | None = None,
    options: CalibrateOptions | None = None,
    silent: SilentRows | None = None,
    means: Means = USUAL_MEANS,
    progress: Progress = no_progress,
) -> WorkpieceCalibration:
    """Find the pose of a real part, and its weld seams in the robot's base.

    `taught`: Points touched with the robot, in `base`, mm: a file; positions by the names of features; or positions
    alone, shape (n, 3). Features of points without one are found (`wpcal.taught.match.name_points`).

    Raises `InputError` when the part or the points cannot be used.
    Raises `GeometryError` when the points are collinear or too few.
    Raises `UnitError` when the points are in another unit.
    Raises `FormatError` when a file breaks its format or names no feature of the part.
    Raises `KernelError` when the kernel fails.

    >>> from build123d import Box
    >>> touched = {"V1": (450, -30, -10), "V2": (450, -30, 10), "V4": (450, 30, 10), "V8": (550, 30, 10)}
    >>> found = calibrate_workpiece(Box(100, 60, 20), touched)
    >>> [round(v, 6) + 0.0 for v in found.T_base_part.t_mm.tolist()]
    [500.0, 0.0, 0.0]
    """
    options = options or CalibrateOptions()
    given = taught_points(taught)
    workpiece = open_workpiece(step, progress=progress)
    named = name_taught(given, workpiece.features, options=options, T_nominal_part=T_nominal_part, progress=progress)
    observed = prepare_fit(named.taught, workpiece, T_nominal_part=T_nominal_part, silent=silent)
    progress(f"finding seams: {workpiece.size}")
    seams, workpiece = means.find_seams(workpiece, options.seams, options.choice)
    progress(f"fitting {counted(len(named.taught.names), 'point')}, {counted(len(seams), 'seam')}")
    with blamed_on(named.taught.path):
        found = fit_part(workpiece, observed, seams, options, T_nominal_part=T_nominal_part)
    return WorkpieceCalibration(
        workpiece,
        found.result,
        found.seams,
        found.u95_mm,
        named.taught,
        found_names=named.found_names,
        torch=options.seams.reach.torch,
        join_mm=options.seams.most_join_mm,
        moved=found.moved,
    )


@dataclass(frozen=True, slots=True, eq=False)
class WrittenCalibration:
    """What a command shows of a calibration whose files were written."""

    result: CalibrationResult
    seams: tuple[Seam, ...]  #: With frames in `part`.
    u95_mm: tuple[FloatArray, ...]  #: shape (frames,). 95 % error at every frame of each seam, mm.
    record: dict[str, Any]  #: The record of ``calibration.json``.
    files: tuple[str, ...]  #: Names of the files written.
    notes: tuple[Issue, ...] = ()  #: What is odd about the part, and what went wrong with writing.


def worst_seam_error_mm(found: WorkpieceCalibration | WrittenCalibration) -> float | None:
    """Return the largest 95 % error of the seam that the verdict names; None without accepted seams."""
    errors = (
        own for seam, own in zip(found.seams, found.u95_mm, strict=True) if seam.name == found.result.judgement.seam
    )
    return next((float(own.max()) for own in errors), None)


def calibrate_files(
    step: Path | Workpiece,
    taught: Path | TaughtPoints,
    out: Path,
    *,
    overwrite: bool,
    T_nominal_part: RigidTransform | None = None,
    options: CalibrateOptions | None = None,
    mark_seams: bool = False,
    bake: bool = False,
    holding: Holding | None = None,
    searches: dict[str, Any] | None = None,
    run_issues: Sequence[Issue] = (),
    silent: SilentRows | None = None,
    means: Means = USUAL_MEANS,
    cache: AnswerCache = NO_CACHE,
    progress: Progress = no_progress,
) -> WrittenCalibration:
    """Calibrate a STEP file and write the records, the moved STEP file, the part's triangles and the page.

    The files are ``calibration.json``, ``seams.json``, ``seams.csv``, ``PART.calibrated.step``, ``part.glb`` and
    ``report.html``.

    Raises `InputError` as `calibrate_workpiece`, or when the folder cannot be written. Then nothing is written.
    Raises `KernelError` when the kernel fails.
    """
    from wpcal.pages.report import build_report

    workpiece = open_workpiece(step, cache=cache, progress=progress)
    source = workpiece.file
    progress(f"drawing the part: {workpiece.size}")
    part_glb, mesh_issues = draw_part(source)
    found = calibrate_workpiece(
        workpiece, taught, T_nominal_part=T_nominal_part, options=options, silent=silent, means=means, progress=progress
    )
    marked = [(s.name, s.frames.p, SEAM_RGB) for s in found.seams] if mark_seams else []
    with new_directory(out, overwrite=overwrite, head=CALIBRATION_FILE, leave_out=files_of_run(out)) as folder:
        progress("writing the moved part and reading it again")
        moved = f"{Path(source.file_name).stem}.calibrated.step"
        own, apart = (None, ()) if found.moved is None else found.moved.solid_motions(workpiece.graph)
        issues = means.write_moved(
            source, found.T_base_part, folder / moved, seams=marked, bake=bake, T_part_moved=own, progress=progress
        )
        told = () if found.moved is None else (*found.moved.contact_notes(), *found.moved.gap_notes())
        issues = (*apart, *told, *issues)
        if part_glb is not None:
            (folder / PART_FILE).write_bytes(part_glb)
        record = found.to_record((*run_issues, *issues, *mesh_issues))
        if searches is not None:
            record["searches"] = searches
        record["files"] = {file.name: sha256_of_own(file) for file in sorted(folder.iterdir())}
        (folder / CALIBRATION_FILE).write_text(to_json(record), encoding="utf-8")
        give_memory_back()
        seams = found.seams_record()
        with (folder / SEAMS_FILE).open("w", encoding="utf-8") as file:
            file.writelines(json_parts(seams))
        (folder / TABLE_FILE).write_text(seams_csv(seams), encoding="utf-8")
        if means.wants_page(found.result):
            give_memory_back()
            (folder / PAGE_FILE).write_text(build_report(record, seams, part_glb), encoding="utf-8")
        del seams  # of a large part, the largest object here
        if holding is not None:
            from wpcal.touch.grasp import cell_files, solve_grasp

            for name, cell_record in cell_files(holding, solve_grasp(holding, found.T_base_part)).items():
                (folder / name).write_text(to_json(cell_record), encoding="utf-8")
        means.seal(found, folder)
        files = (CALIBRATION_FILE, *sorted(file.name for file in folder.iterdir() if file.name != CALIBRATION_FILE))
    notes = (*run_issues, *found.workpiece.issues, *issues, *mesh_issues)
    return WrittenCalibration(found.result, found.candidates, found.candidate_u95_mm, record, files, notes)


def match_taught(
    step: Path,
    taught: TaughtPoints,
    *,
    options: MatchOptions,
    cache: AnswerCache = NO_CACHE,
    progress: Progress = no_progress,
) -> Match:
    """Find which feature of a STEP file each taught point is."""
    workpiece = open_workpiece(step, cache=cache, progress=progress)
    with blamed_on(taught.path):
        named = names_as_features(taught, workpiece.features)
        return match_points(named, workpiece.features, options, progress=progress)
