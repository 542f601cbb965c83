"""A plan of touches before it is written in a language: the poses of every search, and what the program says of itself.

What the programs store, and where, is in docs/reference/touch-results.md.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from wpcal.controllers.language.naming import NameRules, safe_name
from wpcal.controllers.program import ControllerSettings
from wpcal.controllers.program.in_run import WeldsAfter
from wpcal.core.arrays import FloatArray
from wpcal.core.errors import InputError
from wpcal.core.transform import RigidTransform
from wpcal.robot.kinematics.arm import Arm
from wpcal.robot.kinematics.inverse import Posture, posture
from wpcal.touch.searches import Search, TouchPlan, TouchSetup

NAME_ENDING = "_touch"  #: Of the name of a touch program, which thus never replaces the weld program of the same part.
LONGEST_STROKE_MM = 300.0  #: A part that is displaced by more is not where the plan says at all.
OFF_STROKE_MM = 1.0  #: The planned contact is on the line of the search; a file that is typed may be this far off.


@dataclass(frozen=True, slots=True, eq=False)
class TouchSteps:
    """The poses of one search, in the frame that the program makes its work object."""

    search: Search
    #: `p`, `R`: shapes (k + 4, 3) and (k + 4, 3, 3). The k points on the way, approach, start, end, retract; mm. Places
    #: of the tool centre point.
    p: FloatArray
    R: FloatArray
    postures: Posture | None  #: Of the arm there; None if it is not known.

    @property
    def name(self) -> str:
        """The name of the search as programs write it."""
        return self.search.name.upper()

    @property
    def way_count(self) -> int:
        """k, the number of points on the way to the approach."""
        return len(self.p) - 4

    @property
    def marks(self) -> list[str]:
        """A mark for each pose: ``V1`` on the way, ``A`` approach, ``S`` start, ``E`` end, ``R`` retract."""
        return [*(f"V{number}" for number in range(1, self.way_count + 1)), *"ASER"]


@dataclass(frozen=True, slots=True, eq=False)
class TouchProgram:
    """What a writer of touch programs gets.

    Raises `InputError` when the plan has no searches, or a search would not move onto its own face: files are edited by
    hand.
    """

    plan: TouchPlan
    setup: TouchSetup = field(default_factory=TouchSetup)
    #: Its `frame_number` is not used: touch programs use that of `setup`.
    controller: ControllerSettings = field(default_factory=ControllerSettings)
    arm: Arm | None = None  #: The arm that the joints of the plan belong to; the configuration is computed with it.
    welds: WeldsAfter | None = None  #: The weld program that runs after the searches, in one run.

    def __post_init__(self) -> None:
        if not self.plan.searches:
            raise InputError("the plan of touches has no searches")
        for search in self.plan.searches:
            _refuse_unsafe(search)

    @property
    def arc(self) -> None:
        """A touch program has no arc."""
        return

    def name(self, rules: NameRules) -> str:
        """Return the name of the program on the controller."""
        longest = NameRules(rules.language, rules.longest - len(NAME_ENDING), rules.keywords)
        return f"{safe_name(self.controller.program_name, longest)}{NAME_ENDING}"

    def steps(self, T_base_frame: RigidTransform) -> tuple[TouchSteps, ...]:
        """Return the poses of the searches.

        `T_base_frame`: `TouchPlan.T_base_part` with the digits that the program states. Its rounding then does not move
        the robot.
        """
        T_frame_part = T_base_frame.inverse() @ self.plan.T_base_part
        return tuple(_steps(self.plan, number, T_frame_part, self.arm) for number in range(len(self.plan.searches)))


def _refuse_unsafe(search: Search) -> None:
    """Refuse a search that is too long, runs away from its face, or does not pass where the contact is planned."""
    if search.stroke_mm > LONGEST_STROKE_MM:
        raise InputError(
            f"search {search.name}: a stroke of {search.stroke_mm:.0f} mm; at most {LONGEST_STROKE_MM:g} mm"
        )
    if not search.direction @ search.normal_part < 0.0:
        raise InputError(f"search {search.name}: it runs away from the face that it should touch")
    along = float((search.planned - search.start) @ search.direction)
    off = float(np.linalg.norm(search.planned - search.start - along * search.direction))
    if not (0.0 < along < search.stroke_mm and off <= OFF_STROKE_MM):
        raise InputError(
            f"search {search.name}: its planned contact is not between its start and its end, to {OFF_STROKE_MM:g} mm"
        )


def _steps(plan: TouchPlan, number: int, T_frame_part: RigidTransform, arm: Arm | None) -> TouchSteps:
    search, R = plan.searches[number], plan.axes(number)
    ends = [search.approach, search.start, search.end, search.retract]
    p = np.concatenate([search.via.reshape(-1, 3), ends]) - plan.standoff_mm * R[:, :, 2]
    return TouchSteps(search, T_frame_part.apply(p), T_frame_part.R @ R, _postures(search, arm))


def _postures(search: Search, arm: Arm | None) -> Posture | None:
    """Return the postures of all poses; at the retract, which is near the start, that of the start."""
    if arm is None or search.joints is None or (len(search.via) and search.via_joints is None):
        return None
    way = [] if search.via_joints is None or not len(search.via_joints) else [search.via_joints]
    return posture(arm, np.concatenate([*way, search.joints, search.joints[1:2]]))
