"""Records: program, export, ros-sidecar, compas, formats, audit."""

from typing import Annotated, Any, Literal

from msgspec import Meta

from wpcal.core.record_types.parts import (
    Count,
    D,
    Matrix,
    MatrixByRows,
    Maybe,
    NotNegative,
    Number,
    Positive,
    Quaternion,
    Record,
    Rotation,
    Text,
    Vector,
)


class Units(Record):
    length: Literal["mm"]
    angle: Literal["deg"]
    speed: Literal["mm/s"]


class Torch(Record):
    work_angle_deg: float = D("Where a seam leans by no other angles; the poses have them all.")
    travel_angle_deg: float
    standoff_mm: NotNegative


class Motion(Record):
    speed_mm_s: Positive = D("Where a seam has no other `speed_mm_s`.")
    air_speed_mm_s: Positive


class Pose(Record):
    role: Literal["to", "approach", "weld", "retract", "from"] = D(
        "to and from: on the way to and from the seam; approach and retract: before and after it, along the wire."
    )
    p_mm: Vector = D("Tool centre point in base, mm.")
    R: Rotation = D("Rows of the rotation; its columns are the axes of the tool in `frame`.")
    q_xyzw: Quaternion = D("The same rotation as a unit quaternion, w >= 0.")
    u95_mm: NotNegative | None = D(
        "Error of the position that is not exceeded with 95 % probability, mm; null for approach and retract."
    )


class Seam(Record):
    name: str
    joint: Literal["tee", "lap", "butt", "corner", "edge", "unknown"]
    weld: Literal["fillet", "groove", "flare-bevel groove", "flare-V groove", "unknown"]
    closed: bool
    length_mm: NotNegative
    speed_mm_s: Positive = D("Of the wire along it.")
    weld_data: Maybe[dict[str, Any]] = D("The values of the weld data, as in welds.json, if it was given (--welds).")
    poses: Annotated[list[Pose], Meta(min_length=4)]


class SafePoint(Record):
    p_mm: Vector = D("Tool centre point in base, mm.")
    R: Rotation = D("Rows of the rotation; its columns are the axes of the tool in `frame`.")
    q_xyzw: Quaternion = D("The same rotation as a unit quaternion, w >= 0.")


class Program(Record):
    """wpcal program, version 1

    Poses of a welding tool along calibrated seams.
    """

    schema: Literal["wpcal/program/1"]
    about: list[str]
    frame: Literal["base"]
    units: Units
    wire_axis: Literal["+z", "+x"] = D("The tool's axis along which the wire leaves the tip.")
    z_sense: Literal["inward"] = D("The wire axis points into the joint.")
    T_base_part: Matrix
    torch: Torch
    motion: Motion
    seams: list[Seam]
    safe_point: SafePoint | None = D("Where the program starts and ends; null if it has no such point.")


class Move(Record):
    seam: str = D("Name of the seam.")
    lines: Count = D("Number of linear moves along it.")
    arcs: Count = D("Number of circular moves along it.")
    off_mm: Maybe[NotNegative] = D(
        "Largest distance of the wire's tip from the seam, mm; absent where every point is written."
    )
    off_deg: Maybe[NotNegative] = D(
        "Largest angle of the wire from its direction at the seam, deg; absent where every point is written."
    )


class Export(Record):
    """wpcal export, version 1

    What wpcal export wrote (wpcal export --json).
    """

    schema: Literal["wpcal/export/1"]
    verdict: Maybe[str | None] = D("Verdict of the calibration, as in calibration.json.")
    checked: Maybe[list[str]] = D("What was checked before the programs were written, in sentences.")
    seams: list[str] = D("Names of the seams, in the order of the programs.")
    left_out: Maybe[list[dict[str, str]]] = D("Seams that were asked for and not written: name (seam), reason (why).")
    searches: Maybe[list[str]] = D("Names of the searches of a plan of touches, in the order of the programs.")
    fingerprint: Maybe[Annotated[str, Meta(pattern="^[0-9a-f]{8}$")]] = D("Of the plan of touches.")
    setup: Maybe[str] = D("The touch setup: its file, or that its defaults were used.")
    files: dict[str, list[str]] = D("Paths of the written files, by format.")
    moves: Maybe[dict[str, list[Move]]] = D("The moves along each seam, by format, in the order of the programs.")
    no_program: Maybe[dict[str, str]] = D("Of a plan: why there is no program, by the language.")
    not_checked: str = D("What nobody compared with anything, in words.")


class RosSidecarUnits(Record):
    length: Literal["m"]
    quaternion: Literal["xyzw"]


class RosSidecarSeam(Record):
    name: str
    file: str = D("The PoseArray file of this seam.")
    what: str = D("The seam in words.")
    closed: bool
    weld_speed_m_s: Positive
    roles: Annotated[list[Literal["to", "approach", "weld", "retract", "from"]], Meta(min_length=4)] = D(
        "One role per pose."
    )
    error_95_m: list[NotNegative | None] | None = D("One value per pose, null in the air; null if unknown.")


class Position(Record):
    x: float
    y: float
    z: float


class Orientation(Record):
    x: float
    y: float
    z: float
    w: float


class RosSidecarSafePoint(Record):
    position: Position
    orientation: Orientation


class RosSidecar(Record):
    """wpcal sidecar for ROS, version 1

    Names, roles and predicted errors of the poses in the PoseArray files (NAME.sidecar.yaml). Lengths in m.
    """

    schema: Literal["wpcal/ros-sidecar/1"]
    message: Literal["geometry_msgs/msg/PoseArray"]
    frame_id: Literal["base"]
    units: RosSidecarUnits
    wire_axis: Literal["+x", "+z"] = D("Axis of the tool along the wire.")
    z_sense: Literal["inward"] = D("The tool's z points into the joint.")
    seams: Annotated[list[RosSidecarSeam], Meta(min_length=1)]
    safe_point: Maybe[Annotated[list[RosSidecarSafePoint], Meta(min_length=1, max_length=1)]] = D(
        "Where the program starts and ends: one pose."
    )


class CompasUnits(Record):
    length: Literal["mm"]


class Data(Record):
    point: Vector
    xaxis: Vector
    yaxis: Vector


class Frame(Record):
    """A frame of the tool in base, as COMPAS reads it; mm."""

    dtype: Literal["compas.geometry/Frame"]
    data: Data


class CompasSeam(Record):
    name: str
    what: str = D("The seam in words.")
    to_seam: list[Frame] = D("On the way, joined by linear moves.")
    approach: Frame
    weld: Annotated[list[Frame], Meta(min_length=2)]
    retract: Frame
    from_seam: list[Frame] = D("On the way, joined by linear moves.")
    error_95_mm: list[NotNegative] | None = D(
        "Error at each weld frame that is not exceeded with 95 % probability; null if unknown."
    )


class Compas(Record):
    """wpcal frames for COMPAS, version 1

    Weld paths as frames that compas.json_load reads (NAME.compas.json). Tool frames in base, lengths in mm.
    """

    schema: Literal["wpcal/compas/1"]
    about: list[str] = D("What the file is, line by line.")
    frame: Literal["base"]
    units: CompasUnits
    wire_axis: Literal["+x", "+z"] = D("Axis of the tool along the wire.")
    z_sense: Literal["inward"] = D("The tool's z points into the joint.")
    seams: Annotated[list[CompasSeam], Meta(min_length=1)]
    safe_point: Frame | None = D("Where the program starts and ends; null if it has no such point.")


class Formats(Record):
    """wpcal export formats, version 1

    Formats that wpcal export can write (wpcal export -f list --json).
    """

    schema: Literal["wpcal/formats/1"]
    formats: dict[str, str] = D("One sentence per format, by name.")


class Fault(Record):
    line: Number | None = D("Line in the file, counted from 1.")
    column: str | int | None = D("Name of the column, or its place counted from 1.")
    field: str | None = D("Place in a record, or the point of a program.")
    message: Text
    code: str
    repair: str | None = D("What --fix writes instead; null if a person must decide.")


class File(Record):
    path: str
    kind: str = D("What the file is, in words, or the name of its schema.")
    checked: str = D("What the poses of a program were compared with; empty for other files.")
    faults: list[Fault]


class Audit(Record):
    """wpcal audit, version 1

    The faults of files, with their places (wpcal audit --json).
    """

    schema: Literal["wpcal/audit/1"]
    faults: Count = D("Number of faults of all files.")
    files: list[File]
    not_audited: list[str] = D("Files of kinds that wpcal neither reads nor writes, or does not read back.")
    repaired: list[str] = D("Place and words of each repair that --fix made.")


class CommonMotion(Record):
    what: Literal["frame", "tool"]
    T: MatrixByRows = D("frame: new = T old; tool: new = old T.")


class ToolNames(Record):
    written: list[str]
    changed: list[str]


class CorrectedPoint(Record):
    seam: str
    place: str = D("File and line in the changed program.")
    p_base_mm: Vector = D("Where it was, before the frame or the tool was changed.")
    moved_mm: Vector = D("From there, in base.")
    in_seam_mm: Vector = D("The same along x, y and z of the seam.")
    along_mm: float = D("Of that, along the seam.")
    across_mm: NotNegative
    is_added: bool
    is_end: bool = D("Whether a weld begins or ends there.")
    is_used: bool = D("False: --set-aside.")
    is_exception: bool = D("Whether it contradicts the other corrections.")


class KindOffset(Record):
    kind: str = D("Kind of seam, or all seams.")
    y_mm: float = D("In the axes of the seam.")
    z_mm: float
    sigma_mm: list[NotNegative] = D("Standard deviations of both.")


class TouchedUpSeam(Record):
    seam: str
    corrected: Count = D("Points.")
    was_off_mm: NotNegative = D("How far the program as written was off, at most, as far as is known now.")
    error_95_before_mm: NotNegative | None = D("As the calibration stated it.")
    error_95_mm: NotNegative = D("Error that is not exceeded with 95 % probability after the corrections.")
    says: Text


class TouchedUpLine(Record):
    place: str = D("File and line in the changed program.")
    seam: str = D("Empty off the seams.")
    what: Literal["by hand: kept", "by hand: smoothed", "by hand, an exception: kept", "moved with its seam"]
    mm: NotNegative


class TouchUp(Record):
    """wpcal touch-up, version 1

    Points corrected on the pendant, and what they say of every seam (wpcal touchup; touchup.json).
    """

    schema: Literal["wpcal/touchup/1"]
    part: Maybe[str | None] = D("SHA-256 of the STEP file.")
    common: CommonMotion | None = D("By which most poses moved together.")
    tools: ToolNames
    points: list[CorrectedPoint]
    deleted: list[str] = D("Files and lines of the program as written.")
    unread: list[str] = D("Lines of the changed program that were not followed.")
    hand_mm: Positive | None = D("Error of a correction per axis, stated or found.")
    robot_mm: NotNegative | None = D("Amplitude of the robot's own error that explains them best.")
    bodies: list[str] = D("Bodies that moved against the others.")
    offsets: list[KindOffset] = D("Offsets that the person prefers.")
    seams: list[TouchedUpSeam]
    proposals: list[str] = D("What was corrected the same way on earlier parts too (--earlier).")
    lines: list[TouchedUpLine] = D("What is written for each pose that is not as wpcal wrote it.")
    not_free: Maybe[list[str]] = D("Why the program that was written is not called checked, by file and line.")
    sentences: list[str] = D("What a person should know.")
