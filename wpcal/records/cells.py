"""Records: cell, cell-check, place."""

from typing import Annotated, Literal

from msgspec import UNSET, Meta

from wpcal.records.parts import D, Maybe, Neck, NotNegative, Open, Positive, Record, Six, Vector


class Frame(Open):
    xyz_mm: Annotated[Vector, D("Origin of the second frame in the first.")]
    rpy_deg: Annotated[Vector, D("R = Rz(yaw) Ry(pitch) Rx(roll).")]


class Capsule(Open):
    p_mm: Vector
    q_mm: Vector
    radius_mm: Positive


class Shape(Open):
    name: str
    link: Maybe[
        Annotated[
            Annotated[int, Meta(ge=0, le=6)],
            D("Of a body of an arm: 0 the base, i the frame after link i, 6 the flange."),
        ]
    ] = UNSET
    capsules: Annotated[list[Capsule], Meta(min_length=1)]
    hull_mm: Maybe[
        Annotated[list[Vector], D("Corners of the convex body, mm. Without them the body consists of its capsules.")]
    ] = UNSET
    to_part_mm: Maybe[
        Annotated[
            float, D("Safety distance from this body of the torch to the part, mm, if it is not safety_distance_mm.")
        ]
    ] = UNSET


class TorchShape(Record):
    wire_mm: Annotated[NotNegative, D("From the tip of the wire to the mouth of the nozzle.")]
    nozzle_radius_mm: Annotated[NotNegative, D("Outer radius of the nozzle.")]
    length_mm: Annotated[
        NotNegative, D("From the tip of the wire along the centre line to where the wrist has room to turn.")
    ]
    name: Maybe[Annotated[str, D("Name of a shipped torch or of a torch file; stated: sizes given by a program.")]] = (
        UNSET
    )
    mouth_radius_mm: Maybe[
        Annotated[NotNegative, D("Outer radius at the mouth of a conical nozzle. Missing: cylindrical.")]
    ] = UNSET
    taper_mm: Maybe[Annotated[NotNegative, D("Length of the cone of the nozzle.")]] = UNSET
    most_wire_mm: Maybe[
        Annotated[NotNegative, D("The longest wire with which the torch still welds. Missing: wire_mm.")]
    ] = UNSET
    neck: Maybe[Annotated[Neck, D("What is behind the nozzle. Missing: the torch is straight.")]] = UNSET


class Rail(Open):
    direction: Annotated[Vector, D("In world.")]
    min_mm: float
    max_mm: float
    speed_mm_s: Positive
    home_mm: Maybe[float] = UNSET
    touched_at_mm: Maybe[Annotated[float, D("Where the rail was while the part was touched.")]] = UNSET


class TorchRobot(Open):
    arm: Annotated[str, D("Name of a shipped arm, or an arm file beside the cell file.")]
    joint_weights: Maybe[
        Annotated[
            Annotated[list[Positive], Meta(min_length=6, max_length=6)],
            D("K_j of Hou 2018, eq. 4. If not given, they are computed from the joints' speeds."),
        ]
    ] = UNSET
    T_world_base: Frame
    T_flange_tool: Annotated[
        Frame | None,
        D(
            "z of the tool is the wire direction, its origin the wire's tip. Null or missing until it is known; "
            "a plan needs it."
        ),
    ]
    links: Annotated[list[Shape], D("Bodies of the arm.")]
    torch_shape: Maybe[
        Annotated[
            TorchShape,
            D("The torch whose bodies are in torch, as in seams.json. wpcal plan compares it with that of the seams."),
        ]
    ] = UNSET
    torch: Annotated[list[Shape], D("Bodies in the frame tool.")]
    mounting_face_z_mm: Maybe[
        Annotated[
            float,
            D(
                "Height in world at which the arm is mounted, if that is not the floor. wpcal plan compares it "
                "with T_world_base and the arm's mount_mm."
            ),
        ]
    ] = UNSET
    home_deg: Maybe[
        Annotated[
            Six,
            D(
                "Of one robot: joints at which programs start and end. If not given: zero, with joint 5 bent by "
                "90 degrees."
            ),
        ]
    ] = UNSET
    rail: Maybe[
        Annotated[Rail, D("Of one robot: the base moves along this direction; T_world_base is its place at 0.")]
    ] = UNSET


class HolderRobot(Open):
    arm: Annotated[str, D("Name of a shipped arm, or an arm file beside the cell file.")]
    joint_weights: Maybe[
        Annotated[
            Annotated[list[Positive], Meta(min_length=6, max_length=6)],
            D("K_j of Hou 2018, eq. 4. If not given, they are computed from the joints' speeds."),
        ]
    ] = UNSET
    T_world_base: Frame
    T_flange_part: Maybe[
        Annotated[Frame | None, D("The grasp; null or missing until it is known (wpcal calibrate --holder-joints).")]
    ] = UNSET
    links: Annotated[list[Shape], D("Bodies of the arm, with its gripper.")]
    part: Annotated[list[Shape], D("Bodies in the frame part.")]
    mounting_face_z_mm: Maybe[
        Annotated[
            float,
            D(
                "Height in world at which the arm is mounted, if that is not the floor. wpcal plan compares it "
                "with T_world_base and the arm's mount_mm."
            ),
        ]
    ] = UNSET


class Positioner(Open):
    arm: Annotated[str, D("Name of an arm file beside the cell file.")]
    T_world_base: Frame
    links: Maybe[Annotated[list[Shape], D("Bodies: link 0 is the frame, 1 and 2 are moved by the axes.")]] = UNSET
    T_flange_part: Maybe[
        Annotated[Frame | None, D("The part on the positioner. The folder of a calibration replaces it.")]
    ] = UNSET
    home_deg: Maybe[Annotated[list[float], Meta(min_length=1, max_length=2)]] = UNSET
    touched_at_deg: Maybe[
        Annotated[
            Annotated[list[float], Meta(min_length=1, max_length=2)],
            D("Where the axes were while the part was touched; 0 if it is not given."),
        ]
    ] = UNSET


class Cell(Open):
    """wpcal cell, version 1

    One robot with a torch, or two robots (holder_robot), their tools and part, and what is around them. Frames:
    world (z up), base1, base2, flange1, flange2, tool, part. Lengths in mm, angles in degrees.
    """

    schema: Literal["wpcal/cell/1"]
    name: str
    source: Maybe[Annotated[str, D("Where the numbers come from, especially those of the bodies.")]] = UNSET
    safety_distance_mm: Annotated[NotNegative, D("d1 of Hou 2018, eq. 6.")]
    torch_robot: TorchRobot
    holder_robot: Maybe[HolderRobot] = UNSET
    positioner: Maybe[
        Annotated[
            Positioner,
            D(
                "Carries the part of one robot. Its axes are an arm file with one or two joints; the part is on "
                "its flange."
            ),
        ]
    ] = UNSET
    T_world_part: Maybe[
        Annotated[
            Frame | None,
            D("The fixed part of one robot, without a positioner. The folder of a calibration replaces it."),
        ]
    ] = UNSET
    bench: Maybe[Annotated[list[Shape], D("Bodies in the frame world.")]] = UNSET
    floor_z_mm: Maybe[Annotated[float, D("Height of the floor in world; 0 if it is not given.")]] = UNSET


class Issue(Record):
    code: str
    message: str
    ids: list[str]


class CellCheck(Record):
    """What is odd in a cell of two robots (wpcal plan --check --json)"""

    schema: Literal["wpcal/cell-check/1"]
    cell: str
    issues: Annotated[
        list[Issue], D("What is odd in the cell: bodies, frames and mounting faces (wpcal plan --check).")
    ]


class Best(Record):
    x_mm: float
    y_mm: float
    turn_deg: Annotated[float, D("Of the part about the vertical.")]
    share: float


class Place(Record):
    """How much of the seams a robot reaches over a grid of places"""

    schema: Literal["wpcal/place/1"]
    cell: str
    moved: Annotated[Literal["part", "robot"], D("What is moved: part (with its positioner) or robot.")]
    now_share: Annotated[float, D("Where the cell has it: part of the length of all seams that is reachable, 0 to 1.")]
    best: Best
    x_mm: Annotated[list[float], D("Moves in world: rows of turn_deg and share.")]
    y_mm: Annotated[list[float], D("Moves in world: columns of turn_deg and share.")]
    turn_deg: list[list[float]]
    share: list[list[float]]
