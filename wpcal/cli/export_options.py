"""Options of `wpcal export`: which seams, how the torch moves along them, and the names in the controller."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

import click

from wpcal.cli.option_groups import option
from wpcal.cli.shared_help import (
    ONLY_HELP,
    ROBOT_HELP,
    SPEED,
    SPEED_HELP,
    TOOL_HELP,
    TOOL_METAVAR,
)
from wpcal.cli.torch_options import TorchFlags, TorchShapeFlags
from wpcal.cli.weld_options import ArcFlags

if TYPE_CHECKING:
    from wpcal.controllers.program import ControllerSettings, MotionSettings, WeldProgram
    from wpcal.controllers.program.reachable_spin import ArmAtTool
    from wpcal.core.progress import Progress
    from wpcal.results.folder import FinishedCalibration
    from wpcal.robot.moves import PathTolerance
    from wpcal.robot.torch.shape import TorchShape


@dataclass(frozen=True, slots=True, kw_only=True)
class SelectionFlags:
    """Which seams are written."""

    only: str | None = option("--only", metavar="W1,W5-W8", help=f"{ONLY_HELP}  [default: the accepted ones]")
    everything: bool = option("--all", is_flag=True, help="Leave nothing out: also the candidates.")

    def select(self, finished: FinishedCalibration) -> FinishedCalibration:
        """Return the calibration with the chosen seams only."""
        from wpcal.seam.names import split_names

        names = None if self.only is None else split_names(self.only)
        return finished.select(names, everything=self.everything)

    def require_one(self) -> None:
        """Refuse names together with all.

        Raises
        ------
        InputError
            If both are given.
        """
        from wpcal.core.errors import InputError

        if self.only is not None and self.everything:
            raise InputError("give either --only or --all")

    def words(self) -> list[str]:
        """Return the options as they are typed."""
        return [*([] if self.only is None else ["--only", self.only]), *(["--all"] if self.everything else [])]


@dataclass(frozen=True, slots=True, kw_only=True)
class MotionFlags:
    """How the torch arrives, welds and leaves."""

    approach_mm: float = option(
        "--approach-mm", type=float, default=50.0, show_default=True, help="Along the wire, before the seam."
    )
    retract_mm: float = option(
        "--retract-mm", type=float, default=50.0, show_default=True, help="Along the wire, after the seam."
    )
    speed_mm_s: float = option("--speed-mm-s", type=SPEED, default=8.0, show_default=True, help=SPEED_HELP)
    air_speed_mm_s: float = option(
        "--air-speed-mm-s", type=SPEED, default=100.0, show_default=True, help="Speed of approach and retract."
    )

    def to_settings(self) -> MotionSettings:
        """Return the motion as the programs take it."""
        from wpcal.controllers.program import MotionSettings

        return MotionSettings(self.approach_mm, self.retract_mm, self.speed_mm_s, self.air_speed_mm_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class PathFlags:
    """How the seams become moves."""

    path_tol_mm: float = option(
        "--path-tol-mm",
        type=float,
        default=0.05,
        show_default=True,
        help="A seam becomes as few lines and circular arcs as keep the wire within this distance, and within 0.5 deg.",
    )
    every_point: bool = option(
        "--every-point", is_flag=True, help="Write a linear move to every point of a seam, and no arcs."
    )

    def to_tolerance(self) -> PathTolerance | None:
        """Return the tolerance of lines and arcs; None for every point."""
        from wpcal.robot.moves import PathTolerance

        return None if self.every_point else PathTolerance(self.path_tol_mm)


@dataclass(frozen=True, slots=True, kw_only=True)
class AirFlags:
    """How the torch goes from one seam to the next."""

    clearance_mm: float | None = option(
        "--clearance-mm",
        type=float,
        help="Height of the tool above the part between seams.  [default: the torch is 50 mm above the part]",
    )
    up: str = option(
        "--up",
        metavar="X,Y,Z",
        default="0,0,1",
        show_default=True,
        help="Direction away from the support of the part, in the base.",
    )

    def check(self, program: WeldProgram, torch: TorchShape) -> WeldProgram:
        """Compare the program with the part and add the ways between the seams."""
        from wpcal.controllers.program.air_moves import AirSettings
        from wpcal.controllers.program.checked_program import check_program
        from wpcal.core.errors import InputError
        from wpcal.core.numbers import parse_numbers

        try:
            x, y, z = parse_numbers(self.up)
        except ValueError:
            raise InputError(f"--up: expected X,Y,Z, got {self.up!r}") from None
        return check_program(program, torch=torch, air=AirSettings(self.clearance_mm, (x, y, z)))


@dataclass(frozen=True, slots=True, kw_only=True)
class ControllerFlags:
    """Names and numbers of the program, the tool and the user frame in the controller."""

    program_name: str = option(
        "--program-name", default="WPCAL", show_default=True, help="Name of the program in the controller."
    )
    tool_name: str = option(
        "--tool-name", default="tTorch", show_default=True, help="If the controller's tools have names."
    )
    tool_number: int = option(
        "--tool-number", type=int, default=1, show_default=True, help="If the tools have numbers."
    )
    frame_number: int = option("--frame-number", type=int, default=1, show_default=True, help="User frame of the part.")
    configurations: tuple[str, ...] = option(
        "--config",
        multiple=True,
        metavar="[FORMAT=]CONFIG",
        help='Configuration of the arm as the pendant shows it, for FANUC, Yaskawa: --config fanuc="N U T, 0, 0, 0". '
        "Without FORMAT it is used for every format. Repeatable.",
    )
    templates: Path | None = option(
        "--template",
        metavar="FOLDER",
        type=click.Path(path_type=Path),
        help="Your templates of header, start and end of a weld, moves off the seams and footer: a folder with one "
        "folder per format, as --write-templates writes them. A template that is not there is ours.",
    )

    def to_settings(self) -> ControllerSettings:
        """Return the names and numbers as the programs take them."""
        from wpcal.cli.hints import named_option
        from wpcal.controllers.program import ControllerSettings
        from wpcal.core.errors import InputError
        from wpcal.formats.registry import exporter_named

        configurations: dict[str, str] = {}
        for given in self.configurations:
            name, _, value = given.rpartition("=")
            with named_option(f"--config {given}"):
                name = name and exporter_named(name).name
            if name in configurations:
                raise InputError(
                    f"--config {given}: {f'{name} is' if name else 'a value for all formats is'} given twice"
                )
            configurations[name] = value.strip()
        return ControllerSettings(
            self.program_name, self.tool_name, self.tool_number, self.frame_number, configurations, self.templates
        )


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmFlags:
    """The arm that welds: its joints decide the spin of the torch and the configuration that programs state."""

    robot: str | None = option(
        "--robot",
        metavar="ARM",
        help=f"{ROBOT_HELP} The joints are followed, and the configuration is computed. With an identified arm "
        "corrected targets are written, with which it reaches the true poses. Needs --tool and --near-joints.",
    )
    near: str | None = option(
        "--near-joints",
        metavar="Q1,…,Q6",
        help="With --robot: shown joint angles near the seam, deg; they choose the branch.",
    )
    tool: str | None = option("--tool", metavar=TOOL_METAVAR, help=f"{TOOL_HELP} As set in the controller.")

    def read(self) -> ArmAtTool | None:
        """Return the arm with its tool and where it is; None if no arm is given.

        Raises
        ------
        InputError
            When the arm cannot be read, or `near` or `tool` is missing or unreadable.
        """
        import numpy as np

        from wpcal.controllers.program.reachable_spin import ArmAtTool
        from wpcal.core.errors import InputError
        from wpcal.core.numbers import parse_numbers
        from wpcal.robot.identify.poses_file import parse_tool
        from wpcal.robot.kinematics.arm_file import find_arm

        if self.robot is None:
            return None
        arm = find_arm(self.robot)
        try:
            near = np.radians(parse_numbers(self.near or ""))
        except ValueError:
            near = np.zeros(0)
        if near.shape != (6,):
            raise InputError(
                f"--robot needs --near-joints: six joint angles in degrees near the seam, got {self.near!r}"
            )
        if self.tool is None:
            raise InputError(
                "--robot needs --tool: the tool as set in the controller; 0,0,0 if it is the flange itself"
            )
        return ArmAtTool(arm, parse_tool(self.tool)[0], near)


@dataclass(frozen=True, slots=True, kw_only=True)
class WeldProgramFlags:
    """Everything that says what the written programs contain."""

    selection: SelectionFlags
    torch: TorchFlags
    motion: MotionFlags
    path: PathFlags
    air: AirFlags
    shape: TorchShapeFlags
    controller: ControllerFlags
    arm: ArmFlags
    arc: ArcFlags

    def build(self, folder: Path, *, progress: Progress) -> WeldPrograms:
        """Read the calibration, and return what puts the torch on its seams as the options say."""
        from wpcal.controllers.program import build_program
        from wpcal.core.robot_space import RobotSpace
        from wpcal.results.folder import read_finished

        self.selection.require_one()
        motion, controller = self.motion.to_settings(), self.controller.to_settings()
        tolerance, arm = self.path.to_tolerance(), self.arm.read()
        space = RobotSpace.NOMINAL if arm is None else arm.arm.space
        whole = read_finished(folder, space=space)
        finished = self.selection.select(whole)
        shape = self.shape.to_shape(whole.torch)
        torch = self.torch.to_settings(shape)
        names = {seam.name for seam in finished.seams}
        welds, arc = self.arc.read(whole.seams, whole.T_base_part, part_glb=whole.part_glb, names=names)
        program = build_program(
            finished, torch=torch, motion=motion, controller=controller, welds=welds, arc=arc, choice=self.arc.choice()
        )
        return WeldPrograms(self, program, tolerance, arm, shape, whole.torch, progress)


class WeldPrograms:
    """The program of a calibration in its two forms, each made when it is first asked for.

    Parameters
    ----------
    program : WeldProgram
        With a pose for every frame of the seams, not compared with the part.
    tolerance : PathTolerance or None
        Of lines and arcs; None for every point in every format.
    shape : TorchShape
        The torch that is compared with the part.
    felt : TorchShape or None
        The torch with which reach was felt, if the seams say so.
    """

    def __init__(
        self,
        flags: WeldProgramFlags,
        program: WeldProgram,
        tolerance: PathTolerance | None,
        arm: ArmAtTool | None,
        shape: TorchShape,
        felt: TorchShape | None,
        progress: Progress,
    ) -> None:
        self._flags, self._program, self._arm, self._progress = flags, program, arm, progress
        self._shape, self._felt = shape, felt
        self._tolerance = tolerance
        self._made: dict[bool, WeldProgram] = {}

    def form(self, *, takes_arcs: bool) -> WeldProgram:
        """Return the program with lines and arcs, or with every point of the seams.

        Parameters
        ----------
        takes_arcs : bool
            Whether the format can state arcs. With ``--every-point`` both forms are the same.
        """
        few = takes_arcs and self._tolerance is not None
        if few not in self._made:
            self._made[few] = self._make(self._tolerance if few else None)
        return self._made[few]

    def _make(self, tolerance: PathTolerance | None) -> WeldProgram:
        from wpcal.controllers.program.compensation import compensate_program
        from wpcal.controllers.program.few_moves import fit_program
        from wpcal.controllers.program.followed_program import program_for_arm

        program, arm = self._program, self._arm
        check = partial(self._check, torch=self._shape)
        points = sum(map(len, program.paths))
        self._progress(f"comparing {points} poses on {len(program.paths)} seams with the part")
        if arm is not None:
            return compensate_program(program_for_arm(program, arm, check=check, tolerance=tolerance), arm)
        return check(program if tolerance is None else fit_program(program, tolerance))

    def _check(self, program: WeldProgram, torch: TorchShape) -> WeldProgram:
        checked = self._flags.air.check(program, torch)
        if self._felt is None or self._felt == torch:
            return checked
        told = f"seams.json was made for another torch: {self._felt}; reach was not felt with this one"
        return replace(checked, checked=(*checked.checked, told))
