"""Records: cell, cell-check, place."""

from typing import Annotated, Literal

from msgspec import Meta

from wpcal.core.record_types import parts
from wpcal.core.record_types.parts import D, Maybe, NotNegative, Open, Positive, Record, Six, TorchShape, Vector


class Frame(Open):
    xyz_mm: Vector = D("Origin of the second frame in the first.")
    rpy_deg: Vector = D("R = Rz(yaw) Ry(pitch) Rx(roll).")


class Capsule(Open):
    p_mm: Vector
    q_mm: Vector
    radius_mm: Positive


class Shape(Open):
    name: str
    link: Maybe[Annotated[int, Meta(ge=0, le=6)]] = D(
        "Of a body of an arm: 0 the base, i the frame after link i, 6 the flange."
    )
    capsules: Annotated[list[Capsule], Meta(min_length=1)]
    hull_mm: Maybe[list[Vector]] = D("Corners of the convex body, mm. Without them the body consists of its capsules.")
    to_part_mm: Maybe[float] = D(
        "Safety distance from this body of the torch to the part, mm, if it is not safety_distance_mm."
    )


class Rail(Open):
    direction: Vector = D("In world.")
    min_mm: float
    max_mm: float
    speed_mm_s: Positive
    home_mm: Maybe[float]
    touched_at_mm: Maybe[float] = D("Where the rail was while the part was touched.")


class CellRobot(Open):
    arm: str = D("Name of a shipped arm, or an arm file beside the cell file.")
    joint_weights: Maybe[Annotated[list[Positive], Meta(min_length=6, max_length=6)]] = D(
        "K_j of Hou 2018, eq. 4. If not given, they are computed from the joints' speeds."
    )
    T_world_base: Frame
    home_deg: Maybe[Six] = D(
        "Joints at which programs start and end. If not given: of one robot zero, with joint 5 bent by 90 degrees; of "
        "two robots the way to the first point is not swept."
    )
    mounting_face_z_mm: Maybe[float] = D(
        "Height in world at which the arm is mounted, if that is not the floor. wpcal plan compares it with "
        "T_world_base and the arm's mount_mm."
    )


class TorchRobot(CellRobot):
    T_flange_tool: Frame | None = D(
        "z of the tool is the wire direction, its origin the wire's tip. Null or missing until it is known; a plan "
        "needs it."
    )
    links: list[Shape] = D("Bodies of the arm.")
    torch_shape: Maybe[TorchShape] = D(
        "The torch whose bodies are in torch, as in seams.json. wpcal plan compares it with that of the seams."
    )
    torch: list[Shape] = D("Bodies in the frame tool.")
    rail: Maybe[Rail] = D("Of one robot: the base moves along this direction; T_world_base is its place at 0.")


class HolderRobot(CellRobot):
    T_flange_part: Maybe[Frame | None] = D("The grasp; null or missing until known (wpcal calibrate --holder-joints).")
    links: list[Shape] = D("Bodies of the arm, with its gripper.")
    part: list[Shape] = D("Bodies in the frame part.")


class Positioner(Open):
    arm: str = D("Name of an arm file beside the cell file.")
    T_world_base: Frame
    links: Maybe[list[Shape]] = D("Bodies: link 0 is the frame, 1 and 2 are moved by the axes.")
    T_flange_part: Maybe[Frame | None] = D("The part on the positioner. The folder of a calibration replaces it.")
    home_deg: Maybe[Annotated[list[float], Meta(min_length=1, max_length=2)]]
    touched_at_deg: Maybe[Annotated[list[float], Meta(min_length=1, max_length=2)]] = D(
        "Where the axes were while the part was touched; 0 if it is not given."
    )


class Cell(Open):
    """wpcal cell, version 1

    One robot with a torch, or two robots (holder_robot), their tools and part, and what is around them. Frames:
    world (z up), base1, base2, flange1, flange2, tool, part. Lengths in mm, angles in degrees.
    """

    schema: Literal["wpcal/cell/1"]
    name: str
    source: Maybe[str] = D("Where the numbers come from, especially those of the bodies.")
    safety_distance_mm: NotNegative = D("d1 of Hou 2018, eq. 6.")
    torch_robot: TorchRobot
    holder_robot: Maybe[HolderRobot]
    positioner: Maybe[Positioner] = D(
        "Carries the part of one robot. Its axes are an arm file with one or two joints; the part is on its flange."
    )
    T_world_part: Maybe[Frame | None] = D(
        "The fixed part of one robot, without a positioner. The folder of a calibration replaces it."
    )
    bench: Maybe[list[Shape]] = D("Bodies in the frame world.")
    floor_z_mm: Maybe[float] = D("Height of the floor in world; 0 if it is not given.")


class Issue(Record):
    code: str
    message: str
    ids: list[str]


class CellCheck(Record):
    """What is odd in a cell of two robots (wpcal plan --check --json)"""

    schema: Literal["wpcal/cell-check/1"]
    cell: str
    issues: list[Issue] = D("What is odd in the cell: bodies, frames and mounting faces (wpcal plan --check).")


class Best(Record):
    x_mm: float
    y_mm: float
    height_mm: Maybe[float] = D("Up in world.")
    turn_deg: float = D("Of the part about the vertical.")
    share: float
    at: Maybe[parts.Place] = D("Where the part, its positioner or the robot then is in world.")


class Place(Record):
    """How much of the seams a robot reaches over a grid of places"""

    schema: Literal["wpcal/place/1"]
    cell: str
    moved: Literal["part", "robot"] = D("What is moved: part (with its positioner) or robot.")
    now_share: float = D("Where the cell has it: part of the length of all seams that is reachable, 0 to 1.")
    best: Best
    x_mm: list[float] = D("Moves in world: rows of turn_deg and share.")
    y_mm: list[float] = D("Moves in world: columns of turn_deg and share.")
    height_mm: Maybe[list[list[float]]] = D("Another than 0 only where more is reachable than anywhere at 0.")
    turn_deg: list[list[float]]
    share: list[list[float]]
