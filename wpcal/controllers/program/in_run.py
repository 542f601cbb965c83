r"""Touch and weld in one run: the program corrects the frame of its seams by what the searches find.

The fit is that of the plan, in Newton steps. With the correction :math:`T_k` so far, the place p of a contact is
:math:`T_k^{-1} p` in the part, and :math:`d_i` is how far it is from the face as planned, along its normal. The next
step turns the part by :math:`\sum_i d_i\,w_i` about the middle of the searches, and displaces it by
:math:`\sum_i d_i\,v_i`. The gains are constants of the plan, :math:`(H^\top W H)^{-1} H^\top W`
(`wpcal.touch.plan.choose.TouchDesign`). A program ends before the first weld where a search missed, a residual is
larger than its errors explain, or the last step is not small.

In two stages the searches of a first plan, on large faces, correct the frame in which those of the second run. What the
first does not see stays as it was planned; the second corrects the frame once more.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wpcal.controllers.program.weld_program import SafePoint, WeldProgram
from wpcal.core.arrays import FloatArray
from wpcal.core.transform import RigidTransform

STEPS = 12  #: Each leaves a third of what was left at most: normals of a hole turn by as much as it is off.
SETTLED_MM = 0.01  #: The last step displaces by less.


@dataclass(frozen=True, slots=True, eq=False)
class Term:
    """What one search adds to the correction, in `part`."""

    name: str  #: As programs write it.
    planned: FloatArray  #: shape (3,). The tip of the wire at contact where the part stands as planned, mm.
    normal: FloatArray  #: shape (3,).
    shift: FloatArray  #: shape (3,). Displacement per mm of deviation.
    turn: FloatArray  #: shape (3,). Turn per mm of deviation, rad.
    axis: FloatArray | None  #: shape (2, 3). A point of the axis of a round face, and its direction; None: flat.
    most_off_mm: float  #: The largest residual.
    ahead: FloatArray  #: shape (3,). From the stored place, the tool centre point, to the tip of the wire, mm.

    @property
    def radius_mm(self) -> float:
        """The distance of the planned place from the axis, negative where the normal points to it."""
        assert self.axis is not None
        away = self.planned - self.axis[0]
        away = away - (away @ self.axis[1]) * self.axis[1]
        return float(np.copysign(np.linalg.norm(away), away @ self.normal))


@dataclass(frozen=True, slots=True, eq=False)
class Correction:
    """The linear fit of a plan of touches."""

    terms: tuple[Term, ...]
    centre: FloatArray  #: shape (3,). About which the part turns, in `part`, mm.
    key: str = ""  #: Ends the names of programs where two stages each have a correction.


@dataclass(frozen=True, slots=True, eq=False)
class WeldsAfter:
    """The weld program that runs after the searches."""

    program: WeldProgram
    correction: Correction
    #: Poses from the last search to the safe point of the program, with the part as planned; none from a home.
    way: SafePoint | None
    T_base_part: RigidTransform  #: The place of the plan.
    first: Correction | None = None  #: That of the first of two stages; `correction` goes on from it.

    @property
    def corrections(self) -> tuple[Correction, ...]:
        """The corrections in their order."""
        return (self.correction,) if self.first is None else (self.first, self.correction)

    @property
    def stage(self) -> int:
        """How many searches the first of two stages has; 0 where there is one."""
        return 0 if self.first is None else len(self.first.terms)
