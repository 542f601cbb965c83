"""A request to calibrate a part: its options as one value, read from words (a command, a row of a batch) or from JSON.

The command line, batches, `wpcal verify` and `wpcal rpc` all ask with it; `calibrate_arguments` is what it means.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import click
import numpy as np
from click.core import ParameterSource

from cad.batch.bodies_asked import BodiesAsked
from cad.batch.seams_asked import SeamsAsked
from cad.workpiece.fit_taught import CalibrateOptions
from wpcal.calibrate.trust.criteria import Criterion
from wpcal.cli.option_groups import command, group_of, takes
from wpcal.controllers.taught_program import PointsAsked
from wpcal.controllers.touch_run import TouchRun, read_touch_run
from wpcal.core.errors import FormatError, InputError
from wpcal.core.input_file import holds_file, read_bytes
from wpcal.core.numbers import parse_numbers
from wpcal.core.options import group, opt
from wpcal.core.records import check_writable, parse_json
from wpcal.core.transform import RigidTransform
from wpcal.touch.grasp import Holding, read_holding

NOT_OF_A_JOB = frozenset({"out", "force", "details", "json", "no_cache", "help"})
"""Options of the command that are about one folder, the terminal, or the whole batch."""


def read_pose(text: str) -> RigidTransform:
    """Read ``T_nominal_part``: six numbers x,y,z,a,b,c (mm and degrees, R = Rz(c) Ry(b) Rx(a)) or a JSON file.

    Raises `InputError` if it is neither. The JSON file holds a 4×4 matrix, by itself or under the key
    ``T_nominal_part``.
    """
    if text.count(",") == 5:
        try:
            numbers = parse_numbers(text)
        except InputError as error:
            raise InputError(f"--nominal: {error}") from None
        six = np.array([*numbers[:3], *np.radians(numbers[3:])])
        return RigidTransform.from_six_tuple(six, target="nominal", source="part")
    path = Path(text)
    if not holds_file(path.parent, path.name):
        raise InputError(f"--nominal: expected x,y,z,a,b,c in mm and degrees or a JSON file, got {text!r}")
    try:
        record = parse_json(read_bytes(path), path=str(path))
    except FormatError as error:
        raise InputError(f"--nominal: {path}: {error.what}") from None
    matrix: Any = record.get("T_nominal_part") if isinstance(record, dict) else record
    try:
        return RigidTransform.from_matrix(matrix, target="nominal", source="part")
    except InputError as error:
        raise InputError(f"--nominal: {path}: {error}") from None


@dataclass(frozen=True, slots=True, kw_only=True)
class NominalAsked:
    """Where the part is in the model of the cell."""

    nominal: RigidTransform | None = opt(
        None,
        "Place of the part in the cell's model: x,y,z,a,b,c in mm and degrees with R = Rz(c) Ry(b) Rx(a), or a JSON "
        "file with a 4×4 matrix.",
        metavar="POSE",
        read=read_pose,
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class TouchesAsked:
    """How the results of a touch program are read."""

    touches: Path | None = opt(
        None,
        "The plan (touches.json) whose program the robot ran. TAUGHT is then what the controller stored.",
        metavar="FILE",
    )
    setup: Path | None = opt(
        None, "For a plan of touches: signal, speeds and names of the cell (TOML), as for its program.", metavar="FILE"
    )

    def read(self, part: Path, taught: Path, fit: CalibrateOptions, reading: PointsAsked) -> TouchRun | None:
        """Read the plan and the results; None without --touches.

        Raises `InputError` when they cannot be used, or an option does not go with them.
        """
        if self.touches is None:
            if self.setup is not None:
                raise InputError("--setup is for results of a touch program; give its plan with --touches")
            return None
        if reading.given:
            raise InputError(f"{', '.join(reading.given)} cannot be used with --touches")
        if fit.ball_mm:
            raise InputError("--ball-mm cannot be used with --touches: the plan says what meets each face")
        return read_touch_run(self.touches, taught, self.setup, part=part.name)


@dataclass(frozen=True, slots=True, kw_only=True)
class HolderAsked:
    """The cell and the joints at which robot 2 held the part."""

    cell: Path | None = opt(
        None,
        "The cell: of two robots, for --holder-joints; cell.json with the part in the gripper is written.",
        metavar="CELL.json",
    )
    holder_joints: str | None = opt(None, "Shown angles of robot 2 while it held the part, deg.", metavar="Q1,…,Q6")

    def read(self) -> Holding | None:
        """Read the cell and the joints of robot 2 if both are given.

        Raises `InputError` if only one of them is given, or one cannot be used.
        """
        if (self.cell is None) != (self.holder_joints is None):
            raise InputError("--cell and --holder-joints belong together: where robot 2 is and how it held the part")
        if self.cell is None or self.holder_joints is None:
            return None
        return read_holding(self.cell, self.holder_joints)


@dataclass(frozen=True, slots=True, kw_only=True)
class OutputAsked:
    """How the results are written."""

    mark_seams: bool = opt(False, "Write the seams as named edges into the moved STEP file.")
    bake: bool = opt(False, "Move the geometry itself in the STEP file: no new assembly level.")
    force: bool = opt(False, "Replace what exists: the files of this command in the folder.")
    accept_unsure: bool = opt(False, "End with code 0 if the verdict is UNSURE.")
    details: bool = opt(False, "Also print the objective, its lower bound and the gap, and the correction in radians.")
    as_json: bool = opt(False, "Print JSON on stdout: calibration.json.", "--json")


@dataclass(frozen=True, slots=True, kw_only=True)
class Request:
    """All options of a calibration."""

    touching: TouchesAsked = group(TouchesAsked)
    fitting: CalibrateOptions = group(CalibrateOptions)
    place: NominalAsked = group(NominalAsked)
    moving: BodiesAsked = group(BodiesAsked)
    holder: HolderAsked = group(HolderAsked)
    reading: PointsAsked = group(PointsAsked)
    choice: SeamsAsked = group(SeamsAsked)
    output: OutputAsked = group(OutputAsked)

    def options(self, run: TouchRun | None) -> tuple[CalibrateOptions, RigidTransform | None]:
        """Return the options, and ``T_nominal_part`` if it is known.

        Raises `InputError` when an option cannot be used, or not with another.
        """
        found = replace(self.fitting, choice=self.choice.to_choice(), bodies=self.moving.to_options())
        if found.bodies is not None:
            _refuse_rigid_only(found)
        if run is None:
            return found, self.place.nominal
        return found, self.place.nominal or run.T_nominal_part


def _refuse_rigid_only(options: CalibrateOptions) -> None:
    """Refuse what only a part that moved in one piece has."""
    if options.certify:
        raise InputError("--certify cannot be used with --bodies: what it proves holds for a rigid part")
    if options.rigid:
        raise InputError("--rigid cannot be used with --bodies: there no seam follows the robot's own error")
    if options.criterion not in (None, Criterion.WEIGHTED):
        raise InputError(
            f"--criterion {options.criterion.value} cannot be used with --bodies: bodies are fitted by weighted squares"
        )


def calibrate_arguments(asked: Request, *, part: Path, taught: Path, out: Path) -> dict[str, Any]:
    """Read what the options name, and return the arguments of `calibrate_files` except `step`.

    Raises `InputError` when an option or one of its files cannot be used, or the results cannot be written to `out`.
    """
    run = asked.touching.read(part, taught, asked.fitting, asked.reading)
    options, nominal = asked.options(run)
    holding = asked.holder.read()
    check_writable(out, overwrite=asked.output.force)
    return {
        "taught": asked.reading.read_taught(taught) if run is None else run.taught,
        **run_arguments(run),
        "out": out,
        "overwrite": asked.output.force,
        "T_nominal_part": nominal,
        "options": options,
        "mark_seams": asked.output.mark_seams,
        "bake": asked.output.bake,
        "holding": holding,
    }


def run_arguments(run: TouchRun | None) -> dict[str, Any]:
    """Return the arguments of `cad.workpiece.calibrate.calibrate_files` about a run of a touch program."""
    return {
        "searches": None if run is None else run.record,
        "run_issues": () if run is None else run.issues,
        "silent": None if run is None else run.silent,
    }


@cache
def request_command() -> click.Command:
    """Return a command that only reads the options of a request."""

    def read(**_: Any) -> None:
        raise AssertionError("a request is read, not run")

    found: click.Command = command(name="calibrate")(takes("asked", Request)(read))
    return found


@contextmanager
def read_words(words: Sequence[str]) -> Iterator[tuple[Request, click.Context]]:
    """Yield the request of some words, as the command line reads them; files are read while the block runs.

    Raises `InputError` when click refuses one of them.
    """
    try:
        with request_command().make_context("calibrate", list(words)) as context:
            yield group_of(Request, context.params), context
    except click.ClickException as error:
        raise InputError(error.format_message()) from None


def request_options() -> Mapping[str, click.Option]:
    """Return the options that a row of a batch may hold, by the names of their columns."""
    found = [each for each in request_command().params if isinstance(each, click.Option)]
    return {
        max(each.opts, key=len).removeprefix("--").replace("-", "_"): each
        for each in found
        if each.name not in NOT_OF_A_JOB
    }


def given_words(context: click.Context) -> tuple[str, ...]:
    """Return the options that were given, in the order of the help, as the list of a batch has them."""
    words: list[str] = []
    for option in request_options().values():
        name = option.name or ""
        if context.get_parameter_source(name) is ParameterSource.DEFAULT:
            continue
        flag, value = max(option.opts, key=len), context.params[name]
        if option.is_flag:
            words += [flag] if value else []
        elif isinstance(option.flag_value, str) and value == option.flag_value:  # typed without a value
            words.append(flag)
        else:
            words += [f"{flag}={each}" for each in (value if option.multiple else (value,))]
    return tuple(words)
