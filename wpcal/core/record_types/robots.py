"""Records: arm, torch, torches, tool, identification, pose-plan, corrected."""

from typing import Annotated, Literal

from msgspec import Meta

from wpcal.core.record_types.parts import (
    Count,
    D,
    Issue,
    Maybe,
    NotNegative,
    Number,
    Place,
    Positive,
    Record,
    Rotation,
    Share,
    Space,
    ToolError,
    TorchShape,
    Vector,
)

LINKS = D("Modified Denavit-Hartenberg parameters, one link per joint, from the base.")


class Link(Record):
    theta_deg: float = D("Offset of the joint angle.")
    d_mm: float
    a_mm: float
    alpha_deg: float
    beta_deg: Maybe[float] = D("Hayati's angle for parallel axes; 0 if not given.")
    parallel_to_next: Maybe[bool] = D("Whether beta replaces d for this axis.")


class Joint(Record):
    name: str
    sign: Maybe[Literal[1, -1]] = D("Direction of the shown angle against the model's; 1 if not given.")
    min_deg: float = D("Lower limit of the shown angle.")
    max_deg: float = D("Upper limit of the shown angle.")
    speed_deg_s: Maybe[Annotated[float, Meta(ge=0.001)] | None] = D("Largest speed; null if unknown.")
    pulses_per_deg: Maybe[float | None] = D("Encoder pulses; null if unknown.")


class Coupling(Record):
    joint: str
    adds: str = D("Name of the joint whose shown angle is added.")
    factor: float


class Nominal(Record):
    links: Annotated[list[Link], Meta(min_length=1)] = LINKS
    T_base_dh0: Maybe[Place] = D("Frame before the first link, in base; identity if not given.")
    T_dhn_flange: Maybe[Place] = D("Flange in the frame of the last link; identity if not given.")


class Arm(Record):
    """wpcal robot arm, version 1

    An arm's kinematics (arm files, identified.json). Lengths in mm, angles in degrees.
    """

    schema: Literal["wpcal/arm/1"]
    name: str
    source: Maybe[str] = D("Where the numbers come from.")
    licence: Maybe[str] = D("Licence of the source.")
    robot_space: Space
    links: Annotated[list[Link], Meta(min_length=1)] = LINKS
    T_base_dh0: Maybe[Place] = D("Frame before the first link, in base; identity if not given.")
    T_dhn_flange: Maybe[Place] = D("Flange in the frame of the last link; identity if not given.")
    joints: Annotated[list[Joint], Meta(min_length=1)]
    couplings: Maybe[list[Coupling]] = D("Joints whose model angle depends on another joint.")
    mount_mm: Maybe[Vector] = D("Mounting face in base, mm.")
    notes: Maybe[list[str]]
    nominal: Maybe[Nominal] = D("The controller's own kinematics, in the file of an identified arm.")
    unseen_tool_mm: Maybe[NotNegative] = D(
        "How far a tool centre point taught in the controller may be off in this arm (95 %), where the last link "
        "stayed nominal, mm."
    )


class Wire(Record):
    usual_mm: Positive = D("As it is set usually.")
    most_mm: Maybe[Positive] = D("The longest with which the torch still welds. Missing: the usual one.")


class Nozzle(Record):
    diameter_mm: Positive = D("Outer diameter of the nozzle.")
    mouth_diameter_mm: Maybe[Positive] = D("Outer diameter at the mouth of a conical nozzle.")
    taper_mm: Maybe[Positive] = D("Length of the cone.")


class Neck(Record):
    angle_deg: Annotated[float, Meta(ge=0, le=180)] = D("By how much the neck bends away from the wire.")
    from_mouth_mm: Positive = D("From the mouth of the nozzle to where the bend begins.")
    bend_radius_mm: NotNegative = D("Radius of the centre line of the bend.")
    diameter_mm: Positive = D("Outer diameter of the neck.")
    body_from_mm: Positive = D("From the mouth along the centre line to where the body begins.")
    body_diameter_mm: Positive = D("Outer diameter of the body.")


class Torch(Record):
    """wpcal torch, version 1

    The shape of a welding torch: what `--torch FILE` reads. Lengths in mm, outer diameters.
    """

    schema: Literal["wpcal/torch/1"]
    title: str = D("What it is, for people.")
    source: Maybe[str] = D("Where the sizes come from, in words.")
    rank: Maybe[Number] = D("Among the shipped torches: the most usual one has 1.")
    wire: Wire = D("Wire between its tip and the mouth of the nozzle.")
    nozzle: Nozzle
    neck: Maybe[Neck] = D("What is behind the nozzle. Missing: the torch has one diameter to its end.")
    length_mm: Positive = D("From the tip of the wire along the centre line to where the wrist has room to turn.")


class Torches(Record):
    """wpcal torches, version 1

    Torches as `wpcal torches --json` lists them.
    """

    schema: Literal["wpcal/torches/1"]
    torches: list[Annotated[TorchShape, D("One torch; lengths in mm, outer radii.")]]


class Tool(Record):
    """wpcal tool centre point, version 1

    A tool centre point from touches of one fixed point (`wpcal tcp`). Lengths in mm.
    """

    schema: Literal["wpcal/tool/1"]
    robot: str = D("Name of the arm.")
    robot_space: Literal["nominal", "identified"] = D("Robot model behind the tool centre point.")
    names: list[str] = D("Names of the touches, in the order of distances_mm.")
    xyz_mm: Vector = D("Tip in the flange frame.")
    error_95_mm: NotNegative = D("Length that the error of the tip stays below in 95 of 100 repetitions.")
    rms_mm: NotNegative = D("Root mean square distance of the touches from their common point.")
    distances_mm: list[NotNegative] = D("Distance of each touch from their common point.")
    p_base_mm: Vector = D("The touched point in the base.")


class Verdict(Record):
    improved: bool = D("Whether the identified arm is better on poses that were not fitted.")
    chance: Share = D("Probability of such a gain by luck.")
    reasons: list[str] = D("Why not, if not.")


class DistanceMm(Record):
    mean: NotNegative
    rms: NotNegative = D("Root mean square.")
    largest: NotNegative
    percentile_95: NotNegative


class Summary(Record):
    distance_mm: DistanceMm = D("In mm.")
    turn_deg: DistanceMm | None = D("Null if only positions were measured.")


class TestPoses(Record):
    before: Summary
    after: Summary


class Rows(Record):
    train: list[Count]
    test: list[Count]


class Error(Record):
    row: Count
    before_mm: NotNegative
    after_mm: NotNegative
    before_deg: Maybe[NotNegative]
    after_deg: Maybe[NotNegative]


class Noise(Record):
    sigma_mm: NotNegative = D("Standard deviation of a measured coordinate.")
    sigma_deg: NotNegative | None = D("Of a measured angle; null if only positions were measured.")
    estimated: bool = D("Estimated from the fit, not stated by the user.")


class Parameter(Record):
    name: str = D("Symbol and number of the link.")
    unit: Literal["mm", "deg"]
    nominal: float
    identified: float
    change: float
    half_width_95: NotNegative | None = D("Half width of the 95 % interval; null after ga-tabu.")
    absorbs: list[str] = D("Unseen parameters whose error this one absorbs; its interval holds their error.")


class Unseen(Record):
    name: str
    like: list[str] = D("Parameters with the same effect.")


class Correlation(Record):
    first: str
    second: str
    value: Annotated[float, Meta(ge=-1, le=1)]


class Transform(Record):
    target: str
    source: str
    xyz_mm: Vector = D("Translation in target, mm.")
    R: Rotation = D("Rotation matrix by rows.")


class Genetic(Record):
    cost_mm: NotNegative
    evaluations: Count


class Tabu(Record):
    cost_mm: NotNegative
    evaluations: Count
    forbidden: Count = D("Moves refused by the tabu list.")
    aspired: Count = D("Refused moves taken because they were the best so far.")


class Search(Record):
    genetic: Genetic
    tabu: Tabu


class Outlier(Record):
    rows: list[int] = D("Lines of the file.")
    distance_mm: float = D("Distance from what the other poses give, mm.")
    turn_deg: float | None = D("Angle from what the other poses give, degrees; null where only places were measured.")
    held_back: bool = D("Whether the pose was kept back for the test.")


class ErrorField(Record):
    amplitude_mm: NotNegative = D("Standard deviation per axis of the smooth errors.")
    length_mm: Positive = D("Distance over which they change.")
    rest_mm: NotNegative = D("Standard deviation per axis of what is independent from pose to pose.")


class ErrorFields(Record):
    nominal: ErrorField | None
    identified: ErrorField | None


class WholeRange(Record):
    nominal_mm: NotNegative = D("Predicted root mean square error of the nominal arm.")
    identified_mm: NotNegative = D("The same of the identified arm.")
    is_better: bool = D("Whether the identified arm is better with 95 % confidence. If not, nothing is identified.")


class ParameterCovariance(Record):
    names: list[str]
    values_mm_rad: list[list[float]]


class CellErrors(Record):
    """wpcal errors of a cell, version 1

    Errors of touches and robot over the jobs of a cell (wpcal drift --cell-errors). Lengths in mm.
    """

    schema: Literal["wpcal/cell-errors/1"]
    jobs: Count = D("How many jobs were used.")
    sigma_mm: Positive = D("Standard deviation per axis of a touch: its scatter from job to job.")
    error_field: ErrorFields = D("Smooth error of the robot: what the residuals of all jobs have in common.")
    tool: Maybe[ToolError] = D("Missing where too few jobs say how the tool was turned, or turned it too little.")


class JointRange(Record):
    least: list[float]
    most: list[float]


class Identification(Record):
    """wpcal identification, version 1

    Identified parameters of a robot and their test (identification.json). Lengths in mm, angles in degrees.
    """

    schema: Literal["wpcal/identification/1"]
    robot: str
    robot_space: Space
    solver: Literal["least-squares", "ga-tabu"]
    error_field: Maybe[ErrorFields] = D(
        "Smooth position errors of the test poses; null for few poses. For wpcal calibrate --robot-mm."
    )
    whole_range: Maybe[WholeRange] = D("Position errors over all poses within the limits of the joints.")
    covariance: Maybe[ParameterCovariance] = D("Of the parameters, with base, tool and reflectors; mm and rad.")
    joints_deg: Maybe[JointRange] = D("Range of each joint among the fitted poses. Outside it nothing is shown.")
    seed: int
    folds: Annotated[int, Meta(ge=2)] | None = D(
        "Number of parts of the measurements in cross-validation: each part is tested once. Null: one part is tested."
    )
    verdict: Verdict
    test_poses: TestPoses = D("Errors on poses that were not fitted.")
    rows: Rows = D("Rows of the measurement file.")
    errors: list[Error] = D("Errors of the test poses.")
    rank: Count = D("Combinations of parameters that the poses determine.")
    asked: Count = D("Number of parameters asked for.")
    condition: NotNegative = D("Condition number of the fit.")
    iterations: Count
    converged: bool
    noise: Noise
    parameters: list[Parameter]
    unseen: list[Unseen] = D("Parameters that the poses do not determine.")
    correlations: list[Correlation] = D("Strongly correlated parameters.")
    T_measurement_base: Transform | None = D("Robot base in the frame of the measurement; null if not asked for.")
    T_flange_tool: Transform | None = D("Measured body on the flange; null if it was not asked for or not measured.")
    reflectors_flange_mm: dict[str, Vector] | None = D(
        "Measured points on the flange, by name; null if they were not asked for."
    )
    search: Search | None = D("Genetic and tabu search; null for least squares.")
    issues: list[Issue]
    outliers: list[Outlier] = D("Poses that the others contradict.")
    left_out: list[int] = D("Lines of the file that were left out on request.")


class Expected95(Record):
    parameter: str
    unit: Literal["mm", "deg"]
    half_width_95: NotNegative


class PosePlan(Record):
    """wpcal poses to measure, version 1

    The poses that determine an arm's parameters best (wpcal identify --plan --json).
    """

    schema: Literal["wpcal/pose-plan/1"]
    robot: str = D("Name of the arm.")
    poses_deg: list[list[float]] = D("Shown joint angles of each pose, in an order with short moves.")
    observability: float = D("O1 (Borm, Menq 1991) of the set.")
    random_observability: float = D("O1 of as many random poses (mean of twenty).")
    expected_95: list[Expected95] = D(
        "Half width of the 95 % interval to expect of each parameter with the noise of a laser tracker."
    )


class Point(Record):
    name: str
    p_base_mm: Vector
    shift_mm: Vector = D("The point minus the one of the nominal arm, in the base.")
    rx_ry_rz_deg: Vector = D("Posture of the tool in the base, R = Rz Ry Rx.")


class Corrected(Record):
    """wpcal corrected points, version 1

    Taught joint angles as points of an identified robot (wpcal correct --json). Lengths in mm.
    """

    schema: Literal["wpcal/corrected/1"]
    robot: str = D("Name of the arm.")
    robot_space: Literal["nominal", "identified"] = D("Robot model behind the points.")
    tcp_bias_mm: NotNegative = D("Error of the tool centre point that all points share (95 %); 0 if none is known.")
    points: list[Point]
    issues: list[Issue]
