"""One job per seam and a job that calls them all, relative to a user frame: what languages of jobs have in common.

A job cannot contain the values of its user frame. Comments of the main job list the six numbers for a person to type,
rounded as the pendant takes them, and the points are relative to exactly these rounded numbers. A job cannot leave the
arm's configuration open either: it is computed from the arm's joints as far as the language's rules are known, or the
user gives it. Without it no job is written.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from wpcal.controllers.language.emit import WeldWriter
from wpcal.controllers.language.naming import NameRules
from wpcal.controllers.language.rounding import rounded_frame, zyx_degrees
from wpcal.controllers.program import ControllerSettings, SafePoint, WeldPath, WeldProgram
from wpcal.controllers.program.describe import describe, describe_path
from wpcal.controllers.program.planned import ALONE, JointMoves
from wpcal.core.arrays import BoolArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.inverse import Posture


def refuse_first(is_unknown: BoolArray, why: str) -> None:
    """Refuse configurations that are not known.

    `is_unknown`: shape (n,). For every pose.
    Raises `InputError` with the number of the first such pose, counted from 1.
    """
    if is_unknown.any():
        raise InputError(f"pose {int(np.argmax(is_unknown)) + 1} of {len(is_unknown)}: {why}")


@dataclass(frozen=True, slots=True)
class ConfigurationRule:
    """How a language writes the arm's configuration."""

    format_name: str  #: The format in `wpcal export`, and the key in `ControllerSettings.configurations`.
    word: str  #: What the language calls it.
    pattern: re.Pattern[str]  #: What a user may give.
    expected: str  #: The same for messages.
    example: str
    #: From postures to one configuration each, without the user's.
    compute: Callable[[Posture], list[str]] | None = None
    #: From postures and the user's configuration to one configuration each, where only a part can be computed.
    complete: Callable[[Posture, str], list[str]] | None = None

    def texts(self, program: WeldProgram, poses: WeldPath | SafePoint) -> list[str]:
        """Return the configuration of every pose as written: the user's if one is given, else computed.

        Raises `InputError` when the user gave none and it cannot be computed, or something else than a configuration of
        this language. wpcal never guesses it.
        """
        where = f"seam {poses.seam.name}" if isinstance(poses, WeldPath) else "the safe point"
        postures, has_arm = program.posture_of(poses), program.arm is not None
        return self.texts_of(program.controller, postures, len(poses.p_base), where=where, has_arm=has_arm)

    def texts_of(
        self, controller: ControllerSettings, postures: Posture | None, count: int, *, where: str, has_arm: bool
    ) -> list[str]:
        """Return the configuration of poses as written; see `texts`."""
        given = self.given(controller, is_needed=not has_arm or self.compute is None or postures is None)
        if postures is None or (given is not None and self.complete is None):
            return [str(given)] * count
        try:
            if self.compute is not None:
                return self.compute(postures)
            return self.complete(postures, str(given)) if self.complete else [str(given)] * count
        except InputError as error:
            option = f'--config {self.format_name}="{self.example}"'
            raise InputError(f"{self.format_name}: {where}: {error}; give {self.expected}: {option}") from None

    def origin(self, controller: ControllerSettings, *, has_arm: bool) -> str:
        """Say for a comment where the configuration comes from."""
        given = self.given(controller, is_needed=False)
        if not has_arm or (given is not None and self.complete is None):
            return f"{self.word} as given by the user"
        return f"{self.word} computed from the joints" if given is None else f"{self.word} as given; ranges computed"

    def given(self, controller: ControllerSettings, *, is_needed: bool) -> str | None:
        """Return the configuration that the user gave; None if none is given and none is needed.

        Raises `InputError` when it is needed and not given, or is not one of this language.
        """
        given = controller.configurations.get(self.format_name, controller.configurations.get(""))
        option = f'--config {self.format_name}="{self.example}"'
        if given is None:
            if not is_needed:
                return None
            with_arm = "" if self.compute is None else ", or the arm (--robot) to compute it"
            raise InputError(
                f"{self.format_name}: every position needs the arm's configuration ({self.word}); "
                f"give {self.expected}: {option}{with_arm}"
            )
        if not self.pattern.fullmatch(given):
            raise InputError(
                f"{self.format_name}: configuration {given!r}: expected {self.expected}; "
                f"with more than one format: {option}"
            )
        return given


@dataclass(frozen=True, slots=True)
class JobLanguage:
    """What a language of such jobs has of its own."""

    names: NameRules  #: Of jobs; they are written in upper case.
    suffix: str  #: Of files, with the dot.
    job_word: str  #: What the language calls a job.
    #: `mm_decimals`, `deg_decimals`: Decimals that the pendant takes.
    mm_decimals: int
    deg_decimals: int
    frame_word: str  #: What the language calls a user frame.
    #: The six numbers of a user frame in the order x, y, z, and about x, y, z.
    frame_keys: tuple[str, str, str, str, str, str]
    rotation: str  #: How the three angles are multiplied, for the comment.
    configuration: ConfigurationRule
    coordinated: str  #: What the controller needs where the positioner turns along a seam, for the comment.
    #: Whether the positions of a plan are joints, which need neither a user frame nor a configuration.
    plans_in_joints: bool = False
    lines_to_joints: bool = False  #: Whether they are where a configuration is not known: lines lead to joints as well.
    sets_frame: str = "set"  #: What is said of the user frame: that a person sets it, or what sets it.

    def frame_as_written(self, T: RigidTransform) -> RigidTransform:
        """Return the frame with the written digits: its rounding then does not move the points in the base."""
        return rounded_frame(T, mm_decimals=self.mm_decimals, deg_decimals=self.deg_decimals)


class JobWriter(WeldWriter):
    """Writes a job per seam and the job that calls them."""

    language: ClassVar[JobLanguage]

    def __init__(self, program: WeldProgram) -> None:
        super().__init__(program)
        language = self.language
        self.in_joints = self.planned is not None and language.plans_in_joints
        try:
            for poses in () if self.in_joints else program.groups:
                language.configuration.texts(program, poses)  # refused before anything else
        except InputError:
            if self.planned is None or self.planned.follows or not language.lines_to_joints:
                raise
            self.in_joints = True
        main, names = self.own_names(0 if self.planned is None else len(ALONE))
        self.main, self.jobs = main.upper(), {name: job.upper() for name, job in names.items()}
        self.T_base_frame = language.frame_as_written(program.T_base_part)

    def main_job(
        self, name: str, header: list[str], calls: Sequence[str], air: Sequence[JointMoves] | None = None
    ) -> str:
        """Return the contents of a job that calls the jobs of seams.

        `calls`: Their names.
        `air`: The moves of a plan before each of them and after the last.
        """
        raise NotImplementedError

    def seam_job(self, name: str, path: WeldPath) -> str:
        """Return the contents of the job of a seam."""
        raise NotImplementedError

    def files(self) -> dict[str, str]:
        """Return names and contents."""
        suffix, jobs = self.language.suffix, self.jobs
        air: list[JointMoves] | None = None
        ways = () if self.planned is None else self.planned.ways
        if self.planned is not None:  # the last move before a seam is in the job of the seam
            *before, last = self.planned.air
            air = [*(moves.rows(0, -1) for moves in before), last]
        main = self.main_job(self.main, self.post.header(self._about()), list(jobs.values()), air)
        files = {f"{self.main}{suffix}": main}
        for path in self.program.paths:
            files[f"{jobs[path.seam.name]}{suffix}"] = self.seam_job(jobs[path.seam.name], path)
        for path, way in zip(self.program.paths, ways, strict=False):
            name = f"{ALONE.upper()}{jobs[path.seam.name]}"
            if len(way[0]):
                about = self.remarks([f"{path.seam.name} alone: from home, and home"])
                files[f"{name}{suffix}"] = self.main_job(name, self.post.header(about), [jobs[path.seam.name]], way)
        return files

    def _about(self) -> list[str]:
        program, language, jobs = self.program, self.language, self.jobs
        frame = ["positions are joints, deg"]
        if not self.in_joints:
            origin = language.configuration.origin(program.controller, has_arm=program.arm is not None)
            frame = [*self._frame_in_words(), origin]
        return self.remarks(
            [
                *describe(program),
                *frame,
                *([language.coordinated] if self.planned is not None and self.planned.follows else []),
                f"seam -> {language.job_word} here",
                *(f" {path.seam.name} -> {jobs[path.seam.name]}: {describe_path(path)}" for path in program.paths),
            ]
        )

    def remarks(self, lines: Sequence[str]) -> list[str]:
        """Return lines as short as a remark."""
        return self.comments(lines)

    def _frame_in_words(self) -> list[str]:
        """Say what the points are relative to."""
        language, number = self.language, self.program.controller.frame_number
        if self.planned is not None and self.planned.turning:
            rotation = f"{language.rotation}, deg"
            return [f"points are in {language.frame_word} {number}: the base", "of the robot, mm", rotation]
        return frame_in_words(language, number, self.T_base_frame)

    def planned_calls(self, air: Sequence[JointMoves], calls: Sequence[str]) -> tuple[list[str], JointMoves]:
        """Return the joint moves of a plan with the calls of the seams between them, and where these moves lead."""
        lines, count = list[str](), 0
        for row, moves in enumerate(air):
            for _ in range(len(moves)):
                count += 1
                lines += self.joint_move(count)
            lines += calls[row : row + 1]
        joints, external = (np.concatenate([getattr(way, name) for way in air]) for name in ("joints", "external"))
        return lines, JointMoves(joints, external)


def frame_in_words(language: JobLanguage, number: int, T_base_frame: RigidTransform) -> list[str]:
    """Return the lines that tell a person which user frame to set."""
    mm, deg = language.mm_decimals, language.deg_decimals
    numbers = [f"{v:.{mm}f}" for v in T_base_frame.t_mm]
    numbers += [f"{v:.{deg}f}" for v in zyx_degrees(T_base_frame.R, decimals=deg)]
    return [
        f"{language.sets_frame} {language.frame_word} {number} to the part:",
        *(f" {key} {value}" for key, value in zip(language.frame_keys, numbers, strict=True)),
        "points are relative to it, mm",
        f"{language.rotation}, deg",
        f"rounded within {10.0**-mm:.{mm}f} mm, {10.0**-deg:.{deg}f} deg",
    ]
