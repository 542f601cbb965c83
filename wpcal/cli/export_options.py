"""Options of `wpcal export`: which seams, how the torch moves along them, and the names in the controller."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING

from wpcal.cli.shared_help import ONLY_HELP, ROBOT_HELP, TOOL_HELP, TOOL_METAVAR
from wpcal.cli.torch_options import SpinAsked, TorchAsked
from wpcal.cli.weld_options import ArcAsked
from wpcal.core.options import group, opt

if TYPE_CHECKING:
    from wpcal.controllers.program.air_moves import AirSettings
    from wpcal.controllers.program.reachable_spin import ArmAtTool
    from wpcal.controllers.program.weld_program import ControllerSettings, MotionSettings, WeldProgram
    from wpcal.core.progress import Progress
    from wpcal.results.folder import FinishedCalibration
    from wpcal.robot.moves import PathTolerance
    from wpcal.robot.torch.attitude import TorchSettings
    from wpcal.robot.torch.shape import TorchShape


@dataclass(frozen=True, slots=True, kw_only=True)
class SelectionAsked:
    """Which seams are written."""

    only: str | None = opt(None, f"{ONLY_HELP}  [default: the accepted ones]", metavar="W1,W5-W8")
    everything: bool = opt(False, "Leave nothing out: also the candidates.", "--all")

    def select(self, finished: FinishedCalibration) -> FinishedCalibration:
        """Return the calibration with the chosen seams only."""
        from wpcal.seam.names import split_names

        names = None if self.only is None else split_names(self.only)
        return finished.select(names, everything=self.everything)

    def require_one(self) -> None:
        """Refuse names together with all. Raises `InputError` if both are given."""
        from wpcal.core.errors import InputError

        if self.only is not None and self.everything:
            raise InputError("give either --only or --all")

    def words(self) -> list[str]:
        """Return the options as they are typed."""
        return [*([] if self.only is None else ["--only", self.only]), *(["--all"] if self.everything else [])]


@dataclass(frozen=True, slots=True, kw_only=True)
class PathAsked:
    """How the seams become moves."""

    fitted: PathTolerance = group("wpcal.robot.moves.fit:PathTolerance")
    every_point: bool = opt(False, "Write a linear move to every point of a seam, and no arcs.")

    @property
    def tolerance(self) -> PathTolerance | None:
        """The tolerance of lines and arcs; None for every point."""
        return None if self.every_point else self.fitted


@dataclass(frozen=True, slots=True, kw_only=True)
class ArmAsked:
    """The arm that welds: its joints decide the spin of the torch and the configuration that programs state."""

    robot: str | None = opt(
        None,
        f"{ROBOT_HELP} The joints are followed, and the configuration is computed. With an identified arm corrected "
        "targets are written, with which it reaches the true poses. Needs --tool and --near-joints.",
        metavar="ARM",
    )
    near_joints: str | None = opt(
        None, "With --robot: shown joint angles near the seam, deg; they choose the branch.", metavar="Q1,…,Q6"
    )
    tool: str | None = opt(None, f"{TOOL_HELP} As set in the controller.", metavar=TOOL_METAVAR)

    def read(self) -> ArmAtTool | None:
        """Return the arm with its tool and where it is; None if no arm is given.

        Raises `InputError` when the arm cannot be read, or `near` or `tool` is missing or unreadable.
        """
        if self.robot is None:
            return None
        import numpy as np

        from wpcal.controllers.program.reachable_spin import ArmAtTool
        from wpcal.core.errors import InputError
        from wpcal.core.numbers import parse_numbers
        from wpcal.robot.identify.poses_file import parse_tool
        from wpcal.robot.kinematics.arm_file import find_arm

        arm = find_arm(self.robot)
        try:
            near = np.radians(parse_numbers(self.near_joints or ""))
        except ValueError:
            near = np.zeros(0)
        if near.shape != (6,):
            raise InputError(
                f"--robot needs --near-joints: six joint angles in degrees near the seam, got {self.near_joints!r}"
            )
        if self.tool is None:
            raise InputError(
                "--robot needs --tool: the tool as set in the controller; 0,0,0 if it is the flange itself"
            )
        return ArmAtTool(arm, parse_tool(self.tool)[0], near)


@dataclass(frozen=True, slots=True, kw_only=True)
class WeldProgramAsked:
    """Everything that says what the written programs contain."""

    selection: SelectionAsked = group(SelectionAsked)
    torch: TorchSettings = group("wpcal.robot.torch.attitude:TorchSettings")
    spin: SpinAsked = group(SpinAsked)
    motion: MotionSettings = group("wpcal.controllers.program.weld_program:MotionSettings")
    path: PathAsked = group(PathAsked)
    air: AirSettings = group("wpcal.controllers.program.air_moves:AirSettings")
    shape: TorchAsked = group(TorchAsked)
    controller: ControllerSettings = group("wpcal.controllers.program.weld_program:ControllerSettings")
    arm: ArmAsked = group(ArmAsked)
    arc: ArcAsked = group(ArcAsked)
    touches: tuple[Path, ...] = opt(
        (),
        "A plan of touches (touches.json) of the part: the program searches, corrects the frame of the seams by what "
        "it finds, and welds, in one run; a language that cannot is refused. Twice: the first and the second stage.",
        many=True,
        metavar="PLAN",
        type=Path,
    )
    strict: bool = opt(False, "Write no program if one seam cannot be written.", "--whole")

    def build(self, folder: Path, *, progress: Progress) -> WeldPrograms:
        """Read the calibration, and return what puts the torch on its seams as the options say."""
        from wpcal.cli.outputs import say_note
        from wpcal.controllers.program.weld_program import build_program
        from wpcal.core.robot_space import RobotSpace
        from wpcal.results.folder import read_finished

        self.selection.require_one()
        tolerance, arm = self.path.tolerance, self.arm.read()
        space = RobotSpace.NOMINAL if arm is None else arm.arm.space
        whole = read_finished(folder, space=space)
        say_note(whole.note)
        finished = self.selection.select(whole)
        shape = self.shape.to_shape(whole.torch)
        torch = self.spin.spun(self.torch, shape)
        names = {seam.name for seam in finished.seams}
        welds, arc = self.arc.read(whole.seams, whole.T_base_part, part_glb=whole.part_glb, names=names)
        program = build_program(
            finished,
            torch=torch,
            motion=self.motion,
            controller=self.controller,
            welds=welds,
            arc=arc,
            choice=self.arc.choice,
        )
        return WeldPrograms(self, program, tolerance, arm, shape, whole.torch, progress)


class WeldPrograms:
    """The program of a calibration in its two forms, each made when it is first asked for.

    `program`: With a pose for every frame of the seams, not compared with the part.
    `shape`: The torch that is compared with the part.
    """

    def __init__(
        self,
        flags: WeldProgramAsked,
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
        """Return the program with lines and arcs, or with every point of the seams."""
        few = takes_arcs and self._tolerance is not None
        if few not in self._made:
            self._made[few] = self._make(self._tolerance if few else None)
        return self._made[few]

    def _make(self, tolerance: PathTolerance | None) -> WeldProgram:
        from wpcal.controllers.program.few_moves import fit_program
        from wpcal.core.wording import counted

        program, arm = self._program, self._arm
        points = sum(map(len, program.paths))
        self._progress(f"comparing {points} poses on {counted(len(program.paths), 'seam')} with the part")
        if arm is not None:
            from wpcal.controllers.program.compensation import compensate_program
            from wpcal.controllers.program.followed_program import program_for_arm

            return compensate_program(program_for_arm(program, arm, check=self._check, tolerance=tolerance), arm)
        return self._check(program if tolerance is None else fit_program(program, tolerance))

    def _check(self, program: WeldProgram) -> WeldProgram:
        from wpcal.controllers.program.checked_program import check_program

        checked = check_program(program, torch=self._shape, air=self._flags.air, strict=self._flags.strict)
        if self._felt is None or self._felt == self._shape:
            return checked
        told = f"seams.json was made for another torch: {self._felt}; reach was not felt with this one"
        return replace(checked, checked=(*checked.checked, told))
