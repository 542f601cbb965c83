"""Options that several commands share."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from cad.workpiece.fit_taught import CalibrateOptions
    from cad.workpiece.seams import SeamChoice
    from wpcal.core.transform import RigidTransform
    from wpcal.seam import SeamOptions

POINT_LETTERS = ("V", "C", "H", "S", "M", "B", "E")
"""`FeatureKind` values of `POINT_KINDS`; written out so that the help needs no NumPy."""
KIND_LETTERS = (*POINT_LETTERS, "L", "X", "P", "A")
"""All `FeatureKind` values."""

Command = TypeVar("Command", bound=Callable[..., Any])


def seam_options(command: Command) -> Command:
    """Add the options by which seams are found and cut into frames."""
    for option in (
        click.option("--chord-mm", type=float, default=0.1, show_default=True, help="Largest chord error."),
        click.option("--min-step-mm", type=float, default=1.0, show_default=True, help="Thin points nearer than this."),
        click.option("--max-step-mm", type=float, default=10.0, show_default=True, help="Largest step along a seam."),
        click.option(
            "--turn-deg", type=float, default=45.0, show_default=True, help="Largest turn of the frame between points."
        ),
        click.option("--gap-mm", type=float, help="Largest gap between members.  [default: by part size, at most 0.5]"),
        click.option(
            "--concave",
            type=click.Choice(["always", "never", "auto"]),
            default="auto",
            show_default=True,
            help="Take concave edges inside one solid as seams; auto: of solids that touch no other and do not look "
            "machined.",
        ),
        click.option("--split-deg", type=float, default=30.0, show_default=True, help="A sharper turn ends a seam."),
    ):
        command = option(command)
    return command


def fit_options(command: Command) -> Command:
    """Add the options by which taught points are fitted and judged."""
    for option in reversed(
        (
            click.option(
                "--tolerance-mm", type=float, default=0.5, show_default=True, help="A larger residual ends with code 1."
            ),
            click.option(
                "--criterion",
                type=click.Choice(["minimax", "least_squares", "weighted", "robust"]),
                default="minimax",
                show_default=True,
            ),
            click.option("--solver", type=click.Choice(["annealing", "exact"]), default="annealing", show_default=True),
            click.option(
                "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Of every random number."
            ),
            click.option(
                "--nominal",
                metavar="POSE",
                help="Where the cell's model has the part: x,y,z,a,b,c in mm and degrees with R = Rz(c) Ry(b) Rx(a), "
                "or a JSON file with a 4×4 matrix.",
            ),
            click.option("--sigma-mm", type=float, help="Teaching error: standard deviation per axis."),
            click.option("--bound-mm", type=float, help="Teaching error: greatest error per axis."),
            click.option(
                "--tcp-bias-mm", type=float, default=0.0, show_default=True, help="Error of the tool centre point."
            ),
            click.option(
                "--ball-mm", type=float, default=0.0, show_default=True, help="Radius of the ball in touches on faces."
            ),
            click.option("--certify", is_flag=True, help="Close a gap by branch and bound over all rotations (slow)."),
        )
    ):
        command = option(command)
    return command


def marked_options(command: Command) -> Command:
    """Add ``--marked`` and ``--edge``, by which a person says which edges are the seams."""
    for option in (
        click.option(
            "--edge",
            "edges",
            metavar="PLACE",
            multiple=True,
            help="The edge at x,y,z (part frame, mm) or at a feature (M12) is a seam, and with --marked no other is.",
        ),
        click.option(
            "--marked",
            metavar="PATTERN",
            multiple=True,
            help="Edges and wires of this name or layer (* and ? stand for any letters) or colour (#rrggbb) are the "
            "seams, and no other is.",
        ),
    ):
        command = option(command)
    return command


def seam_choice_options(command: Command) -> Command:
    """Add the options by which a person says what the seams are: `marked_options`, and edits of those found."""
    edits = click.option(
        "--seams",
        "seams_file",
        metavar="FILE",
        type=click.Path(path_type=Path),
        help="A seams.json of this part in which seams have an object edit: accept, reject, reverse, name, range_mm.",
    )
    return edits(marked_options(command))


def to_calibrate_options(values: dict[str, Any]) -> tuple[CalibrateOptions, RigidTransform | None]:
    """Take the values of `fit_options` and `seam_options` out of a command's arguments; with ``T_nominal_part``."""
    from cad.workpiece.fit_taught import CalibrateOptions
    from wpcal.calibrate import Criterion, Solver, TeachingError

    seams = to_seam_options(values)
    options = CalibrateOptions(
        criterion=Criterion(values.pop("criterion")),
        solver=Solver(values.pop("solver")),
        seed=values.pop("seed"),
        tolerance_mm=values.pop("tolerance_mm"),
        teaching=TeachingError(**{name: values.pop(name) for name in ("sigma_mm", "bound_mm", "tcp_bias_mm")}),
        seams=seams,
        certify=values.pop("certify"),
        ball_mm=values.pop("ball_mm"),
        choice=to_seam_choice(values),
    )
    nominal = values.pop("nominal")
    return options, None if nominal is None else read_pose(nominal)


def to_seam_options(values: dict[str, Any]) -> SeamOptions:
    """Take the values of `seam_options` out of a command's arguments."""
    import math

    from wpcal.core.errors import InputError
    from wpcal.seam import ConcaveEdges, SeamOptions, StepOptions

    turn_deg = values.pop("turn_deg")
    if not 0 < turn_deg <= 180:
        raise InputError(f"--turn-deg must be above 0 and at most 180, got {turn_deg}")
    chord_mm, min_step_mm, max_step_mm = (values.pop(name) for name in ("chord_mm", "min_step_mm", "max_step_mm"))
    steps = StepOptions(chord_mm, min_step_mm, max_step_mm, math.radians(turn_deg))
    gap_mm, split_deg = values.pop("gap_mm"), values.pop("split_deg")
    if gap_mm is not None and not gap_mm > 0:
        raise InputError(f"--gap-mm must be positive, got {gap_mm}")
    if not 0 <= split_deg <= 180:
        raise InputError(f"--split-deg must be between 0 and 180, got {split_deg}")
    return SeamOptions(gap_mm, ConcaveEdges(values.pop("concave")), math.radians(split_deg), steps)


def to_seam_choice(values: dict[str, Any]) -> SeamChoice:
    """Take the values of `seam_choice_options` out of a command's arguments and read the edits."""
    from cad.workpiece.seams import SeamChoice
    from wpcal.seam.edit import read_edits

    path, marked, edges = (values.pop(name) for name in ("seams_file", "marked", "edges"))
    return SeamChoice(() if path is None else read_edits(path), tuple(marked), tuple(edges))


def read_pose(text: str) -> RigidTransform:
    """Read ``T_nominal_part``: six numbers x,y,z,a,b,c (mm and degrees, R = Rz(c) Ry(b) Rx(a)) or a JSON file.

    Raises
    ------
    InputError
        When it is neither; the JSON file holds a 4×4 matrix, by itself or under the key ``T_nominal_part``.
    """
    import numpy as np

    from wpcal.core.errors import InputError
    from wpcal.core.transform import RigidTransform

    try:
        numbers = [float(v) for v in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) == 6:
        six = np.array([*numbers[:3], *np.radians(numbers[3:])])
        return RigidTransform.from_six_tuple(six, target="nominal", source="part")
    path = Path(text)
    if not path.is_file():
        raise InputError(f"--nominal: expected x,y,z,a,b,c in mm and degrees or a JSON file, got {text!r}")
    try:
        record = json.loads(path.read_text(encoding="utf-8"))
    except ValueError:
        raise InputError(f"--nominal: {path}: is not JSON") from None
    matrix: Any = record.get("T_nominal_part") if isinstance(record, dict) else record
    try:
        return RigidTransform.from_matrix(matrix, target="nominal", source="part")
    except InputError as error:
        raise InputError(f"--nominal: {path}: {error}") from None
