"""Options that several commands share: how seams are found, which of them count, and how points are fitted."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from wpcal.cli.option_groups import option
from wpcal.cli.shared_help import CRITERION_HELP, SOLVER_HELP, TOLERANCE_HELP, XMCF_HELP
from wpcal.cli.teaching_options import TeachingFlags

if TYPE_CHECKING:
    from cad.workpiece.fit_taught import CalibrateOptions
    from cad.workpiece.seams import SeamChoice
    from wpcal.core.transform import RigidTransform
    from wpcal.seam import SeamOptions
    from wpcal.seam.options import Judging, Reach

POINT_LETTERS = ("V", "C", "H", "S", "M", "B", "E")
"""`FeatureKind` values of `POINT_KINDS`; written out so that the help needs no NumPy."""
KIND_LETTERS = (*POINT_LETTERS, "L", "X", "P", "A")
"""All `FeatureKind` values."""


PART, MESH, LINES = "part", "mesh", "lines"
"""Questions of `cad.workpiece.step_file`; written out so that the help needs no NumPy."""

no_cache_option = click.option(
    "--no-cache",
    is_flag=True,
    help="Find everything anew, and keep nothing for the next command on the same file.",
)


@dataclass(frozen=True, slots=True, kw_only=True)
class ReachFlags:
    """The torch with which reach is judged, and how far it may lean and turn."""

    torch: str = option(
        "--torch",
        metavar="NAME|FILE",
        default="straight",
        show_default=True,
        help="The torch with which reach is judged: one of wpcal torches, or a file of that form.",
    )
    work_range: str = option(
        "--work-range-deg",
        metavar="FROM,TO",
        default="-15,15",
        show_default=True,
        help="How far the torch may lean across a seam.",
    )
    travel_range: str = option(
        "--travel-range-deg",
        metavar="FROM,TO",
        default="-35,35",
        show_default=True,
        help="How far the torch may lean along a seam; push is positive.",
    )
    neck_range_deg: float = option(
        "--neck-range-deg",
        type=float,
        default=180.0,
        show_default=True,
        help="How far a bent neck may be turned about the wire, either way; at 0 it bends against the travel.",
    )

    def to_reach(self) -> Reach:
        """Read the torch, and return it with the ranges."""
        from wpcal.robot.torch.file import find_torch
        from wpcal.seam.options import Reach

        return Reach(
            find_torch(self.torch),
            _range_deg("--work-range-deg", self.work_range),
            _range_deg("--travel-range-deg", self.travel_range),
            (-self.neck_range_deg, self.neck_range_deg),
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class SeamFlags:
    """How seams are found and cut into frames."""

    split_deg: float = option(
        "--split-deg", type=float, default=30.0, show_default=True, help="A seam ends where it turns by more."
    )
    concave: str = option(
        "--concave",
        type=click.Choice(["always", "never", "auto"]),
        default="auto",
        show_default=True,
        help="Take concave edges inside one solid as seams; auto: only of solids that touch no other solid and "
        "are built up of plates, bars and tubes.",
    )
    gap_mm: float | None = option(
        "--gap-mm", type=float, help="Largest gap between members.  [default: by part size, at most 0.5]"
    )
    min_length_mm: float = option(
        "--min-length-mm", type=float, default=5.0, show_default=True, help="Least length of an accepted seam."
    )
    join_mm: float = option(
        "--join-mm",
        type=float,
        default=5.0,
        show_default=True,
        help="Join contacts in one line across interruptions of at most this length; 0 joins none.",
    )
    wrap: bool = option(
        "--wrap",
        is_flag=True,
        default=False,
        help="Weld seams that meet at a corner of a member in one run round it, with the short ends between them.",
    )
    turn_deg: float = option(
        "--turn-deg", type=float, default=45.0, show_default=True, help="Largest turn of the frame between points."
    )
    max_step_mm: float = option(
        "--max-step-mm", type=float, default=10.0, show_default=True, help="Largest step along a seam."
    )
    min_step_mm: float = option(
        "--min-step-mm", type=float, default=1.0, show_default=True, help="Smallest step along a seam."
    )
    chord_mm: float = option("--chord-mm", type=float, default=0.1, show_default=True, help="Largest chord error.")
    weld: tuple[str, ...] = option(
        "--weld",
        metavar="NAME",
        multiple=True,
        help="The solids of this name can be welded, whatever the evidence; * and ? match any letters. The name may be "
        "that of a product or an instance above them.",
    )
    not_welded: tuple[str, ...] = option(
        "--not",
        metavar="NAME",
        multiple=True,
        help="The solids of this name are not welded. If --weld fits, too, the name with more letters counts.",
    )
    strict: bool = option("--strict", is_flag=True, help="Accept only what is sure.")
    generous: bool = option("--generous", is_flag=True, help="Accept also what one doubtful finding speaks against.")
    reach: ReachFlags

    def to_judging(self) -> Judging:
        """Return what a person says about members, and how sure a seam must be."""
        from wpcal.core.errors import InputError
        from wpcal.seam.limits import Level
        from wpcal.seam.options import Judging

        if self.strict and self.generous:
            raise InputError("--strict and --generous exclude each other")
        level = Level.STRICT if self.strict else Level.GENEROUS if self.generous else Level.USUAL
        return Judging(tuple(self.weld or ()), tuple(self.not_welded or ()), level)

    def to_options(self) -> SeamOptions:
        """Check the numbers and return them as the seam finder takes them, angles in radians."""
        import math

        from wpcal.core.errors import InputError
        from wpcal.seam import ConcaveEdges, SeamOptions, StepOptions

        if not 0 < self.turn_deg <= 180:
            raise InputError(f"--turn-deg must be above 0 and at most 180, got {self.turn_deg}")
        steps = StepOptions(self.chord_mm, self.min_step_mm, self.max_step_mm, math.radians(self.turn_deg))
        if self.gap_mm is not None and not self.gap_mm > 0:
            raise InputError(f"--gap-mm must be positive, got {self.gap_mm}")
        if not 0 <= self.split_deg <= 180:
            raise InputError(f"--split-deg must be between 0 and 180, got {self.split_deg}")
        split_rad = math.radians(self.split_deg)
        concave, judging = ConcaveEdges(self.concave), self.to_judging()
        return SeamOptions(
            self.gap_mm,
            concave,
            split_rad,
            steps,
            min_length_mm=self.min_length_mm,
            join_mm=self.join_mm,
            judging=judging,
            reach=self.reach.to_reach(),
            wrap=self.wrap,
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class MarkedFlags:
    """Which edges a person says are the seams."""

    marked: tuple[str, ...] = option(
        "--marked",
        metavar="PATTERN",
        multiple=True,
        help="Edges and wires of this name or layer (* and ? match any letters) or colour (#rrggbb) are the "
        "seams. With --marked or --edge nothing else is.",
    )
    edges: tuple[str, ...] = option(
        "--edge",
        metavar="PLACE",
        multiple=True,
        help="The edge at x,y,z (part frame, mm) or at a feature (M12) is a seam. With --edge or --marked nothing "
        "else is.",
    )
    added_edges: tuple[str, ...] = option(
        "--add-edge",
        metavar="PLACE",
        multiple=True,
        help="One seam more than those that are found: the edge at x,y,z (part frame, mm) or at a feature (M12).",
    )
    xmcf: Path | None = option(
        "--xmcf",
        metavar="WELDS.xml",
        type=click.Path(path_type=Path),
        help=f"{XMCF_HELP}: the edges at them are the seams. With it nothing else is.",
    )

    def to_choice(self, seams_file: Path | None) -> SeamChoice:
        """Return these edges with the edits of a seams.json, which is read."""
        from cad.workpiece.seams import SeamChoice
        from wpcal.seam.edit import read_edits
        from wpcal.weld.xmcf.read import places_of, read_xmcf

        edits = () if seams_file is None else read_edits(seams_file)
        places = () if self.xmcf is None else places_of(read_xmcf(self.xmcf), file=str(self.xmcf))
        return SeamChoice(edits, self.marked, (*self.edges, *places), self.added_edges)


@dataclass(frozen=True, slots=True, kw_only=True)
class SeamChoiceFlags:
    """What a person decides about the seams: edits of those found, and marked edges."""

    seams_file: Path | None = option(
        "--seams",
        metavar="FILE",
        type=click.Path(path_type=Path),
        help="A seams.json of this part with decisions, from the picker, from the page of seams, or edited: an object "
        "edit with accept, reject, reverse, name, range_mm, other_side, join.",
    )
    marks: MarkedFlags

    def to_choice(self) -> SeamChoice:
        """Return the choice; the file with edits is read."""
        return self.marks.to_choice(self.seams_file)


@dataclass(frozen=True, slots=True, kw_only=True)
class FitFlags:
    """How taught points are fitted and judged."""

    tolerance_mm: float = option("--tolerance-mm", type=float, default=0.5, show_default=True, help=TOLERANCE_HELP)
    criterion: str = option(
        "--criterion",
        type=click.Choice(["minimax", "least_squares", "weighted", "robust"]),
        default="minimax",
        show_default=True,
        help=CRITERION_HELP,
    )
    solver: str = option(
        "--solver", type=click.Choice(["annealing", "exact"]), default="annealing", show_default=True, help=SOLVER_HELP
    )
    seed: int = option(
        "--seed", type=click.IntRange(min=0), default=0, show_default=True, help="Seed of all random numbers."
    )
    nominal: str | None = option(
        "--nominal",
        metavar="POSE",
        help="Place of the part in the cell's model: x,y,z,a,b,c in mm and degrees with R = Rz(c) Ry(b) Rx(a), "
        "or a JSON file with a 4×4 matrix.",
    )
    teaching: TeachingFlags
    ball_mm: float = option(
        "--ball-mm", type=float, default=0.0, show_default=True, help="Radius of the ball in touches on faces."
    )
    certify: bool = option(
        "--certify", is_flag=True, help="Close the gap to the lower bound by branch and bound (slow)."
    )

    def to_nominal(self) -> RigidTransform | None:
        """Return ``T_nominal_part`` if it was given."""
        return None if self.nominal is None else read_pose(self.nominal)


@dataclass(frozen=True, slots=True, kw_only=True)
class CalibrateFlags:
    """How points are fitted and seams found."""

    fit: FitFlags
    seams: SeamFlags

    def to_options(self, choice: SeamChoice) -> CalibrateOptions:
        """Check the numbers and return them as the calibration takes them."""
        from cad.workpiece.fit_taught import CalibrateOptions
        from wpcal.calibrate import Criterion, Solver

        fit, seams = self.fit, self.seams.to_options()
        return CalibrateOptions(
            criterion=Criterion(fit.criterion),
            solver=Solver(fit.solver),
            seed=fit.seed,
            tolerance_mm=fit.tolerance_mm,
            teaching=fit.teaching.to_error(),
            seams=seams,
            certify=fit.certify,
            ball_mm=fit.ball_mm,
            choice=choice,
        )


def _range_deg(name: str, text: str) -> tuple[float, float]:
    """Read two angles from the least to the largest, in degrees."""
    from wpcal.core.errors import InputError
    from wpcal.core.numbers import parse_numbers

    try:
        low, high = parse_numbers(text)
    except ValueError:
        raise InputError(f"{name}: expected FROM,TO in degrees, got {text!r}") from None
    return low, high


def read_pose(text: str) -> RigidTransform:
    """Read ``T_nominal_part``: six numbers x,y,z,a,b,c (mm and degrees, R = Rz(c) Ry(b) Rx(a)) or a JSON file.

    Raises
    ------
    InputError
        If it is neither. The JSON file holds a 4×4 matrix, by itself or under the key ``T_nominal_part``.
    """
    import numpy as np

    from wpcal.core.errors import FormatError, InputError
    from wpcal.core.input_file import holds_file, read_bytes
    from wpcal.core.numbers import parse_numbers
    from wpcal.core.records import parse_json
    from wpcal.core.transform import RigidTransform

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
