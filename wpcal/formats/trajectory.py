"""ROS 2: the axes of a sequence with times as one ``trajectory_msgs/JointTrajectory``, as YAML.

References
----------
REP 103 (units and conventions), trajectory_msgs/msg/JointTrajectory.
"""

from __future__ import annotations

from wpcal.planning.sequence.timeline import Timeline
from wpcal.planning.sequence.weld_sequence import WeldSequence

DECIMALS = 9
"""1e-9 rad moves a point at 2 m by 2e-6 mm; 1e-9 m is 1e-6 mm."""
NANO = 10**9
MM = 1e-3


def joint_trajectory(sequence: WeldSequence, line: Timeline) -> str:
    """Return the trajectory of a sequence.

    Parameters
    ----------
    sequence : WeldSequence
    line : Timeline
        Of the sequence.

    Returns
    -------
    str
        ``trajectory.yaml``: angles in rad, a rail in m; points as in ``plan.csv``.
    """
    cell = sequence.cell
    factors = [MM if column == cell.rail_axis else 1.0 for column in range(len(cell.axis_names))]
    rows = []
    for q, t in zip((line.q * factors).tolist(), line.t_s.tolist(), strict=True):
        seconds, nano = divmod(round(t * NANO), NANO)
        positions = ", ".join(f"{value:.{DECIMALS}f}" for value in q)
        rows.append(f"- positions: [{positions}]\n  time_from_start: {{sec: {seconds}, nanosec: {nano}}}")
    head = ["header:", "  stamp: {sec: 0, nanosec: 0}", '  frame_id: ""']
    names = ", ".join(f'"{name}"' for name in cell.axis_names)
    return "\n".join([*head, f"joint_names: [{names}]", "points:", *rows, ""])
