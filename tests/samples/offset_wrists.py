"""Arms without a spherical wrist, from public tables of Denavit-Hartenberg parameters.

UR5e, UR10e: Universal Robots, DH parameters for calculations of kinematics and dynamics (support article), and
``config/*/default_kinematics.yaml`` of UniversalRobots/Universal_Robots_ROS2_Description, commit 2221ec0.
CRX-10iA: Abbes, Poisson 2024, Geometric approach for inverse kinematics of the FANUC CRX collaborative robot, table 1;
origins, axes, limits and speeds as in ``crx10ia_urdf_macro.xacro`` of FANUC-CORPORATION/fanuc_description, commit
250d3fa, with which its forward kinematics agree to 1e-12 mm (J3 is counted from the upper arm, as there).
"""

import numpy as np

from wpcal.robot.kinematics.arm import Arm, Joint
from wpcal.robot.kinematics.forward import MDHChain


def universal(name: str, d: list[float], a: list[float]) -> Arm:
    """Return an arm of Universal Robots; `d` of joints 1, 4, 5, 6 and `a` of joints 2 and 3, mm."""
    alpha = np.radians([90.0, 0.0, 0.0, 90.0, -90.0, 0.0])
    chain = MDHChain(
        [0.0] * 6,
        [d[0], 0.0, 0.0, *d[1:]],
        [0.0, *a, 0.0, 0.0, 0.0],
        alpha,
        [0.0] * 6,
        (False, True, True, False, False, False),
    )
    names = ("base", "shoulder", "elbow", "wrist_1", "wrist_2", "wrist_3")
    return Arm(name, chain, tuple(Joint(each, 1, -2 * np.pi, 2 * np.pi, np.pi) for each in names))


def ur5e() -> Arm:
    """Return the UR5e."""
    return universal("UR5e", [162.5, 133.3, 99.7, 99.6], [-425.0, -392.2])


def ur10e() -> Arm:
    """Return the UR10e."""
    return universal("UR10e", [180.7, 174.15, 119.85, 116.55], [-612.7, -571.55])


def crx10ia() -> Arm:
    """Return the CRX-10iA; its base is at the height of axis 2."""
    theta, alpha = np.radians([[0, -90, 0, 0, 0, 0], [-90, 180, -90, 90, -90, 180]])
    d, a = [0, 0, 0, -540, 150, -160], [0, 540, 0, 0, 0, 0]
    chain = MDHChain(theta, d, a, alpha, [0.0] * 6, (False, True, False, False, False, False))
    limits = [(-190, 190), (-179.9, 179.9), (-71, 251), (-190, 190), (-179.9, 179.9), (-225, 225)]
    speeds = np.radians([120, 120, 180, 180, 180, 180]).tolist()
    ranges = zip(np.radians(limits).tolist(), speeds, strict=True)
    joints = (Joint(f"J{row}", 1, low, high, speed) for row, ((low, high), speed) in enumerate(ranges, 1))
    return Arm("CRX-10iA", chain, tuple(joints))
