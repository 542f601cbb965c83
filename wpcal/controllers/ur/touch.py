"""Universal Robots: one URScript program ``NAME_touch.script`` that touches the part.

A thread moves; the program watches the input in every cycle of the controller, takes the pose when the input comes,
ends the thread and stops the robot. Results are lines of the log (``textmsg``), and are sent to a socket if the touch
setup names a computer.

References: Universal Robots, The URScript Programming Language (threads, get_actual_tcp_pose, stopl, textmsg, sockets,
popup).
"""

from __future__ import annotations

import re

from wpcal.controllers.language.rounding import texts
from wpcal.controllers.language.touch import Numbers, TouchWriter
from wpcal.controllers.program.touch_program import TouchProgram, TouchSteps
from wpcal.controllers.ur.write import (
    DECIMALS,
    JOINT_LIMITS,
    LONGEST_COMMENT,
    MM,
    NAMES,
    limits,
    poses_in_part,
    poses_of,
    script_frame,
)
from wpcal.core.errors import InputError

STOP_M_S2 = 2.0  #: Deceleration at contact: from 10 mm/s within 0.03 mm.
HOST = re.compile(r"[A-Za-z0-9.:_-]+")  #: The name or the address of a computer.


def write_touch_urscript(program: TouchProgram) -> dict[str, str]:
    """Write a URScript program of searches, ``NAME_touch.script``.

    Raises `InputError` when the robot has no such input or output, or the results cannot be sent to such a computer.
    """
    return _ScriptTouches(program).files()


class _ScriptTouches(TouchWriter):
    format, names, longest_comment = "urscript", NAMES, LONGEST_COMMENT
    inputs = outputs = Numbers(default=0, most=7, least=0)
    first = JOINT_LIMITS
    frame_as_written = staticmethod(script_frame)

    def points_of(self, steps: TouchSteps, first: int) -> list[str]:
        return poses_in_part(steps.p, steps.R)

    speed_of = staticmethod(limits)

    def files(self) -> dict[str, str]:
        host, port = self.setup.urscript.results_host, self.setup.urscript.results_port
        if host and not HOST.fullmatch(host):
            what = f"results_host = {host!r} of the touch setup"
            raise InputError(f"{what}: expected the name or the address of a computer")
        sent = f", and sent to {host}:{port}" if host else ""
        joints = self.plan.home_joints
        at = "" if joints is None else f"[{', '.join(texts(joints[None], DECIMALS)[0])}]"
        lines = self.lines(
            "touch",
            header=self.header(f"digital input {self.signal}", self._about(sent)),
            frame=poses_of(self.frame.t_mm[None], self.frame.R[None])[0],
            signal=self.signal,
            acceleration=limits(1.0).partition(",")[0],
            near=f"{self.setup.approach_speed_mm_s * MM:g}",
            search=f"{self.setup.search_speed_mm_s * MM:g}",
            stop_m_s2=f"{STOP_M_S2:g}",
            host=host,
            port=port,
            home=self.home(at, JOINT_LIMITS),
            **self.sensing(self.signal, self.enable),
        )
        return {f"{self.name}.script": "\n".join([*lines, ""])}

    def _about(self, to: str) -> list[str]:
        fingerprint = self.plan.fingerprint
        return [
            f"results: lines of the log that begin with wpcal {fingerprint}{to}: keep them as a text file",
            "poses are relative to wp_part, the part as planned; m and rotation vectors in rad",
            "set the tool centre point before this program",
        ]
