"""The axes of a sequence with times: a ``trajectory_msgs/JointTrajectory`` of ROS 2 as YAML, and states of Tesseract.

References: REP 103 (units and conventions), trajectory_msgs/msg/JointTrajectory. tesseract_robotics: StateWaypoint,
MoveInstruction, CompositeInstruction.
"""

from __future__ import annotations

from pathlib import Path

from wpcal.core.version import __version__
from wpcal.planning.plan.run import Phase
from wpcal.planning.sequence.timeline import Timeline
from wpcal.planning.sequence.weld_sequence import WeldSequence

DECIMALS = 9  #: 1e-9 rad moves a point at 2 m by 2e-6 mm; 1e-9 m is 1e-6 mm.
NANO = 10**9
MM = 1e-3
BUILD = "\n" + Path(__file__).with_name("tesseract.txt").read_text(encoding="ascii")


def joint_trajectory(sequence: WeldSequence, line: Timeline) -> str:
    """Return ``trajectory.yaml`` of a sequence: angles in rad, a rail in m; points as in ``plan.csv``."""
    names, rows = _states(sequence, line)
    points = []
    for q, t in rows:
        seconds, nano = divmod(round(t * NANO), NANO)
        positions = ", ".join(f"{value:.{DECIMALS}f}" for value in q)
        points.append(f"- positions: [{positions}]\n  time_from_start: {{sec: {seconds}, nanosec: {nano}}}")
    head = ["header:", "  stamp: {sec: 0, nanosec: 0}", '  frame_id: ""']
    listed = ", ".join(f'"{name}"' for name in names)
    return "\n".join([*head, f"joint_names: [{listed}]", "points:", *points, ""])


def tesseract_states(sequence: WeldSequence, line: Timeline) -> str:
    """Return the states of a sequence for Tesseract.

    Returns: ``trajectory_tesseract.py``: a Python module with a function `build` that gives a CompositeInstruction of
    state waypoints with times; angles in rad, a rail in m.
    """
    names, rows = _states(sequence, line)
    states = [
        f"    ({t:.{DECIMALS}f}, ({', '.join(f'{value:.{DECIMALS}f}' for value in q)}), {phase is Phase.WELD}),"
        for (q, t), phase in zip(rows, line.phase, strict=True)
    ]
    head = [f"# written by wpcal {__version__}: time s, axes in rad (a rail in m), whether the arc burns"]
    listed = ", ".join(ascii(name) for name in names)
    return "\n".join([*head, f"JOINTS = [{listed}]", "STATES = [", *states, "]"]) + BUILD


def _states(sequence: WeldSequence, line: Timeline) -> tuple[tuple[str, ...], list[tuple[list[float], float]]]:
    """Return the names of the axes, and their values with the time of every state: rad and m, s."""
    cell = sequence.cell
    factors = [MM if column == cell.rail_axis else 1.0 for column in range(len(cell.axis_names))]
    return cell.axis_names, list(zip((line.q * factors).tolist(), line.t_s.tolist(), strict=True))
